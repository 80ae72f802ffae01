"""Times, distances and ways to leave, of a governor that receives limits and free distances.

They are those of its graph (`stopping`, `ways`) for a scenario's own values, for people to read.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass

from wmr_ctrl.core.fields.values import Pair
from wmr_ctrl.world.scenario import Scenario, override
from wmr_ctrl.world.scenario.command_filter import Intervals

from .governor import NEAR, Schedule
from .governor_step import schedules
from .heard import whole_steps
from .ways import Stop


def stop_of(scenario: Scenario, axis: int) -> tuple[Stop[float], Schedule]:
    """The `Stop` of v (0) or omega (1), and the times of its commands."""
    settings, T, plan = scenario.filter, scenario.clock.control, schedules(scenario)[axis]
    acts, nearing = plan.acting * T, 0.0 if axis else settings.nearing
    stop = Stop(
        settings.intervals("tau")[axis], settings.d[axis], settings.rest, acts,
        plan.delay[1] * T, nearing,
    )  # fmt: skip
    return stop, plan


def _reaction(scenario: Scenario, axis: int) -> float:
    """Time [s] before a clip's base surely slows down: delay, command and lag."""
    plan, tau = schedules(scenario)[axis], scenario.filter.tau
    lag = scenario.filter.intervals("tau")[axis][1] if tau is not None else 0.0
    return (plan.delay[1] + plan.acting) * scenario.clock.control + lag


@dataclass(frozen=True)
class Stopping:
    """Distance [m] that a base needs to stop from ``speed`` [m/s], and its parts [m].

    ``delay``: until 0 acts.  ``push``: due to pushes, releases and approaching obstacles.
    ``brake``: from the speed to rest.  ``error``: of the measured distance.
    """

    speed: float
    distance: float
    delay: float
    push: float
    brake: float
    error: float


def stopping(scenario: Scenario, speed: float) -> Stopping:
    """Distance at which the governor still lets a base drive on straight at this speed [m/s]."""
    settings, error = scenario.filter, scenario.filter.free_error or 0.0
    if settings.decel is not None and settings.kind == "clip":
        reaction = _reaction(scenario, 0)
        delay, slowed = speed * reaction, max(speed - settings.d[0], 0.0)
        brake = slowed * slowed / (2 * settings.decel[0])
        push = settings.leave * settings.d[0] * (settings.rest or 0.0) + _starting(scenario)
    else:
        stop, _ = stop_of(scenario, 0)
        delay = speed * (stop.last + stop.acts)
        brake = stop.fading * max(speed - stop.push, 0.0)
        push = stop.creep + settings.leave * stop.roll + stop.nearing * stop.time
    return Stopping(speed, delay + push + brake + error, delay, push, brake, error)


def leaves_from(scenario: Scenario) -> float:
    """Least received free distance [m] at which a base at rest may leave without a hold."""
    error = scenario.filter.free_error or 0.0
    if scenario.filter.kind == "clip":
        return error + _starting(scenario)
    stop, _ = stop_of(scenario, 0)
    return error + stop.roll + stop.nearing * stop.time


def _starting(scenario: Scenario) -> float:
    """Distance [m] that a clip reserves for one release and for obstacles that approach
    meanwhile.
    """
    settings, rest = scenario.filter, scenario.filter.rest or 0.0
    slows = fastest(scenario) / settings.decel[0] if settings.decel else 0.0
    return settings.d[0] * rest + settings.nearing * (_reaction(scenario, 0) + slows + rest)


def fastest(scenario: Scenario) -> float:
    """Larger limit of v of both directions [m/s]."""
    return max(scenario.limits.v_max[0], -scenario.limits.v_min[0])


def costs(scenario: Scenario) -> dict[str, float]:
    """Extra stopping distance [m] for one millisecond more of delay, 1 % more of tau and 1 s more
    of rest.

    At the largest speed.
    """
    settings, speed = scenario.filter, fastest(scenario)
    whole = stopping(scenario, speed).distance

    def more(key: str, value: Intervals | Pair | float) -> float:
        changed = override(scenario, {f"filter.{key}": value})
        return stopping(changed, speed).distance - whole

    later = settings.each("delay", lambda ends: (ends[0], ends[1] + 1e-3))
    found = {"millisecond": more("delay", later)}
    if settings.kind == "clip" and settings.decel is not None:
        v, omega = settings.decel
        found["per_cent"] = more("decel", (v / 1.01, omega))
    else:
        found["per_cent"] = more("tau", settings.each("tau", lambda at: (at[0], 1.01 * at[1])))
    if settings.rest is not None:
        found["rest_second"] = more("rest", settings.rest + 1)
    return found


@dataclass(frozen=True)
class Leaving:
    """Numbers for driving away a base that the governor has stopped.

    ``roll`` [m]: largest distance of one release. ``least`` [m/s]: least command that drives away,
    whatever pushes. ``hold`` [s]: for how long the largest command is to be held. ``rest`` [s]:
    until the base is known to stand.
    """

    roll: float
    least: float
    hold: float
    rest: float


def pull_away(scenario: Scenario, way: int = -1) -> float:
    """Least speed [m/s] of the largest command away from an obstacle ahead (``way`` -1) or behind.

    If it is not above 0, commands can never drive the base away.
    """
    (least, most), d = scenario.filter.intervals("gain")[0], scenario.filter.d[0]
    V = scenario.limits.v_max[0] if way > 0 else -scenario.limits.v_min[0]
    return least * (V - d) / most - d


def leaving(scenario: Scenario, way: int = -1) -> Leaving | None:
    """Numbers for leaving an obstacle ahead (``way`` -1) or behind the base (1).

    None if nothing holds it, if the filter has no rest, or if it can never leave.
    """
    settings, T, pull = scenario.filter, scenario.clock.control, pull_away(scenario, way)
    if settings.kind == "clip" or settings.rest is None or pull <= 0:
        return None
    stop, plan = stop_of(scenario, 0)
    if plan.stops_alone and stop.push:
        return None
    rests = whole_steps(plan, T, settings.rest + plan.losses * (1 + plan.jitter) * T, NEAR)
    steps = _commands(plan, T, stop.hold(pull)) if stop.push else 0
    least = stop.push / settings.intervals("gain")[0][0]
    return Leaving(stop.roll, least, steps * T, rests * T)


def rolls_back(scenario: Scenario) -> float:
    """Distance [m] that a push may move the base the other way during a stop, for the body's radius
    to cover.
    """
    settings = scenario.filter
    if settings.kind == "clip":
        return settings.d[0] * (_reaction(scenario, 0) + (settings.rest or 0.0))
    stop, _ = stop_of(scenario, 0)
    return stop.push * stop.time


def smallest_window(scenario: Scenario) -> Pair:
    """Largest turn [rad] to either side during a stop, and during a stop and a hold.

    The hold is that of twice the least command that drives away.
    """
    settings, T = scenario.filter, scenario.clock.control
    if settings.kind == "clip" and settings.decel is not None:
        d, rest = settings.d[1], settings.rest or 0.0
        turned = d * (_reaction(scenario, 1) + rest) + settings.leave * d * rest
        return turned, turned
    (straight, plan), (stop, _) = (stop_of(scenario, axis) for axis in (0, 1))
    turned = stop.push * stop.time + settings.leave * stop.roll
    if not straight.push:
        return turned, turned
    longest = _commands(plan, T, straight.hold(straight.push)) * (1 + plan.jitter) * T
    return turned, turned + stop.push * (longest + settings.free_age)


def _commands(plan: Schedule, T: float, time: float) -> float:
    """Number of commands that surely act for a time [s]."""
    return plan.losses + whole_steps(plan, T, time)


def time_inside(scenario: Scenario, axis: int, before: float, after: float) -> float:
    """Longest time [s] from a step that receives the limit ``after`` until the base is within it.

    It was within ``before``, both limits of one side [m/s, rad/s]; inf if no time is promised.
    """
    stop, plan = stop_of(scenario, axis)
    d, T = stop.push, scenario.clock.control
    latest = (1 + plan.jitter) * T
    surely = stop.last + plan.losses * latest
    if after >= before:
        return surely
    if after <= d:
        return math.inf
    fades = stop.tau[1] * math.log((before - d) / (after - d))
    return surely + min(fades + plan.shortest * T, _commands(plan, T, fades) * latest)


def times_inside(
    scenario: Scenario, axis: int, limit: float
) -> Iterator[tuple[float, float, float]]:
    """Limits before and after [m/s, rad/s] and `time_inside` [s], for each tenth of a limit."""
    for higher in range(10, 1, -1):
        for lower in range(higher - 1, 0, -1):
            before, after = limit * higher / 10, limit * lower / 10
            yield before, after, time_inside(scenario, axis, before, after)
