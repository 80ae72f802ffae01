"""Margins: how much gain, phase, delay and model error the loop tolerates at each generalised
force.

The loop is cut at one force at a time, with the other axis closed and the robot on its reference.
Margins are statements about that point: they do not show the barrier at all.
"""

import math
from collections.abc import Callable
from dataclasses import asdict, dataclass, fields, replace
from itertools import pairwise, product

import control as ct
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from wmr_ctrl.core.fields.arguments import checks_arguments
from wmr_ctrl.theory.checks.stable_ranges import largest_stable_period
from wmr_ctrl.world.scenario import Model, Scenario, override
from wmr_ctrl.world.speed_loop import has_loop
from wmr_ctrl.world.speed_loops import assumed_lags

from .linearise import (
    STATES,
    Floats,
    Point,
    check_axis,
    is_stable,
    on_reference,
    sent_names,
    unguarded,
)
from .state_space import late, law_at, plant_at, with_inputs

LOWEST, POINTS = 1e-3, 1000
HIGHEST = 1e5
"""Frequencies of the search [rad/s]; sampled loops end at the Nyquist frequency."""
FACTORS = (0.5, 1.5)
PARAMETERS = ("m", "I", "mu")
OWN = {"first-order": "tau", "second-order": "frequency"}
"""Parameter that may be wrong for a loop that compensates mass and friction."""


@dataclass(frozen=True)
class Margins:
    """Margins at one generalised force; None if there is no such margin.

    ``gain`` upwards and ``gain_down`` downwards [ratio], ``phase`` [degrees], ``delay`` [s],
    ``disk`` (alpha of the balanced disk), ``disk_gain`` [ratio], ``disk_phase`` [degrees].
    """

    gain: float | None
    gain_down: float | None
    phase: float | None
    delay: float | None
    disk: float | None
    disk_gain: float | None
    disk_phase: float | None

    def as_dict(self) -> dict[str, float | None]:
        """All of them by name."""
        return asdict(self)


@checks_arguments
def open_loop(
    scenario: Scenario, law: str, axis: int, point: Point | None = None, period: float | None = None
) -> ct.StateSpace:
    """The loop cut at force ``axis`` (0 thrust, 1 moment) as a negative-feedback loop L.

    L goes from the force on the robot to minus the force that the law then commands; the other axis
    stays closed.  Continuous, without delay and late sensors, which no differential equation can
    describe, or sampled with ``period`` [s], with all of them; python-control's `margin` needs
    ``method="frd"`` for these.  Raises ArgumentError for an invalid axis or period.
    """
    check_axis(axis)
    at = on_reference(scenario, law) if point is None else point
    names = sent_names(scenario)
    plant = with_inputs(plant_at(scenario, at, period), names)
    controller = law_at(scenario, law, at, period)
    cut, asked = names[axis], f"asked[{axis + 1}]"
    renamed = [asked if name == cut else name for name in names]
    controller = ct.ss(controller, name="law", inputs=STATES, outputs=renamed)
    loop = ct.interconnect([plant, controller], inputs=[cut], outputs=[asked], name=f"L{axis + 1}")
    return ct.ss(-loop, name=f"L{axis + 1}", inputs=[cut], outputs=[asked])


@checks_arguments
def margins_at(
    scenario: Scenario, law: str, axis: int, point: Point | None = None, period: float | None = None
) -> Margins | None:
    """Margins at force ``axis``; None if the closed loop is unstable."""
    loop = open_loop(scenario, law, axis, point, period)
    if not is_stable(ct.feedback(loop, 1).poles(), bool(loop.dt)):
        return None
    limits, alpha = crossings(loop, frequencies(loop)), disk(loop)
    disk_gain = (2 + alpha) / (2 - alpha) if alpha < 2 else math.inf
    up, down = limits.gains[limits.gains > 1], limits.gains[limits.gains < 1]
    return Margins(
        _finite(up.min(initial=math.inf)), _finite(down.max(initial=-math.inf)),
        _finite(np.abs(limits.phases).min(initial=math.inf)),
        _finite(limits.delays.min(initial=math.inf)),
        _finite(alpha), _finite(disk_gain), math.degrees(2 * math.atan(alpha / 2)),
    )  # fmt: skip


def disk(loop: ct.StateSpace) -> float:
    """Balanced disk margin alpha: the least 1 / |S - 1/2| of the sensitivity S = 1 / (1 + L).

    The worst frequency is searched on a grid, then near the best of the grid.
    """

    def alphas(at: Floats) -> Floats:
        return 1 / np.abs(1 / (1 + response(loop, at)) - 0.5)

    grid = frequencies(loop)
    near = grid[int(np.argmin(alphas(grid)))] * np.geomspace(0.97, 1.03, 400)
    return float(alphas(near[near <= grid[-1]]).min())


def response(loop: ct.StateSpace, frequencies: Floats) -> NDArray[np.complex128]:
    """Frequency response of a single loop at all ``frequencies`` [rad/s]."""
    on = (np.exp(1j * frequencies * loop.dt) if loop.dt else 1j * frequencies)[:, None, None]
    states = np.linalg.solve(on * np.eye(len(loop.A)) - loop.A, loop.B + 0j)
    return np.asarray((loop.C @ states + loop.D)[:, 0, 0])


def frequencies(loop: ct.StateSpace) -> Floats:
    """Frequencies [rad/s] at which the disk margin is searched."""
    top = math.pi / loop.dt if loop.dt else HIGHEST
    return np.geomspace(LOWEST, top * (1 - 1e-9), POINTS)


def worst(given: list[Margins | None]) -> Margins | None:
    """The smallest margin of each kind over the axes; None if one axis is unstable."""
    if any(item is None for item in given):
        return None
    margins = {}
    for item in fields(Margins):
        smaller = max if item.name == "gain_down" else min
        known = (getattr(one, item.name) for one in given)
        values = (value for value in known if value is not None)
        margins[item.name] = smaller(values, default=None)
    return Margins(**margins)


@checks_arguments
def with_robot(scenario: Scenario, m: float = 1.0, I: float = 1.0, mu: float = 1.0) -> Scenario:
    """The scenario with scaled mass, inertia and friction of the robot; the laws' model stays."""
    robot, believed = scenario.robot, scenario.believed
    other = replace(robot, m=m * robot.m, I=I * robot.I, mu=mu * robot.mu)
    return replace(scenario, robot=other, model=Model(m=believed.m, I=believed.I, mu=believed.mu))


def _finite(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None


@dataclass(frozen=True)
class Crossings:
    """Gain factors [ratio], phases [degrees] and delays [s] that bring the loop to its limit."""

    gains: Floats
    phases: Floats
    delays: Floats


def crossings(loop: ct.StateSpace, frequencies: Floats) -> Crossings:
    """All crossings of a single loop L within the range of ``frequencies`` [rad/s]."""

    def at(w: float) -> complex:
        return complex(response(loop, np.array([w]))[0])

    values = response(loop, frequencies)
    unit = _roots(lambda w: math.log(abs(at(w))), frequencies, np.log(np.abs(values)))
    real = _roots(lambda w: at(w).imag, frequencies, values.imag)
    ahead = np.array([np.angle(-at(w)) for w in unit])
    # A sampled loop is real at z = -1, where its response ends.
    nyquist = [complex(np.squeeze(loop(-1.0 + 0j))).real] if loop.dt else []
    axis = np.array([at(w).real for w in real] + nyquist)
    delays = np.array([a % (2 * math.pi) / w for a, w in zip(ahead, unit, strict=True)])
    return Crossings(-1 / axis[axis < 0], np.degrees(ahead), delays)


def _roots(of: Callable[[float], float], grid: Floats, values: Floats) -> list[float]:
    signs = np.signbit(values)
    pairs = [pair for k, pair in enumerate(pairwise(grid)) if signs[k] != signs[k + 1]]
    return [float(brentq(of, low, high, rtol=1e-12)) for low, high in pairs]


@dataclass(frozen=True)
class ModelError:
    """Margins if one parameter of the robot is multiplied by ``factor``, with the law's model
    unchanged.

    Phase margin [degrees] and disk margin of the worse force; None if the loop is unstable.
    """

    parameter: str
    factor: float
    stable: bool
    phase: float | None
    disk: float | None
    max_sample_time: float


def model_errors(scenario: Scenario, law: str, t: float = 0.0) -> list[ModelError]:
    """Margins with mass, inertia and friction 50 % lower and higher, one at a time, at time ``t``
    [s].

    For a first- or second-order speed loop, which compensates these, its tau or frequencies are
    changed instead. The margins are those of the continuous loop, or of the sampled one if drives
    or sensors are late.
    """
    period, errors = scenario.clock.control if late(scenario) else None, []
    own = [of for loop, of in OWN.items() if has_loop(scenario, loop)]  # mass is made up for
    for parameter, factor in product(own or PARAMETERS, FACTORS):
        other = unguarded(scenario)
        if own:
            numbers = [factor * value for value in scenario.value(f"base.{parameter}")]
            bare = {"filter.kind": "none", "base.tau_believed": assumed_lags(scenario)}
            other = override(other, {f"base.{parameter}": numbers, **bare})
        else:
            other = with_robot(other, **{parameter: factor})
        point = on_reference(other, law, t)
        smallest = worst([margins_at(other, law, axis, point, period) for axis in (0, 1)])
        figures = (smallest.phase, smallest.disk) if smallest else (None, None)
        limit = largest_stable_period(other, law)
        errors.append(ModelError(parameter, factor, smallest is not None, *figures, limit))
    return errors
