"""The guard's numbers: what a scenario leaves out is derived, what a guard cannot meet refused."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, replace

import casadi as ca

from wmr_ctrl.control.applied import commands_under_way
from wmr_ctrl.control.gains import gains_of
from wmr_ctrl.errors import ScenarioError
from wmr_ctrl.model.parameters import Parameters
from wmr_ctrl.scenario import Guard, Scenario

Pair = tuple[float, float]

ROUNDING = 2.0**-44
"""The guard aims at v_u1 (1 - ROUNDING): more than its rounding errors can add up to.

Every command under way adds another ROUNDING (see `rounding`).
"""

SIGMAS = 3.0
"""dbar of Gaussian noise that is not truncated, in standard deviations."""

UNITS, AXES = ("N", "N m"), (0, 1)


def rounding(under_way: int) -> float:
    """Share of v_u1 that is kept back against rounding, with commands ``under_way``."""
    return ROUNDING * (1 + under_way)


@dataclass(frozen=True)
class WheelLimit:
    """Torque limit of each wheel [N m], as symbol and number."""

    sym: ca.SX
    number: float


def wheel_limit(scenario: Scenario, p: Parameters, law: str | None) -> WheelLimit:
    """The drives' limit, or the law's own default limit where that is smaller."""
    given = p.take("actuator.tau_max")
    gains = gains_of(scenario, law) if law is not None else None
    if not hasattr(gains, "tau_max"):
        return WheelLimit(given, scenario.actuator.tau_max)
    own = p.field(f"gains.{law}.tau_max", gains, "tau_max")
    return WheelLimit(ca.fmin(given, own), torque_limit(scenario, law))


def torque_limit(scenario: Scenario, law: str | None) -> float:
    """The smaller of actuator.tau_max and the law's gain tau_max, if it has one [N m]."""
    own = getattr(gains_of(scenario, law), "tau_max", math.inf) if law is not None else math.inf
    return min(scenario.actuator.tau_max, own)


@dataclass(frozen=True)
class Stated(Guard):
    """A guard's numbers as they were stated or implied, whether or not they can be met."""

    def relate(self) -> None:
        """Nothing is refused here: an unguarded run may state what no guard could keep."""


def settled_guard(scenario: Scenario, tau_max: float) -> Guard:
    """The scenario's guard with every number in it, for wheels with ``tau_max`` [N m].

    Raises ScenarioError where no force keeps the limit, with inequality, numbers and remedy.
    """
    settled = stated_guard(scenario, tau_max)
    Guard.relate(settled)
    _check(scenario, settled)
    _check_brake(scenario, settled, tau_max)
    return settled


def stated_guard(scenario: Scenario, tau_max: float) -> Stated:
    """What `settled_guard` gives, and the same derivation where that refuses."""
    given = Stated(**asdict(scenario.guard))
    low, high = mass_range(scenario)
    stated = replace(
        given,
        M_min=given.M_min or low,
        M_max=given.M_max or high,
        dbar=given.dbar or disturbance_bound(scenario),
        nbar=given.nbar or scenario.sensor.velocity_noise,
        alpha=given.alpha or 1.0 / scenario.clock.control,
    )
    return replace(stated, brake=given.brake or _derived_brake(scenario, stated, tau_max))


def mass_range(scenario: Scenario) -> tuple[Pair, Pair]:
    """M_min and M_max of (m, I) over the robot and all its changes, widened by mass_margin."""
    margin, robot = scenario.guard.mass_margin, scenario.robot
    masses = [robot.m, *(change.m for change in scenario.changes if change.m is not None)]
    inertias = [robot.I, *(change.I for change in scenario.changes if change.I is not None)]
    low, high = 1.0 - margin, 1.0 + margin
    return (low * min(masses), low * min(inertias)), (high * max(masses), high * max(inertias))


def disturbance_bound(scenario: Scenario) -> Pair:
    """Largest force of noise (3 std without truncation) and push, plus guard.d_model [N, N m]."""
    noise, robot, extra = scenario.disturbance, scenario.robot, scenario.guard.d_model
    largest = noise.std * (SIGMAS if math.isinf(noise.truncate) else noise.truncate)
    thrust = 2.0 * largest / robot.r
    push = noise.push
    return thrust + push[0] + extra[0], thrust * robot.l + push[1] + extra[1]


def net(guard: Guard, axis: int) -> float:
    """dbar less f_min of one axis [N or N m]."""
    return _of(guard.dbar)[axis] - guard.f_min[axis]


def reach(scenario: Scenario, guard: Guard, axis: int) -> float:
    """M_min (v_u1 - f_speed)/(1/alpha + delay) of one axis [N or N m]: what slows it down."""
    u1 = scenario.limits.v_u1[axis] * (1.0 - rounding(commands_under_way(scenario)))
    alpha = float(guard.alpha or 0.0)
    at_once = _of(guard.M_min)[axis] * alpha * (u1 - guard.f_speed[axis])
    return at_once / (1.0 + alpha * scenario.actuator.delay)


def usable_speed(scenario: Scenario, friction: Pair, tau_max: float = math.inf) -> Pair:
    """Largest steady speeds that the guard admits against ``friction`` [N, N m], per axis.

    v_u1 - nbar - (friction + dbar - f_min) (1/alpha + delay)/M_min [m/s, rad/s]; negative where
    the guard would not let the robot move at all.
    """
    guard = settled_guard(scenario, tau_max)
    time = 1.0 / float(guard.alpha or 0.0) + scenario.actuator.delay
    first, second = (
        scenario.limits.v_u1[i]
        - _of(guard.nbar)[i]
        - (friction[i] + net(guard, i)) * time / _of(guard.M_min)[i]
        for i in AXES
    )
    return first, second


def early_speed(scenario: Scenario, tau_max: float = math.inf) -> Pair:
    """What a push can add to a speed before the first command acts: delay (dbar - f_min)/M_min."""
    guard, delay = settled_guard(scenario, tau_max), scenario.actuator.delay
    first, second = (delay * max(net(guard, i), 0.0) / _of(guard.M_min)[i] for i in AXES)
    return first, second


def _of(pair: Pair | None) -> Pair:
    assert pair is not None
    return pair


def _check(scenario: Scenario, guard: Guard) -> None:
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


def _check_noise(scenario: Scenario, guard: Guard, i: int) -> None:
    u1, nbar = scenario.limits.v_u1[i], _of(guard.nbar)[i]
    if 2.0 * nbar > u1 * (1.0 - rounding(commands_under_way(scenario))):
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


def _check_push(scenario: Scenario, guard: Guard, i: int) -> None:
    need, have = 2.0 * net(guard, i), reach(scenario, guard, i)
    if need <= have:
        return
    low, alpha, delay = _of(guard.M_min)[i], float(guard.alpha or 0.0), scenario.actuator.delay
    room = scenario.limits.v_u1[i] - guard.f_speed[i]
    late = (f"/(1 + alpha delay), delay = {delay:g} s,", f"/{1 + alpha * delay:g}")
    said, divided = late if delay > 0 else ("", "")
    raise ScenarioError(
        f"guard: no force can keep limits.v_u1[{i + 1}] = {scenario.limits.v_u1[i]:g}: "
        f"2 (dbar - f_min) <= M_min alpha (v_u1 - f_speed){said} is needed on axis {i + 1}, but "
        f"{need:g} > {low:g} * {alpha:g} * {room:g}{divided} = {have:.6g} {UNITS[i]}. It holds "
        f"{_sooner(low * room / need, alpha, scenario)}"
        f"with guard.dbar[{i + 1}] <= {have / 2 + guard.f_min[i]:.4g} {UNITS[i]}, or with "
        f"guard.M_min[{i + 1}] >= {need * (1 / alpha + delay) / room:.4g}."
    )


def _sooner(longest: float, alpha: float, scenario: Scenario) -> str:
    """The remedies by time, for 1/alpha + delay <= ``longest`` [s]; none where neither does."""
    delay = scenario.actuator.delay
    shorter = delay > 0 and longest >= 1.0 / alpha
    remedies = [f"with actuator.delay <= {max(longest - 1 / alpha, 0.0):.4g} s"] * shorter
    if longest > delay:
        remedies.append(_faster(1.0 / (longest - delay), scenario.clock.control))
    return "".join(f"{remedy}, or " for remedy in remedies)


def _faster(alpha: float, period: float) -> str:
    """The remedy by rate: a larger alpha where T allows it, else a shorter T."""
    if alpha * period <= 1.0:
        return f"from guard.alpha >= {alpha:.4g} 1/s on"
    return f"from clock.control <= {1.0 / alpha:.4g} s on (alpha = 1/T)"


def _derived_brake(scenario: Scenario, guard: Guard, tau_max: float) -> Pair:
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


def _check_brake(scenario: Scenario, guard: Guard, tau_max: float) -> None:
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


def assumed(scenario: Scenario, law: str) -> tuple[Pair, Pair]:
    """What a guard assumes of the motion, on or off: largest disturbance and force [N, N m]."""
    guard = stated_guard(scenario, torque_limit(scenario, law))
    mass, u1, period = _of(guard.M_max), scenario.limits.v_u1, scenario.clock.control
    return _of(guard.dbar), (mass[0] * u1[0] / period, mass[1] * u1[1] / period)
