"""Numbers of one benchmark: the law's knowledge (`Setup`) and the simulated case (`Case`).

The defaults are the paper's simulation (Section V), so that nothing else is needed to build and
check the floor; `from_scenario` takes a Scenario's numbers instead.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

Pair = tuple[float, float]


@dataclass(frozen=True)
class Setup:
    """The robot as the law believes it, limits, gains and control period; fields as in hand.h."""

    m: float = 50.0
    inertia: float = 5.4
    mu: float = 0.08
    r: float = 0.1
    l: float = 0.25
    g: float = 9.81
    v_s: float = 0.01
    k: tuple[float, float, float] = (10.0, 5.0, 4.0)
    v_u1: Pair = (1.0, 1.5)
    v_u2: Pair = (0.8, 1.3)
    clip: float = 1e-6
    mb_rho: Pair = (15.0, 57.6)
    nn_rho1: Pair = (1350.0, 21.6)
    nn_gamma: Pair = (20000.0, 800.0)
    nn_sigma: Pair = (1e-4, 1e-4)
    nn_eta: float = math.sqrt(2.0)
    nn_ratio_cap: float = 1e3
    period: float = 0.01

    @staticmethod
    def from_scenario(scenario: Any) -> Setup:
        """Numbers of a `wmr_ctrl.world.scenario.Scenario`, with the laws' defaults where it is
        silent.
        """
        from wmr_ctrl.control.setup import settle

        robot, limits = scenario.believed, scenario.limits
        mb, nn = (settle(scenario, law).gains for law in ("mb", "nn"))
        _require(
            nn.node == 1 and nn.integrator == "explicit" and math.isinf(scenario.actuator.tau_max),
            f"the hand-written laws cannot follow the scenario {scenario.name!r}: they know nodes "
            "at +-1, the explicit Euler step of the weights and no torque limit.",
        )
        return Setup(
            robot.m, robot.I, robot.mu, robot.r, robot.l, robot.g, robot.v_s,
            settle(scenario, "mb").kinematics.k, limits.v_u1, limits.v_u2, limits.clip,
            mb.rho, nn.rho1, nn.Gamma, nn.sigma, nn.eta, nn.ratio_cap,
            scenario.clock.control,
        )  # fmt: skip


@dataclass(frozen=True)
class Case:
    """One closed loop on the circle; the robot changes once, at ``t_change`` [s] (inf: never).

    ``initial`` is x, y, theta, v1, omega; ``first`` and ``later`` are m [kg], I [kg m2], mu [1]
    before and after the change.  ``period`` of the Setup must equal ``control`` [s].
    """

    initial: tuple[float, ...] = (-0.5, -0.5, -0.7, 0.0, 0.0)
    radius: float = 2.0
    rate: float = 0.1
    control: float = 0.01
    plant: float = 0.001
    duration: float = 80.0
    noise_std: float = 1.0
    t_change: float = 40.0
    first: tuple[float, float, float] = (50.0, 5.4, 0.08)
    later: tuple[float, float, float] = (65.0, 7.0, 0.15)
    seed: int = 0

    @property
    def samples(self) -> int:
        """Number of control steps."""
        return round(self.duration / self.control)

    @property
    def substeps(self) -> int:
        """Plant steps in one control step."""
        return round(self.control / self.plant)

    @staticmethod
    def from_scenario(scenario: Any, seed: int = 0) -> Case:
        """Numbers of a Scenario that this loop can run: a circle, at most one change, no extras."""
        from wmr_ctrl.world.references import Circle

        reference, robot, clock = scenario.reference, scenario.robot, scenario.clock
        _require(
            isinstance(reference, Circle) and len(scenario.changes) < 2 and _plain(scenario),
            f"the hand-written loop cannot run the scenario {scenario.name!r}: it knows the "
            "circle, perfect sensors, ideal actuators, plain Gaussian noise and up to one change.",
        )
        first = (robot.m, robot.I, robot.mu)
        change = scenario.changes[0] if scenario.changes else None
        later = first if change is None else _changed(first, (change.m, change.I, change.mu))
        return Case(
            (*scenario.initial.pose, *scenario.initial.velocity), reference.radius, reference.rate,
            clock.control, clock.plant, clock.duration, scenario.disturbance.std,
            math.inf if change is None else change.t, first, later, seed,
        )  # fmt: skip


def _plain(scenario: Any) -> bool:
    sensor = scenario.sensor
    exact = sensor.perfect and not any(sensor.velocity_noise)
    return exact and scenario.actuator.ideal and math.isinf(scenario.disturbance.truncate)


def _require(condition: bool, message: str) -> None:
    from wmr_ctrl.core.errors import ArgumentError

    if not condition:
        raise ArgumentError(message)


def _changed(
    first: tuple[float, float, float], new: tuple[float | None, ...]
) -> tuple[float, float, float]:
    m, inertia, mu = (old if n is None else n for old, n in zip(first, new, strict=True))
    return m, inertia, mu
