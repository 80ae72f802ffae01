"""Refusals of limits that no guard, or not this guard, can keep: inequality, numbers, remedy."""

import math
from collections.abc import Callable
from typing import TypeAlias

from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.core.fields.units import rounded
from wmr_ctrl.world.effect import Bound
from wmr_ctrl.world.model.dynamics import full_thrust
from wmr_ctrl.world.scenario import Guard, Scenario, override

from .bounds import (
    AXES,
    MASS_UNITS,
    SPEED_UNITS,
    UNITS,
    GuardNumbers,
    Pair,
    aim,
    derived_guard,
    lateness_time,
    mass_range,
    masses,
    mixed_time,
    net,
    pair_of,
    reach,
)
from .lateness import GRID

BoundOf: TypeAlias = Callable[[Scenario], Bound]
LATE = ("delay", "unmodelled_delay", "jitter")
"""Fields of [actuator] that add up to the largest delay of a command."""
DOUBLINGS = 20
"""Doublings in the search for a sufficient torque limit."""
HALVINGS = 40
"""Bisections after them."""
SLACK = 1e-9
"""Least relative margin of a proposed number, larger than its rounding."""


def feasible_guard(
    scenario: Scenario, bound: Bound, tau_max: float, bound_of: BoundOf | None = None
) -> GuardNumbers:
    """The scenario's guard with all its numbers, for wheels with ``tau_max`` [N m].

    ``bound`` is the effects' sum, ``bound_of`` the same for other numbers.  Raises ScenarioError if
    no force keeps the limit, with inequality, numbers and remedy.
    """
    complete = derived_guard(scenario, bound, tau_max)
    Guard.relate(complete)
    _check_times(scenario, complete)
    _check_changing(scenario, complete)
    others = bound_of or (lambda _: bound)
    _check(scenario, complete, bound, others)
    _check_brake(scenario, complete, tau_max, others)
    return complete


def _check_times(scenario: Scenario, guard: GuardNumbers) -> None:
    """Refuse times that the guard's theorem does not cover."""
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


def _check_changing(scenario: Scenario, guard: GuardNumbers) -> None:
    """Refuse changing limits if velocities or commands are late."""
    late = not all(times.at_once for times in guard.lateness(scenario.clock))
    if guard.changing and late:
        raise ScenarioError(
            "guard.changing: with delay, lag, jitter or late velocities, commands in transit were "
            "given under older limits, which this guard does not follow. Remove what is late, "
            "leave out guard.changing, or drive a base that takes velocities by a governor."
        )


def _check(scenario: Scenario, guard: GuardNumbers, bound: Bound, bound_of: BoundOf) -> None:
    period, alpha = scenario.clock.control, float(guard.alpha or 0.0)
    if alpha * period > 1.0:
        raise ScenarioError(
            f"guard.alpha = {alpha:g} 1/s is too fast: alpha T <= 1 is needed for a force that is "
            f"held over T = clock.control = {period:g} s, not {_told_apart(alpha * period, 1)[0]}. "
            f"Lower it to {1.0 / period:g} 1/s, or leave it out."
        )
    for i in AXES:
        _check_noise(scenario, guard, i)
        _check_push(scenario, guard, bound, bound_of, i)


def _check_noise(scenario: Scenario, guard: GuardNumbers, i: int) -> None:
    (key, value), nbar = scenario.limits.narrow(i), pair_of(guard.nbar)[i]
    if value == 0:
        _refuse_none_that_way(scenario, guard, i)
    if 2.0 * nbar > aim(scenario, guard, i):
        raise ScenarioError(
            f"guard.nbar[{i + 1}] = {nbar:g} cannot be met: 2 nbar <= {_letter(key)} is needed, "
            f"with room for rounding, but it is {2 * nbar:g}, and {key} = {value:g}. "
            f"Measure the velocity to better than {abs(value) / 2:g}, or allow more."
        )
    if guard.f_speed[i] >= abs(value):
        raise ScenarioError(
            f"guard.f_speed[{i + 1}] = {guard.f_speed[i]:g} must be below {key} = {value:g} in "
            "size. Lower it, or set guard.f_min to 0."
        )


def _letter(key: str) -> str:
    """Symbol of a limit in an inequality: v_u1, v_max or |v_min|."""
    return key[len("limits.") : -len("[1]")].replace("v_min", "|v_min|")


def _refuse_none_that_way(scenario: Scenario, guard: GuardNumbers, i: int) -> None:
    """Refuse a limit of 0: a push or an error would move the robot before the guard can react."""
    key, _ = scenario.limits.narrow(i)
    time = 1 / float(guard.alpha or 0.0) + lateness_time(scenario, guard, i)
    need = guard.f_speed[i] + 2 * max(net(guard, i), 0.0) * time / mass_range(guard, i)[0]
    least = _above(max(need, 2 * pair_of(guard.nbar)[i]))
    raise ScenarioError(
        f"guard: {key} = 0 cannot be kept. {_letter(key)} must be above 0, at least f_speed + 2 "
        f"(dbar - f_min) (1/alpha + late)/M_min = {need:.4g} and at least 2 nbar = "
        f"{2 * pair_of(guard.nbar)[i]:.4g}: a push moves the robot that way before the guard "
        f"knows. State {key} = {'-' * ('min' in key)}{least:g}, or larger."
    )


def _check_push(
    scenario: Scenario, guard: GuardNumbers, bound: Bound, bound_of: BoundOf, i: int
) -> None:
    _check_mixed(scenario, guard, bound, i)
    need, have = 2.0 * net(guard, i), reach(scenario, guard, i)
    if need <= have:
        return
    low, alpha = mass_range(guard, i)[0], float(guard.alpha or 0.0)
    late = lateness_time(scenario, guard, i)
    key, value = scenario.limits.narrow(i)
    room = abs(value) - guard.f_speed[i]
    said, divided = _lateness_words(guard, i, late, alpha)
    shown = _told_apart(need, have)
    who = "no force" if late <= guard.latest else "the guard"
    can = "can" if late <= guard.latest else "cannot"
    raise ScenarioError(
        f"guard: {who} {can} keep {key} = {value:g}: 2 (dbar - f_min) <= "
        f"M_min alpha ({_letter(key)} - f_speed){said} is needed on axis {i + 1}, but "
        f"{shown[0]} > {low:g} * {alpha:g} * {room:g}{divided} = {shown[1]} {UNITS[i]}. It holds "
        f"{_sooner(scenario, low * room / need, alpha, late, guard.latest)}"
        f"{_lower(scenario, bound, 'dbar', i, _below(have / 2 + guard.f_min[i]))}"
        f"{_heavier(scenario, guard, bound, bound_of, i, (1 / alpha + late) / room)}."
    )


def _lower(scenario: Scenario, bound: Bound, name: str, i: int, most: float) -> str:
    """Remedy by dbar or nbar: the key, if it is stated, with its largest value ``most``; else its
    cause.
    """
    stated, true, causes, unit = {
        "dbar": (
            scenario.guard.dbar,
            bound.dbar[i] + scenario.guard.d_model[i],
            "all disturbances and guard.d_model add up to",
            UNITS[i],
        ),
        "nbar": (scenario.guard.nbar, bound.nbar[i], "the sensors are off by", SPEED_UNITS[i]),
    }[name]
    if stated is not None and true <= most:
        return f"with guard.{name}[{i + 1}] <= {most:g} {unit}"
    said = "" if stated is None else f" and guard.{name}[{i + 1}] says so"
    return f"where {causes} at most {most:g} {unit}{said}"


def _heavier(
    scenario: Scenario, guard: GuardNumbers, bound: Bound, bound_of: BoundOf, i: int, share: float
) -> str:
    """Remedy by mass: the key's new value, if that is true of the robot; else another robot.

    ``share``: mass or inertia needed per N or N m of 2 (dbar - f_min).  Empty if pushes grow with
    the mass and no mass is found.
    """
    unit, least = MASS_UNITS[i], _above(2.0 * net(guard, i) * share)
    if min(mass for _, mass in masses(scenario, i)) - bound.mass[i] < least:
        for _ in range(HALVINGS):
            other = bound_of(override(scenario, {f"robot.{'mI'[i]}": least}))
            pushed = max(other.dbar[i] + guard.d_model[i], pair_of(guard.dbar)[i])
            enough = _above(2.0 * (pushed - guard.f_min[i]) * share)
            if enough <= least:
                return f", or for a robot of at least {least:g} {unit}, stated as guard.M_min"
            least = enough
        return ""
    if scenario.guard.M_min is not None:
        return f", or with guard.M_min[{i + 1}] >= {least:g} {unit}"
    whole = [rounded(value, 4, up=False) for value in pair_of(guard.M_min)]
    whole[i] = f"{least:g}"
    return f", or with guard.M_min = [{', '.join(whole)}] or more"


def _lateness_words(guard: GuardNumbers, i: int, late: float, alpha: float) -> tuple[str, str]:
    """Suffixes of the inequality and of its numbers for late velocities or drives."""
    if late == 0:
        return "", ""
    divided = f"/{1 + alpha * late:g}"
    times = guard.latest, guard.age[i], guard.window[i], guard.slowest
    named = zip(("delay", "age", "window", "lag"), times, strict=True)
    parts = {name: time for name, time in named if time > 0}
    if list(parts) == ["delay"]:
        return f"/(1 + alpha delay), delay = {guard.latest:g} s,", divided
    listed = " + ".join(f"{name} {time:g}" for name, time in parts.items())
    return f"/(1 + alpha late), late = {listed} s,", divided


def _check_mixed(scenario: Scenario, guard: GuardNumbers, bound: Bound, i: int) -> None:
    mixed = mixed_time(scenario, guard, i)
    u1, nbar, low = aim(scenario, guard, i), pair_of(guard.nbar)[i], mass_range(guard, i)[0]
    need, have = 2.0 * net(guard, i) * mixed, low * (u1 - 2.0 * nbar)
    if need > have:
        lag, jitter = pair_of(guard.lag), f"jitter of {guard.jitter:g} s"
        varies = f"a lag between {lag[0]:g} and {lag[1]:g} s" if lag[0] < lag[1] else jitter
        dbar, nbar_most = _below(have / (2 * mixed) + guard.f_min[i]), _below((u1 - need / low) / 2)
        raise ScenarioError(
            f"guard: {varies} and nbar[{i + 1}] = {nbar:g} together cannot be met: "
            "2 (dbar - f_min) mixed <= "
            f"M_min ({_letter(scenario.limits.narrow(i)[0])} - 2 nbar) is needed on axis {i + 1}, "
            "but "
            f"{2 * net(guard, i):g} * {mixed:.4g} = {need:.6g} > {have:.6g}. It holds "
            f"{_lower(scenario, bound, 'nbar', i, nbar_most)}, or "
            f"{_lower(scenario, bound, 'dbar', i, dbar)}, or where the drives vary less."
        )


def _sooner(scenario: Scenario, longest: float, alpha: float, late: float, delay: float) -> str:
    """Remedies by time, for 1/alpha + ``late`` <= ``longest`` [s]; empty if none helps."""
    others = late - delay
    shorter = delay > 0 and longest >= 1.0 / alpha + others
    most = max(longest - 1 / alpha - others, 0.0)
    remedies = [_earlier(scenario, most)] * shorter
    if longest > late and 1.0 / (longest - late) > alpha * (1.0 + SLACK):
        remedies.append(_faster(scenario, 1.0 / (longest - late)))
    return "".join(f"{remedy}, or " for remedy in remedies)


def _earlier(scenario: Scenario, most: float) -> str:
    """Remedy by delay: guard.delay if it is stated, else all delays together, in plant steps."""
    if scenario.guard.delay is not None:
        return f"with guard.delay[2] <= {_below(most):g} s, if that is true"
    names = [key for key in LATE if scenario.value(f"actuator.{key}")[0]] or LATE[:1]
    step = scenario.clock.plant
    whole = math.floor(most * (1.0 - SLACK) / step) * step
    return f"with actuator.{' + '.join(names)} <= {whole:.6g} s"


def _faster(scenario: Scenario, alpha: float) -> str:
    """Remedy by rate: a larger alpha if T allows it, else a shorter T."""
    clock = scenario.clock
    if _above(alpha) * clock.control <= 1.0:
        return f"from guard.alpha >= {_above(alpha):g} 1/s on"
    steps = math.floor(_below(1.0 / alpha) / clock.plant * (1.0 + SLACK))
    period = steps * clock.plant if steps else _below(1.0 / alpha)
    left_out = "" if scenario.guard.alpha is None else "guard.alpha left out and "
    return f"with {left_out}clock.control <= {period:.6g} s (alpha = 1/T)"


def _check_brake(
    scenario: Scenario, guard: GuardNumbers, tau_max: float, bound_of: BoundOf
) -> None:
    robot, brake = scenario.robot, pair_of(guard.brake)

    def pushed(limit: float) -> float:
        """Push on the wheels [N] under another torque limit, which effects may depend on.

        inf if the guard would then be refused for another reason.
        """
        other = override(scenario, {"actuator.tau_max": limit})
        pushes = bound_of(other)
        numbers = derived_guard(other, pushes, limit)
        try:
            _check(other, numbers, pushes, bound_of)
        except ScenarioError:
            return math.inf
        return sum(_pushed(numbers, robot.l))

    if not _holds(sum(_pushed(guard, robot.l)), tau_max, robot.r):
        _refuse_wheels(scenario, "dbar", _pushed(guard, robot.l), tau_max, pushed)
    braked = (brake[0], brake[1] / robot.l)
    if not _holds(sum(braked), tau_max, robot.r):
        _refuse_wheels(scenario, "brake", braked, tau_max, lambda _: sum(braked))
    for i in AXES:
        if brake[i] < net(guard, i):
            raise ScenarioError(
                f"guard.brake[{i + 1}] = {brake[i]:g} {UNITS[i]} must be at least dbar - f_min = "
                f"{rounded(net(guard, i), 6)}: less cannot hold the robot at the limit. Raise it, "
                "or leave it out."
            )


def _pushed(guard: GuardNumbers, half_track: float) -> Pair:
    """dbar - f_min of both axes as forces at the wheels [N]; 0 if friction is larger."""
    return max(net(guard, 0), 0.0), max(net(guard, 1), 0.0) / half_track


def _holds(force: float, tau_max: float, r: float) -> bool:
    return force <= full_thrust(r, tau_max)


def _refuse_wheels(
    scenario: Scenario, name: str, pair: Pair, tau_max: float, needed: Callable[[float], float]
) -> None:
    robot, need, most = scenario.robot, sum(pair), full_thrust(scenario.robot.r, tau_max)
    enough = _enough(needed, need * robot.r / 2, robot.r)
    larger = (
        "No tau_max is enough: what the scenario's effects demand grows with tau_max, too. It holds"
        if enough is None
        else f"It holds from tau_max >= {enough:.6g} N m on (now {tau_max:g}), or"
    )
    raise ScenarioError(
        f"guard: the wheels cannot hold the robot at both limits: {name}[1] + {name}[2]/l <= "
        f"2 tau_max/r is needed, but {pair[0]:g} + {pair[1] * robot.l:g}/{robot.l:g} = {need:g} > "
        f"{most:g} N. {larger} with guard.{name} scaled by {_below(most / need):g}."
    )


def _enough(needed: Callable[[float], float], least: float, r: float) -> float | None:
    """Smallest sufficient torque limit [N m] from ``least`` on; None if there is none.

    ``needed``: required force [N] for a limit.  It may grow with the limit, so limits are tried:
    doubled until sufficient, then bisected; four digits, rounded up.
    """
    low = high = float(rounded(least, 4))
    for _ in range(DOUBLINGS):
        if _holds(needed(high), high, r):
            break
        low, high = high, 2.0 * high
    else:
        return None
    for _ in range(HALVINGS if low < high else 0):
        middle = (low + high) / 2.0
        low, high = (low, middle) if _holds(needed(middle), middle, r) else (middle, high)
    return float(rounded(high, 4))


def _told_apart(larger: float, smaller: float) -> tuple[str, str]:
    """Two different numbers as texts with as many digits as they need to differ, at least six."""
    texts = ((f"{larger:.{n}g}", f"{smaller:.{n}g}") for n in range(6, 18))
    return next(pair for pair in texts if pair[0] != pair[1])


def _above(value: float) -> float:
    """A larger number with four digits."""
    return float(rounded(value * (1.0 + SLACK), 4))


def _below(value: float) -> float:
    """A smaller number with four digits; 0 for 0."""
    return float(rounded(max(value, 0.0) * (1.0 - SLACK), 4, up=False))
