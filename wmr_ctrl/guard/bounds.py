"""The guard's numbers: what a scenario leaves out is derived, what a guard cannot meet refused."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, replace

from wmr_ctrl.errors import ScenarioError
from wmr_ctrl.fields.section import quantity
from wmr_ctrl.results import Assumptions
from wmr_ctrl.results.assumptions import stopping_force
from wmr_ctrl.scenario import Clock, Guard, Scenario
from wmr_ctrl.world.effect import Bound

Pair = tuple[float, float]

ROUNDING = 2.0**-44
"""The guard aims at v_u1 (1 - ROUNDING): more than its rounding errors can add up to.

Every command under way adds another ROUNDING (see `rounding`).
"""

UNITS, AXES = ("N", "N m"), (0, 1)


def rounding(under_way: int) -> float:
    """Share of v_u1 that is kept back against rounding, with commands ``under_way``."""
    return ROUNDING * (1 + under_way)


@dataclass(frozen=True, kw_only=True)
class Stated(Guard):
    """A guard's numbers as they were stated or implied, whether or not they can be met.

    ``delay`` [s] is how late a command may act, all effects together.
    """

    delay: float = quantity(0.0, unit="s", doc="lateness of a command that is counted", minimum=0)

    def relate(self) -> None:
        """Nothing is refused here: an unguarded run may state what no guard could keep."""

    def late_commands(self, clock: Clock) -> int:
        """How many commands have not acted to their end when the next one is computed."""
        whole, part = divmod(round(self.delay / clock.plant), clock.substeps)
        return whole + bool(part)


def assumptions(scenario: Scenario, guard: Guard) -> Assumptions:
    """What a guard's numbers assume of the motion, be it on or off."""
    force = stopping_force(_of(guard.M_max), scenario.limits.v_u1, scenario.clock.control)
    return Assumptions(_of(guard.dbar), force)


def settled_guard(scenario: Scenario, bound: Bound, tau_max: float) -> Stated:
    """The scenario's guard with every number in it, for wheels with ``tau_max`` [N m].

    ``bound`` is what the effects add up to.  Raises ScenarioError where no force keeps the limit,
    with inequality, numbers and remedy.
    """
    complete = stated_guard(scenario, bound, tau_max)
    Guard.relate(complete)
    _check(scenario, complete)
    _check_brake(scenario, complete, tau_max)
    return complete


def stated_guard(scenario: Scenario, bound: Bound, tau_max: float) -> Stated:
    """What `settled_guard` gives, and the same derivation where that refuses."""
    given = Stated(**asdict(scenario.guard), delay=bound.delay)
    low, high = mass_range(scenario, bound)
    stated = replace(
        given,
        M_min=given.M_min or low,
        M_max=given.M_max or high,
        dbar=given.dbar or _sum(bound.dbar, given.d_model),
        nbar=given.nbar or bound.nbar,
        alpha=given.alpha or 1.0 / scenario.clock.control,
    )
    return replace(stated, brake=given.brake or _derived_brake(scenario, stated, tau_max))


def mass_range(scenario: Scenario, bound: Bound, margin: float | None = None) -> tuple[Pair, Pair]:
    """M_min and M_max of (m, I) over the robot and all its changes, widened by ``margin``.

    That is a share, guard.mass_margin by default.
    """
    margin = scenario.guard.mass_margin if margin is None else margin
    robot = scenario.robot
    masses = [robot.m, *(change.m for change in scenario.changes if change.m is not None)]
    inertias = [robot.I, *(change.I for change in scenario.changes if change.I is not None)]
    low, high = 1.0 - margin, 1.0 + margin
    less, more = bound.mass, bound.mass
    return (
        (low * min(masses) - less[0], low * min(inertias) - less[1]),
        (high * max(masses) + more[0], high * max(inertias) + more[1]),
    )


def _sum(a: Pair, b: Pair) -> Pair:
    return a[0] + b[0], a[1] + b[1]


def net(guard: Guard, axis: int) -> float:
    """dbar less f_min of one axis [N or N m]."""
    return _of(guard.dbar)[axis] - guard.f_min[axis]


def reach(scenario: Scenario, guard: Stated, axis: int) -> float:
    """M_min (v_u1 - f_speed)/(1/alpha + delay) of one axis [N or N m]: what slows it down."""
    u1 = scenario.limits.v_u1[axis] * (1.0 - rounding(guard.late_commands(scenario.clock)))
    alpha = float(guard.alpha or 0.0)
    at_once = _of(guard.M_min)[axis] * alpha * (u1 - guard.f_speed[axis])
    return at_once / (1.0 + alpha * guard.delay)


def usable_speed(scenario: Scenario, guard: Stated, friction: Pair) -> Pair:
    """Largest steady speeds that the guard admits against ``friction`` [N, N m], per axis.

    v_u1 - nbar - (friction + dbar - f_min) (1/alpha + delay)/M_min [m/s, rad/s]; negative where
    the guard would not let the robot move at all.
    """
    time = 1.0 / float(guard.alpha or 0.0) + guard.delay
    first, second = (
        scenario.limits.v_u1[i]
        - _of(guard.nbar)[i]
        - (friction[i] + net(guard, i)) * time / _of(guard.M_min)[i]
        for i in AXES
    )
    return first, second


def early_speed(guard: Stated) -> Pair:
    """What a push can add to a speed before the first command acts: delay (dbar - f_min)/M_min."""
    first, second = (guard.delay * max(net(guard, i), 0.0) / _of(guard.M_min)[i] for i in AXES)
    return first, second


def _of(pair: Pair | None) -> Pair:
    assert pair is not None
    return pair


def _check(scenario: Scenario, guard: Stated) -> None:
    period, alpha = scenario.clock.control, float(guard.alpha or 0.0)
    if alpha * period > 1.0 + ROUNDING:
        raise ScenarioError(
            f"guard.alpha = {alpha:g} 1/s is too fast: alpha T <= 1 is needed for a force that is "
            f"held over T = clock.control = {period:g} s, not {alpha * period:.6g}. Lower it to "
            f"{1.0 / period:g} 1/s, or leave it out."
        )
    for i in AXES:
        _check_noise(scenario, guard, i)
        _check_push(scenario, guard, i)


def _check_noise(scenario: Scenario, guard: Stated, i: int) -> None:
    u1, nbar = scenario.limits.v_u1[i], _of(guard.nbar)[i]
    if 2.0 * nbar > u1 * (1.0 - rounding(guard.late_commands(scenario.clock))):
        raise ScenarioError(
            f"guard.nbar[{i + 1}] = {nbar:g} cannot be met: 2 nbar <= v_u1 is needed, but "
            f"{2 * nbar:g} > limits.v_u1[{i + 1}] = {u1:g}. Measure the velocity to within "
            f"{u1 / 2:g}, or raise the limit."
        )
    if guard.f_speed[i] >= u1:
        raise ScenarioError(
            f"guard.f_speed[{i + 1}] = {guard.f_speed[i]:g} must be below limits.v_u1[{i + 1}] = "
            f"{u1:g}. Lower it, or set guard.f_min to 0."
        )


def _check_push(scenario: Scenario, guard: Stated, i: int) -> None:
    need, have = 2.0 * net(guard, i), reach(scenario, guard, i)
    if need <= have:
        return
    low, alpha, delay = _of(guard.M_min)[i], float(guard.alpha or 0.0), guard.delay
    room = scenario.limits.v_u1[i] - guard.f_speed[i]
    late = (f"/(1 + alpha delay), delay = {delay:g} s,", f"/{1 + alpha * delay:g}")
    said, divided = late if delay > 0 else ("", "")
    raise ScenarioError(
        f"guard: no force can keep limits.v_u1[{i + 1}] = {scenario.limits.v_u1[i]:g}: "
        f"2 (dbar - f_min) <= M_min alpha (v_u1 - f_speed){said} is needed on axis {i + 1}, but "
        f"{need:g} > {low:g} * {alpha:g} * {room:g}{divided} = {have:.6g} {UNITS[i]}. It holds "
        f"{_sooner(low * room / need, alpha, guard.delay, scenario.clock.control)}"
        f"with guard.dbar[{i + 1}] <= {have / 2 + guard.f_min[i]:.4g} {UNITS[i]}, or with "
        f"guard.M_min[{i + 1}] >= {need * (1 / alpha + delay) / room:.4g}."
    )


def _sooner(longest: float, alpha: float, delay: float, period: float) -> str:
    """The remedies by time, for 1/alpha + delay <= ``longest`` [s]; none where neither does."""
    shorter = delay > 0 and longest >= 1.0 / alpha
    remedies = [f"with actuator.delay <= {max(longest - 1 / alpha, 0.0):.4g} s"] * shorter
    if longest > delay:
        remedies.append(_faster(1.0 / (longest - delay), period))
    return "".join(f"{remedy}, or " for remedy in remedies)


def _faster(alpha: float, period: float) -> str:
    """The remedy by rate: a larger alpha where T allows it, else a shorter T."""
    if alpha * period <= 1.0:
        return f"from guard.alpha >= {alpha:.4g} 1/s on"
    return f"from clock.control <= {1.0 / alpha:.4g} s on (alpha = 1/T)"


def _derived_brake(scenario: Scenario, guard: Stated, tau_max: float) -> Pair:
    """All that is allowed without torque limits, else dbar and a share of what is to spare."""
    caps = tuple(max(reach(scenario, guard, i) - net(guard, i), 0.0) for i in AXES)
    if math.isinf(tau_max):
        return caps[0], caps[1]
    half_track, share = scenario.robot.l, guard.brake_share
    first, second = max(net(guard, 0), 0.0), max(net(guard, 1), 0.0)
    spare = 2.0 * tau_max / scenario.robot.r - first - second / half_track
    spare = max(spare, 0.0)
    return (
        min(caps[0], first + share * spare),
        min(caps[1], second + (1.0 - share) * spare * half_track),
    )


def _check_brake(scenario: Scenario, guard: Stated, tau_max: float) -> None:
    robot, brake = scenario.robot, _of(guard.brake)
    most = 2.0 * tau_max / robot.r
    _check_wheels("dbar", [max(net(guard, i), 0.0) for i in AXES], most, robot.r, robot.l, tau_max)
    _check_wheels("brake", list(brake), most, robot.r, robot.l, tau_max)
    for i in AXES:
        if brake[i] < net(guard, i):
            raise ScenarioError(
                f"guard.brake[{i + 1}] = {brake[i]:g} {UNITS[i]} must be at least dbar - f_min = "
                f"{net(guard, i):g}: less cannot hold the robot at the limit. Raise it, or leave "
                "it out."
            )


def _check_wheels(
    name: str, pair: list[float], most: float, r: float, half_track: float, tau_max: float
) -> None:
    need = pair[0] + pair[1] / half_track
    if need <= most * (1.0 + 1e-12):
        return
    raise ScenarioError(
        f"guard: the wheels cannot hold the robot at both limits: {name}[1] + {name}[2]/l <= "
        f"2 tau_max/r is needed, but {pair[0]:g} + {pair[1]:g}/{half_track:g} = {need:g} > "
        f"{most:g} N. It holds from tau_max >= {need * r / 2:.4g} N m on (now {tau_max:g}), or "
        f"with guard.{name} scaled by {most / need:.3g}."
    )
