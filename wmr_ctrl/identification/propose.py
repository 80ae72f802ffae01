"""A drive that would determine the parameters that a log could not, inside limits and floor.

Tones and random steps of both speeds are simulated at corners of the intervals, with the plant's
graph and a plain loop, or with the base's own loop; of those that keep limits and floor the one of
most Fisher information is proposed, with what it would tell.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import product

import casadi as ca
import numpy as np

from wmr_ctrl.core.errors import ArgumentError
from wmr_ctrl.world.lag import followed
from wmr_ctrl.world.model.dynamics import force_to_wheel
from wmr_ctrl.world.model.evaluate import evaluated
from wmr_ctrl.world.scenario import Scenario

from .bounds import BaseIdentification, sizes, verdict
from .estimate import PHYSICAL
from .fit import Fit, LogProblem
from .identification import Identification
from .kalman import INDEX, LOGARITHMIC, NAMES, stepped
from .logs.log import Floats
from .logs.samples import AxisLog, Samples
from .speed_loop import (
    ORDER,
    PLACE,
    LoopFit,
    finest,
    foretold,
    set_of,
    whitener,
)
from .velocity_base import VelocityIdentification

TONES = (0.1, 0.25, 0.45, 0.7, 1.1, 1.6, 2.1)
"""Frequencies [Hz]: from turning about slowly to what delay and lag show in."""
SECONDS, FADE, HELD = 60.0, 2.0, 1.0
"""Length of a drive, of its rise and fall, and of a step [s]."""
DRAWS = 40
"""Drives of a kind that are drawn; the one that strays least is simulated."""
SHARE = 0.9
"""Largest speeds of a drive over [limits] v_u1; smaller until all corners keep limits and floor."""
SMALLER, TRIALS = 0.8, 12
STEP = 5e-3
CROSSOVER = 0.3
"""Crossover of the loop that follows the drive, as a share of 1/(delay + lag)."""
CORNERS = ("m", "I", "Fc", "c")
"""Parameters that are taken at both ends of their intervals; delay and lag at the later."""
LATE = ("delay", "lag")
FARTHEST = 3.0
"""Largest factor of a corner over the estimate: what is undetermined has no ends."""
WALKED = ("m", "I", "Fc", "Fv", "c", "Mv", "lag")
NORMAL = 1.96


@dataclass(frozen=True)
class ProposedDrive:
    """Speeds (N,) over t (N,) [s], the path at the estimate (N, 3), and what the corners showed.

    ``farthest`` [m] from the start and ``fastest`` [m/s, rad/s] of all corners; ``saturated``:
    share of samples at the torque limit; ``expected``: verdict by parameter, from the Fisher
    information alone.
    """

    t: Floats
    v: Floats
    omega: Floats
    path: Floats
    farthest: float
    fastest: tuple[float, float]
    saturated: float
    expected: Mapping[str, str]

    def to_csv(self) -> str:
        """Rows of t, v, omega and the path, with what the corners showed above them."""
        lines = [
            f"# simulated at corners of the intervals: {self.farthest:.3g} m from the start, "
            f"{self.fastest[0]:.3g} m/s, {self.fastest[1]:.3g} rad/s, {100 * self.saturated:.2g} % "
            "of the torques at their limit",
            "t [s],v [m/s],omega [rad/s],x [m],y [m],theta [rad]",
        ]
        table = np.column_stack((self.t, self.v, self.omega, self.path))
        return "\n".join([*lines, *(",".join(f"{x:.6g}" for x in row) for row in table), ""])


def propose(result: BaseIdentification, floor: float = 4.0) -> ProposedDrive:
    """A drive inside the scenario's limits and ``floor`` metres across, the start in its middle.

    Of a base that takes velocities it is what is to be commanded.  Raises ArgumentError where no
    drive fits.
    """
    if not floor > 0:
        raise ArgumentError(f"floor = {floor:g} m must be above 0.")
    t, kinds = _shapes(result.scenario.clock.control)
    drives = [_fitted(result, t, shapes, floor) for shapes in kinds]
    fitting = [item for item in drives if item is not None]
    if not fitting:
        raise ArgumentError(
            f"no drive of {SECONDS:g} s stays within {floor:g} m and the limits at every corner of "
            "the intervals. Give a larger --floor."
        )
    return max(fitting, key=lambda item: item[0])[1]


def _simulated(
    result: BaseIdentification, t: Floats, wanted: Floats
) -> tuple[float, ProposedDrive]:
    """Information, the logarithm of its determinant, and a drive (N, 2) at all corners."""
    if isinstance(result, VelocityIdentification):
        return _commanded(result, t, wanted)
    assert isinstance(result, Identification)
    limit = result.scenario.actuator.tau_max
    motion, torque = _followed_drive(result.scenario, _corners(result), wanted)
    share = float(np.mean(np.abs(torque) >= limit)) if math.isfinite(limit) else 0.0
    path = np.column_stack((motion[0, :, 4:6], motion[0, :, 1]))
    farthest = float(np.hypot(motion[:, :, 4], motion[:, :, 5]).max())
    speed = np.abs(motion[:, :, 2:4]).max(axis=(0, 1)).tolist()
    information, expected = _expected(result, motion[0], torque[0])
    shown = path, farthest, (speed[0], speed[1]), share, expected
    return information, ProposedDrive(t, wanted[:, 0], wanted[:, 1], *shown)


def _fitted(
    result: BaseIdentification, t: Floats, shapes: Floats, floor: float
) -> tuple[float, ProposedDrive] | None:
    """Information and drive of a kind, as large as limits and floor admit at all corners."""
    limits = np.array(result.scenario.limits.v_u1)
    most = SHARE * limits
    for _ in range(TRIALS):
        # Kinematics alone choose among the draws; the corners judge the choice.
        wanted = shapes * most
        # Largest distance from the start [m] of a drive that is followed exactly.
        strays = [float(np.hypot(*_path(t, *item.T)[:, :2].T).max()) for item in wanted]
        wanted = wanted[int(np.argmin(strays))]
        if min(strays) <= floor / 2:
            information, drive = _simulated(result, t, wanted)
            # A better loop than the one here follows exactly.
            farthest = max(min(strays), drive.farthest)
            if farthest <= floor / 2 and (np.array(drive.fastest) <= limits).all():
                return information, replace(drive, farthest=farthest)
        most = SMALLER * most
    return None


def _commanded(
    result: VelocityIdentification, t: Floats, wanted: Floats
) -> tuple[float, ProposedDrive]:
    """A base that is sent a drive: every corner of v's numbers with every one of omega's."""
    speeds: list[Floats] = []
    information, expected = 0.0, dict[str, str]()
    for axis, fit in enumerate(result.fits):
        known = fit or next(item for item in result.fits if item is not None)
        log = _sent(known.log, t, wanted[:, axis])
        corners = [list(known.values.values())]
        if fit is not None:
            ends = (_ends(result, f"{n}{axis + 1}", x) for n, x in fit.values.items())
            corners += [list(item) for item in product(*ends)]
        values = dict(zip(known.names, np.array(corners).T, strict=True))
        speeds.append(followed_by(log, known.loop, values))
        if fit is not None:
            own, verdicts = _told_by(fit, replace(log, speed=speeds[-1][:, 0]), axis)
            information, expected = information + own, expected | verdicts
    fastest = (float(np.abs(speeds[0]).max()), float(np.abs(speeds[1]).max()))
    ways = [[_path(t, v, omega) for omega in speeds[1].T] for v in speeds[0].T]
    farthest = max(float(np.hypot(*way[:, :2].T).max()) for row in ways for way in row)
    shown = ways[0][0], farthest, fastest, 0.0, expected
    return information, ProposedDrive(t, wanted[:, 0], wanted[:, 1], *shown)


def _ends(result: BaseIdentification, name: str, value: float) -> tuple[float, float]:
    """Ends of an interval, each no farther from the estimate than by FARTHEST."""
    item = result.parameters[name]
    least = 0.0 if name.startswith("delay") else value / FARTHEST
    size = max(value, result.scenario.clock.control)
    return max(item.low, least), max(min(item.high, FARTHEST * size), least)


def _sent(log: AxisLog, t: Floats, sent: Floats) -> AxisLog:
    """A log of commands alone, from rest."""
    rest = np.zeros(len(t))
    return AxisLog(t, rest, rest == 0, t, sent, np.array([0]), log.of_way, float(t[1] - t[0]))


def _told_by(fit: LoopFit, log: AxisLog, axis: int) -> tuple[float, dict[str, str]]:
    """Information of a drive on one axis in the noise of the log, and verdicts it would earn."""
    whole = information_of(fit, log)
    half = NORMAL * np.sqrt(np.diag(np.linalg.pinv(whole)))
    size = {"delay": max(fit.values["delay"], log.period)}
    verdicts = {
        f"{name}{axis + 1}": verdict(float(h), size.get(name, 1.0))
        for name, h in zip(fit.names, half, strict=True)
    }
    return float(np.linalg.slogdet(whole)[1]), verdicts


def _path(t: Floats, v: Floats, omega: Floats) -> Floats:
    """Path (N, 3) x, y, theta of speeds (N,)."""
    step = np.diff(t, append=2 * t[-1] - t[-2])
    turn = np.cumsum(omega * step) - omega * step
    middle = turn + omega * step / 2
    x, y = np.cumsum(-np.sin(middle) * v * step), np.cumsum(np.cos(middle) * v * step)
    return np.column_stack((x, y, turn))


def _corners(result: Identification) -> list[dict[str, float]]:
    """The robot as estimated, then with ends of the intervals, each no farther than by FARTHEST."""
    ends = {}
    for name, item in result.parameters.items():
        size = max(abs(item.value), result.scenario.clock.control if name in LATE else 0.0)
        least = size / FARTHEST if name in LOGARITHMIC else 0.0
        ends[name] = max(item.low, least), max(min(item.high, FARTHEST * size), least)
    values = {name: min(max(item.value, ends[name][0]), ends[name][1])
              for name, item in result.parameters.items()}  # fmt: skip
    late = {name: ends[name][1] for name in LATE}
    corners = product(*(ends[name] for name in CORNERS))
    return [values, *(values | late | dict(zip(CORNERS, c, strict=True)) for c in corners)]


def _shapes(period: float) -> tuple[Floats, list[Floats]]:
    """Times (N,) and drives by kind (DRAWS, N, 2) of largest size 1, at rest at both ends."""
    rng = np.random.default_rng(0)
    t: Floats = period * np.arange(round(SECONDS / period), dtype=np.float64)
    phase = rng.uniform(0, 2 * np.pi, (DRAWS, 1, 2, len(TONES)))
    tones = np.sin(2 * np.pi * np.array(TONES) * t[None, :, None, None] + phase).sum(axis=-1)
    levels = rng.uniform(-1, 1, (DRAWS, math.ceil(SECONDS / HELD), 2))
    steps = levels[:, (t / HELD).astype(int)]
    fade = np.clip(np.minimum(t, t[-1] - t) / FADE, 0, 1)
    smooth = (fade**2 * (3 - 2 * fade))[None, :, None]
    drives = [waves * smooth for waves in (tones, steps)]
    return t, [item / np.abs(item).max(axis=1, keepdims=True) for item in drives]


def _followed_drive(
    scenario: Scenario, robots: list[dict[str, float]], wanted: Floats
) -> tuple[Floats, Floats]:
    """Motions (R, N, 6) way, turn, v, omega, x, y and commanded torques (R, N, 2) at the samples.

    A proportional-integral loop on both speeds follows the drive, slow enough for every robot.
    """
    count, period, robot = len(robots), scenario.clock.control, scenario.robot
    inner, force_of = math.ceil(period / STEP), ca.SX.sym("force", 2)
    torque_of = force_to_wheel(ca.SX(robot.r), ca.SX(robot.l), force_of)
    wheels = ca.Function("wheels", [force_of], [torque_of]).map(count)
    step = _robot(scenario, inner).map(count)
    p = np.array([[item[name] for name in WALKED] for item in robots])
    queues = np.array([round(item["delay"] / period * inner) for item in robots])
    latest = max(item["delay"] + item["lag"] for item in robots)
    bandwidth = CROSSOVER / max(latest, period)
    gains = bandwidth * np.array([min(item[name] for item in robots) for name in ("m", "I")])
    sums, state = np.zeros((count, 2)), np.zeros((8, count))
    # Before the first command comes the last, which nobody sends: 0.
    sent = np.zeros((len(wanted) * inner + 1, count, 2))
    motions = np.empty((count, len(wanted), 6))
    torques = np.empty((count, len(wanted), 2))
    h = np.full(count, period / inner)
    for k, desired in enumerate(wanted):
        motions[:, k] = state[:6].T
        error = desired - state[2:4].T
        force = gains * (error + sums)
        sums += bandwidth / 5 * error * period
        (tau,) = evaluated(wheels, force)
        torques[:, k] = np.clip(tau, -scenario.actuator.tau_max, scenario.actuator.tau_max).T
        own = np.arange(k * inner, (k + 1) * inner)[:, None]
        sent[own[:, 0]] = torques[:, k]
        due = sent[np.maximum(own - queues, -1), range(count)]
        (state,) = evaluated(step, state.T, due.transpose(1, 0, 2), p, h)
    return motions, torques


def _robot(scenario: Scenario, steps: int) -> ca.Function:
    """Steps of (way, turn, v, omega, x, y, acting torques): the plant's graph behind the lag."""
    s, u, p, h = ca.SX.sym("s", 8), ca.SX.sym("u", 2), ca.SX.sym("p", len(WALKED)), ca.SX.sym("h")
    robot = scenario.robot
    a = {name: p[k] for k, name in enumerate(WALKED)}
    a |= {"r": ca.SX(robot.r), "l": ca.SX(robot.l), "g": ca.SX(robot.g), "v_s": ca.SX(robot.v_s)}
    after = followed(u, ca.exp(-h / a["lag"]), s[6:8])
    torque = u + a["lag"] * (s[6:8] - after) / h
    moved, force = ca.SX.sym("moved", 4), ca.SX.sym("force", 2)
    rest = ca.substitute(stepped(scenario, a, torque, h, moved, force), force, ca.SX.zeros(2))
    gone = ca.substitute(rest, moved, s[:4])
    middle = (s[1] + gone[1]) / 2
    place = s[4:6] + (gone[0] - s[0]) * ca.vertcat(-ca.sin(middle), ca.cos(middle))
    one = ca.Function("step", [s, u, p, h], [ca.vertcat(gone, place, after)])
    all_u, state = ca.SX.sym("u", 2, steps), s
    for k in range(steps):
        state = one(state, all_u[:, k], p, h)
    return ca.Function("robot", [s, ca.vec(all_u), p, h], [state])


def _expected(
    result: Identification, motion: Floats, torque: Floats
) -> tuple[float, dict[str, str]]:
    """Logarithm of the determinant of the Fisher information, and verdicts that it would earn.

    The jackknife of a real log widens its intervals.
    """
    fit, old = result.fit, result.fit.problem
    t: Floats = result.scenario.clock.control * np.arange(len(motion), dtype=np.float64)
    seen = motion[:, 2:4] if old.log.of_speed else motion[:, :2]
    first = np.array([0])
    log = Samples(t, seen, old.log.variance, t, torque, first, old.log.of_speed)
    problem = LogProblem(log, old.filter, old.known)
    known = Fit(problem, fit.theta, fit.free, problem.read(fit.theta))
    whole, errors = known.information(), np.zeros(len(NAMES))
    errors[fit.free] = np.sqrt(np.diag(np.linalg.pinv(whole)))
    values = {name: result.parameters[name].value for name in PHYSICAL}
    size = sizes(values, np.sqrt(np.mean(motion[:, 2:4] ** 2, axis=0)), log.period)
    half = {name: NORMAL * errors[INDEX[name]] for name in PHYSICAL}
    return float(np.linalg.slogdet(whole)[1]), {
        name: verdict(half[name] * (values[name] if name in LOGARITHMIC else 1.0), size[name])
        for name in PHYSICAL
    }


def followed_by(log: AxisLog, loop: str, values: Mapping[str, Floats]) -> Floats:
    """Speeds (N, K) that follow from a log's commands for parameters (K,) in SI units."""
    sets = np.tile([1.0, 1.0, 1.0, math.inf, 0.0], (len(next(iter(values.values()))), 1))
    for name, column in values.items():
        sets[:, PLACE[name]] = column
    return foretold(log, loop, sets)


def information_of(fit: LoopFit, log: AxisLog) -> Floats:
    """Fisher information (n, n) that another log would have of what was fitted, in this noise."""
    whiten, whole = whitener(fit.left, fit.log.in_fit)
    sigma = math.hypot(float(np.std(whiten(fit.left)[whole])), finest(fit.log))
    steps = np.diag([1e-4 if name == "delay" else 1e-3 for name in fit.names])
    sets = np.array([set_of(fit.names, fit.theta + s) for s in (0 * steps[0], *steps)])
    apart = foretold(log, fit.loop, sets)
    slope = whiten((apart[:, 1:] - apart[:, :1]) / np.diag(steps))[ORDER:] / sigma
    return np.asarray(slope.T @ slope)
