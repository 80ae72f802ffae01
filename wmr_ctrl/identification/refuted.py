"""Bounds for a guard from a log, and contradictions within the log.

Contradictions are motion in the last third that the bounds from the rest do not explain, by the
guard's own monitor, and numbers that changed.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from itertools import product

import casadi as ca
import numpy as np
from scipy.special import stdtrit

from wmr_ctrl.control.guard.bounds import pair_of
from wmr_ctrl.control.guard.guard import Bounds
from wmr_ctrl.control.guard.monitor import least_push
from wmr_ctrl.control.guard.price import speed_price
from wmr_ctrl.control.setup import settle
from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.world.encoder import rounded_by
from wmr_ctrl.world.scenario import Scenario

from .bounds import UNITS, GuardBounds
from .estimate import cut_of, fitted_part
from .fit import LAG_LEAST, Fit, Fitted, at_rest, changes, intervals_of
from .kalman import BLOCKS, INDEX, NAMES
from .logs.log import Floats, Pair, Texts, usual_step
from .logs.samples import Samples
from .written import four_digits, outward

SPANS = (0.0, 0.1, 0.2, 0.4, 0.8)
"""Halves of the windows over which the guard's monitor looks at a log [s]; 0: one sample."""
LATE_POINTS = 5, 3
"""Delays and lags in their intervals for which the force that acted is worked out."""
CONSTANT = ("m", "I", "delay")
"""Numbers that must not change within a log."""
CREEP, CREEP_LAG = 0.01, 0.005
"""Delay and lag [s] that creeping tread may hide from any log of wheels: m/(2 C) for 30 kg on tyres
of 1500 N s/m, and the mean error of fits of such logs."""
SIGMAS = 3.0
NEWTON = 1.0


def guard_bounds(
    white: Fit,
    intervals: Mapping[str, tuple[float, float, float]],
    scenario: Scenario,
) -> GuardBounds:
    """The guard's numbers from the intervals (value, low, high) and the white fit's residuals.

    dbar is q max(3, max |z|) per axis: q the rms force noise of the white fit, z the standardised
    residuals.
    """
    log = white.problem.log
    q = np.exp(white.theta[[INDEX["q1"], INDEX["q2"]]])
    z = np.abs(white.last.sizes[white.problem.counts])
    dbar = q * np.maximum(SIGMAS, z.max(axis=0))
    wider = stdtrit(BLOCKS - 1, 1 - 0.05 / 4) / stdtrit(BLOCKS - 1, 0.975)
    value, least, most = np.array([intervals["m"], intervals["I"]]).T
    low, high = value * (least / value) ** wider, value * (most / value) ** wider
    period, robot = scenario.clock.control, scenario.robot
    v, w = np.abs(white.last.mean[:, 2:4]).max(axis=0)
    if log.of_speed:
        noise = np.exp(white.theta[[INDEX["n1"], INDEX["n2"]]])
        nbar = noise * np.maximum(SIGMAS, z.max(axis=0))
    else:
        counts = float(scenario.value("encoder.counts")[0])
        nbar = np.array(rounded_by((robot.r, robot.l), counts, period))
    early, latest = max(intervals["delay"][1], 0.0), intervals["delay"][2]
    # The guard lets a delay vary by one control period at most.
    wide = latest - early > period
    late = (early, latest) if wide else (early, min(latest + CREEP, early + period))
    lightest, heaviest, pushes, noises = (
        (four_digits(float(first), up), four_digits(float(second), up))
        for (first, second), up in ((low, False), (high, True), (dbar, True), (nbar, True))
    )
    return GuardBounds(
        lightest,
        heaviest,
        pushes,
        noises,
        late,
        outward(max(intervals["lag"][1], 0.0), intervals["lag"][2] + CREEP_LAG),
        (float(q[0]), float(q[1])),
        (
            f"largest push that was seen in {log.t[-1] - log.t[0]:.3g} s, at speeds up to {v:.2g} "
            f"m/s and {w:.2g} rad/s, on this floor, with this load: no bound that is proved"
        ),
        wide,
    )


def usable_speeds(scenario: Scenario) -> Pair | None:
    """Usable speed of v1 with the guard's numbers, and its loss per further newton of dbar [m/s].

    None if the guard refuses the numbers.
    """
    try:
        numbers = settle(scenario, None).guard
    except ScenarioError:
        return None
    more = replace(numbers, dbar=(pair_of(numbers.dbar)[0] + NEWTON, pair_of(numbers.dbar)[1]))
    now, then = (speed_price(scenario, item).usable[0] for item in (numbers, more))
    return now, now - then


def held_out(white: Fit, fit: Fit, scenario: Scenario) -> tuple[Fit, Texts]:
    """The white fit of the first two thirds, and sentences on contradictions: motion of the last
    third beyond these bounds, and numbers that changed.

    ``white`` and ``fit`` are of the whole log; ``scenario`` has its clock.
    """
    cut = cut_of(white.problem.log)
    before = fitted_part(fit, cut)
    trained = before if (fit.free == white.free).all() else fitted_part(white, cut)
    bounds = guard_bounds(trained, intervals_of(before), scenario)
    unexplained = [item.against(bounds) for item in contradictions(white, bounds, cut)]
    return trained, (*changed(fit), *unexplained)


def changed(fit: Fit) -> Iterator[str]:
    """Sentences on a mass, an inertia or a delay that changed during the log."""
    fitted = Fitted(fit.theta, fit.inside, fit.last.gradient, fit.last.fisher)
    for name, change in changes(fitted, NAMES, fit.problem.log).items():
        if name not in CONSTANT:
            continue
        sides = []
        for x, half in zip(change.values, change.halves, strict=True):
            ends = np.array([x, x - half, x + half])
            ends = ends if name == "delay" else np.exp(ends)
            sides.append("{:.3g} ({:.3g} to {:.3g})".format(*ends))
        before, after = (f"{side} {UNITS[name]}" for side in sides)
        yield f"{name} was {before} until about {change.time:.3g} s and {after} after it"


@dataclass(frozen=True)
class Unexplained:
    """Motion that the bounds do not explain: axis (0, 1), end ``t`` and length ``window`` [s].

    ``push`` [N, N m] is the smallest dbar that would explain it.
    """

    axis: int
    t: float
    window: float
    push: float

    def against(self, bounds: GuardBounds) -> str:
        """The motion and the bounds that it contradicts, in a sentence."""
        speed, unit = (("v1", "N"), ("omega", "N m"))[self.axis]
        return (
            f"at {self.t:.4g} s {speed} changed over {self.window:.2g} s as no push of "
            f"guard.dbar[{self.axis + 1}] = {bounds.dbar[self.axis]:.3g} {unit} explains with "
            f"these masses, this delay and this lag; it takes {self.push:.3g} {unit}"
        )


def contradictions(
    white: Fit, bounds: GuardBounds, begin: float = -np.inf
) -> tuple[Unexplained, ...]:
    """Per axis the largest motion after ``begin`` [s] that these bounds do not explain, if any.

    The guard's monitor (`guard.monitor.least_push`) runs over windows instead of its period: it
    gets mean velocities of neighbouring halves, and those that commands alone would give to a mass
    of 1 without friction, for all delays and lags in their intervals.  Friction explains no gain in
    speed while an axis keeps its direction.
    """
    log, largest = white.problem.log.until(np.inf, begin), []
    forced = list(_unit_motions(white, bounds, log))
    for axis in (0, 1):
        t, window, push = np.hstack([_pushes(log, x, axis, bounds, forced) for x in SPANS])
        if push.max(initial=0.0) > bounds.dbar[axis]:
            at = int(np.argmax(push))
            largest.append(Unexplained(axis, float(t[at]), float(window[at]), float(push[at])))
    return tuple(largest)


def explaining(white: Fit, bounds: GuardBounds) -> GuardBounds:
    """The bounds, with dbar enlarged so that the guard's monitor accepts the whole log."""
    dbar = list(bounds.dbar)
    for item in contradictions(white, bounds):
        dbar[item.axis] = four_digits(item.push * (1 + 1e-9), up=True)
    return replace(bounds, dbar=(dbar[0], dbar[1]))


def _unit_motions(white: Fit, bounds: GuardBounds, log: Samples) -> Iterator[Floats]:
    """Paths and speeds (N, 4) of mass and inertia 1 without friction, driven by the commands alone.

    Their gain in speed is the force that acted, by the filter's own graph, for one delay and lag
    each.
    """
    free = dict.fromkeys(("m", "I", "Fc", "Fv", "c", "Mv"), 0.0)
    lags = max(bounds.lag[0], LAG_LEAST), max(bounds.lag[1], LAG_LEAST)
    for pair in product(*map(np.linspace, *zip(bounds.delay, lags, strict=True), LATE_POINTS)):
        values = free | dict(zip(("delay", "lag"), pair, strict=True))
        theta = np.array([values.get(n, x) for n, x in zip(NAMES, white.theta, strict=True)])
        yield white.problem.foretold(log, theta, at_rest(log))[:, :4]


def _pushes(
    log: Samples, span: float, axis: int, bounds: GuardBounds, forced: Sequence[Floats]
) -> Floats:
    """Ends, lengths [s] and least pushes (3, K) of windows in which an axis keeps its direction.

    A window is two halves of ``span`` [s] each; speeds are means over half a window.  The push is
    monotonic in the force that acted, so the least push is at an end of the forces' range.
    """
    t, step = log.t, np.diff(log.t, prepend=log.t[0])
    n = max(1, round(span / usual_step(t)))
    i = np.flatnonzero(log.stretches[1] - np.arange(len(t)) >= 2 * n)[:: max(1, n // 4)]
    middle, last = i + n, i + 2 * n
    before, after = t[middle] - t[i], t[last] - t[middle]
    period, speed_off = (before + after) / 2, bounds.nbar[axis]
    # Each wheel's reading is off by less than a count, so both sums are by less than this.
    off = speed_off * step if log.of_speed else math.sqrt(24 * log.variance[axis])
    nbar = off * (1 / before + 1 / after) / 2 if not log.of_speed else speed_off + 0 * before

    def way(x: Floats) -> Floats:
        return np.cumsum(x * step) if log.of_speed else x

    def velocities(x: Floats) -> tuple[Floats, Floats]:
        return (x[middle] - x[i]) / before, (x[last] - x[middle]) / after

    seen = way(log.seen[:, axis])
    moved = np.diff(seen, prepend=seen[0])
    sums = np.cumsum(np.sign(moved) * (np.abs(moved) > off))
    one_way = np.abs(sums[last] - sums[i]) == 2 * n
    if not one_way.any():
        return np.zeros((3, 0))
    moves = [velocities(way(item[:, axis + 2 * log.of_speed])) for item in forced]
    forces = [(new - old) / period for old, new in moves]
    old, new = velocities(seen)
    pushes = [
        _monitor()(*np.stack((new, old, end, period, nbar))[:, None, one_way], *bounds.masses[axis])
        for end in (np.min(forces, axis=0), np.max(forces, axis=0))
    ]
    least = np.minimum(*map(np.asarray, pushes))[0]
    return np.stack((log.t[last][one_way], 2 * period[one_way], least))


@cache
def _monitor() -> ca.Function:
    """The guard's monitor of one axis: new, old velocity, force, period, nbar, masses."""
    v, old, force, period, nbar, least, most = (ca.SX.sym(name) for name in "vofTnab")
    none = ca.SX(0)
    b = Bounds(none, period, least, most, none, nbar, none, none, none, none)
    args = [v, old, force, period, nbar, least, most]
    return ca.Function("least", args, [least_push(v, old, force, b)])
