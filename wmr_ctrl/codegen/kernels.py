"""The kernels of one closed loop: which graphs become C, under which names."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import casadi as ca

from wmr_ctrl.codegen.emit import Kernel, kernel
from wmr_ctrl.control.controller import watched_controller
from wmr_ctrl.model.estimator import estimator
from wmr_ctrl.model.parameters import Parameters
from wmr_ctrl.model.plant import plant, rk4_step
from wmr_ctrl.model.reference import reference
from wmr_ctrl.model.system import System, values
from wmr_ctrl.model.tracking import tracking_error
from wmr_ctrl.scenario import Scenario


@dataclass(frozen=True)
class LoopSystems:
    """The Systems of one closed loop, by role: reference, plant, controller, estimator."""

    reference: System
    plant: System
    controller: System
    estimator: System

    def by_role(self) -> Mapping[str, System]:
        """The four Systems under the prefixes that C and the manifest use."""
        return {
            "reference": self.reference,
            "plant": self.plant,
            "controller": self.controller,
            "estimator": self.estimator,
        }


def loop_systems(scenario: Scenario, law: str) -> LoopSystems:
    """Systems of ``law`` on ``scenario``; the plant's parameters end with its step [s]."""
    return LoopSystems(
        reference(scenario),
        _stepped_plant(scenario),
        watched_controller(scenario, law),
        estimator(scenario),
    )


def loop_kernels(systems: LoopSystems) -> tuple[Kernel, ...]:
    """All C functions that the runtime calls."""
    pose_d, pose = ca.SX.sym("pose_d", 3), ca.SX.sym("pose", 3)
    ref, moving, law, dead = systems.reference, systems.plant, systems.controller, systems.estimator
    return (
        kernel(
            "reference", "Desired trajectory at time t.", {"t": ref.u, "p": ref.p}, {"y": ref.y}
        ),
        kernel(
            "plant_step",
            "Plant state after one Runge-Kutta step, inputs held.",
            {"u": moving.u, "x": moving.x, "p": moving.p},
            {"next": moving.update},
        ),
        kernel(
            "controller_step",
            f"One sample of the law: {law.title}.",
            {"u": law.u, "x": law.x, "p": law.p},
            {"next": law.update, "y": law.y},
        ),
        kernel(
            "controller_diagnostics",
            "What the law publishes beside its torques.",
            {"u": law.u, "x": law.x, "p": law.p},
            {"d": law.d},
        ),
        kernel(
            "controller_logged",
            "Both at once, which costs little more than the sample alone.",
            {"u": law.u, "x": law.x, "p": law.p},
            {"next": law.update, "y": law.y, "d": law.d},
        ),
        kernel(
            "controller_watched",
            "One sample, and what is watched in every run: clip_active (2), d_least (2).",
            {"u": law.u, "x": law.x, "p": law.p},
            {"next": law.update, "y": law.y, "w": _watched(law)},
        ),
        kernel(
            "estimator_step",
            f"{dead.title.capitalize()}.",
            {"u": dead.u, "x": dead.x, "p": dead.p},
            {"next": dead.update},
        ),
        kernel(
            "tracking_error",
            "Tracking error, Eq. (8).",
            {"pose_d": pose_d, "pose": pose},
            {"e": tracking_error(pose_d, pose)},
        ),
    )


def _watched(law: System) -> ca.SX:
    seen = {item.signal.name: item.expr for item in law.diagnostics}
    return ca.vertcat(seen["clip_active"], seen["d_least"])


def plant_phases(scenario: Scenario, system: System) -> list[tuple[int, list[float]]]:
    """(first plant step, parameter values) of each phase: the start, then every Change."""
    current = dict(zip((p.signal.name for p in system.params), system.params, strict=True))
    numbers = {name: port.value for name, port in current.items()}
    phases = [(0, values(system.params))]
    for change in scenario.changes:
        named = {f"robot.{key}": getattr(change, key) for key in ("m", "I", "mu")}
        numbers |= {key: (value,) for key, value in named.items() if value is not None}
        first = _first_step_at(change.t, scenario.clock.plant)
        phases.append((first, [number for row in numbers.values() for number in row]))
    return phases


def _first_step_at(time: float, step: float) -> int:
    """Index of the first plant step that starts at or after ``time``."""
    index = round(time / step)
    return index if abs(index * step - time) <= 1e-9 * max(1.0, time) else int(-(-time // step))


def _stepped_plant(scenario: Scenario) -> System:
    continuous = plant(scenario)
    p = Parameters(scenario, continuous.params)
    step = rk4_step(continuous, p.take("clock.plant"))
    return System(
        continuous.name,
        continuous.title,
        continuous.inputs,
        continuous.state,
        p.ports,
        step,
        continuous.outputs,
        period=scenario.clock.plant,
    )
