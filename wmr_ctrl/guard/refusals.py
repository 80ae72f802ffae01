"""What no guard, or this one, can meet is refused: the inequality, the numbers, the remedy."""

from __future__ import annotations

from wmr_ctrl.errors import ScenarioError
from wmr_ctrl.guard.bounds import (
    AXES,
    ROUNDING,
    UNITS,
    Stated,
    aim,
    lateness_time,
    mixed_time,
    net,
    pair_of,
    reach,
    stated_guard,
)
from wmr_ctrl.guard.lateness import GRID
from wmr_ctrl.scenario import Guard, Scenario
from wmr_ctrl.world.effect import Bound


def settled_guard(scenario: Scenario, bound: Bound, tau_max: float) -> Stated:
    """The scenario's guard with every number in it, for wheels with ``tau_max`` [N m].

    ``bound`` is what the effects add up to.  Raises ScenarioError where no force keeps the limit,
    with inequality, numbers and remedy.
    """
    complete = stated_guard(scenario, bound, tau_max)
    Guard.relate(complete)
    _check_times(scenario, complete)
    _check(scenario, complete)
    _check_brake(scenario, complete, tau_max)
    return complete


def _check_times(scenario: Scenario, guard: Stated) -> None:
    """Refuse what the guard's theorem does not speak of."""
    period, step = scenario.clock.control, scenario.clock.plant
    for i in AXES:
        start = scenario.initial.velocity[i]
        if start and (guard.age[i] or guard.window[i]):
            raise ScenarioError(
                f"guard: initial.velocity[{i + 1}] = {start:g}, but a velocity that is measured "
                "late is measured from rest on, so the guard would take the robot for slower than "
                "it is. Start at rest, or switch the guard off."
            )
    if guard.jitter > period + GRID * step:
        raise ScenarioError(
            f"guard: the delay varies by {guard.jitter:g} s, more than clock.control = {period:g} "
            "s: a command could take over after the next one. Lower actuator.jitter to at most "
            f"{period:g} s, or lengthen clock.control."
        )


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
    u1, nbar = scenario.limits.v_u1[i], pair_of(guard.nbar)[i]
    if 2.0 * nbar > aim(scenario, guard, i):
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
    _check_mixed(scenario, guard, i)
    need, have = 2.0 * net(guard, i), reach(scenario, guard, i)
    if need <= have:
        return
    low, alpha = pair_of(guard.M_min)[i], float(guard.alpha or 0.0)
    late = lateness_time(scenario, guard, i)
    room = scenario.limits.v_u1[i] - guard.f_speed[i]
    said, divided = _lateness_words(guard, i, late, alpha)
    who = "no force" if late <= guard.latest else "the guard"
    can = "can" if late <= guard.latest else "cannot"
    raise ScenarioError(
        f"guard: {who} {can} keep limits.v_u1[{i + 1}] = {scenario.limits.v_u1[i]:g}: "
        f"2 (dbar - f_min) <= M_min alpha (v_u1 - f_speed){said} is needed on axis {i + 1}, but "
        f"{need:g} > {low:g} * {alpha:g} * {room:g}{divided} = {have:.6g} {UNITS[i]}. It holds "
        f"{_sooner(low * room / need, alpha, late, guard.latest, scenario.clock.control)}"
        f"with guard.dbar[{i + 1}] <= {have / 2 + guard.f_min[i]:.4g} {UNITS[i]}, or with "
        f"guard.M_min[{i + 1}] >= {need * (1 / alpha + late) / room:.4g}."
    )


def _lateness_words(guard: Stated, i: int, late: float, alpha: float) -> tuple[str, str]:
    """What stands behind the inequality and behind its numbers where something is late."""
    if late == 0:
        return "", ""
    divided = f"/{1 + alpha * late:g}"
    times = {
        "delay": guard.latest,
        "age": guard.age[i],
        "window": guard.window[i],
        "lag": guard.slowest,
    }
    parts = {name: time for name, time in times.items() if time > 0}
    if list(parts) == ["delay"]:
        return f"/(1 + alpha delay), delay = {guard.latest:g} s,", divided
    listed = " + ".join(f"{name} {time:g}" for name, time in parts.items())
    return f"/(1 + alpha late), late = {listed} s,", divided


def _check_mixed(scenario: Scenario, guard: Stated, i: int) -> None:
    mixed = mixed_time(scenario, guard, i)
    u1, nbar, low = aim(scenario, guard, i), pair_of(guard.nbar)[i], pair_of(guard.M_min)[i]
    need, have = 2.0 * net(guard, i) * mixed, low * (u1 - 2.0 * nbar)
    if need > have:
        lag, jitter = pair_of(guard.lag), f"jitter of {guard.jitter:g} s"
        varies = f"a lag between {lag[0]:g} and {lag[1]:g} s" if lag[0] < lag[1] else jitter
        raise ScenarioError(
            f"guard: {varies} and nbar[{i + 1}] = {nbar:g} together cannot be "
            f"met: 2 (dbar - f_min) mixed <= M_min (v_u1 - 2 nbar) is needed on axis {i + 1}, but "
            f"{2 * net(guard, i):g} * {mixed:.4g} = {need:.6g} > {have:.6g}. It holds with "
            f"guard.nbar[{i + 1}] <= {max(u1 - need / low, 0) / 2:.4g} or guard.dbar[{i + 1}] <= "
            f"{have / (2 * mixed) + guard.f_min[i]:.4g} {UNITS[i]}, or where the drives vary less."
        )


def _sooner(longest: float, alpha: float, late: float, delay: float, period: float) -> str:
    """The remedies by time, for 1/alpha + ``late`` <= ``longest`` [s]; none where neither does."""
    others = late - delay
    shorter = delay > 0 and longest >= 1.0 / alpha + others
    most = max(longest - 1 / alpha - others, 0.0)
    remedies = [f"with actuator.delay <= {most:.4g} s"] * shorter
    if longest > late:
        remedies.append(_faster(1.0 / (longest - late), period))
    return "".join(f"{remedy}, or " for remedy in remedies)


def _faster(alpha: float, period: float) -> str:
    """The remedy by rate: a larger alpha where T allows it, else a shorter T."""
    if alpha * period <= 1.0:
        return f"from guard.alpha >= {alpha:.4g} 1/s on"
    return f"from clock.control <= {1.0 / alpha:.4g} s on (alpha = 1/T)"


def _check_brake(scenario: Scenario, guard: Stated, tau_max: float) -> None:
    robot, brake = scenario.robot, pair_of(guard.brake)
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
