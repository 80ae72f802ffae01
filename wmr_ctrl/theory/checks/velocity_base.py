"""Bases that take velocities: the guarantee of the command filter, and its price."""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from wmr_ctrl.control.filter import CommandFilter
from wmr_ctrl.control.filter.band import MOST_COMMANDS
from wmr_ctrl.control.filter.governor import NEAR
from wmr_ctrl.control.filter.hypotheses import broken_hypotheses
from wmr_ctrl.control.filter.peak_gain import less_damped, overshoot, peak_gains
from wmr_ctrl.control.filter.rounding_ranges import unproved_roundings
from wmr_ctrl.control.setup import Setup
from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.results.settings import Pair
from wmr_ctrl.results.verdicts import Warning
from wmr_ctrl.world.scenario import Scenario, override
from wmr_ctrl.world.scenario.command_filter import FIRST_ORDER, Intervals
from wmr_ctrl.world.torque_noise import SIGMAS, unbounded
from wmr_ctrl.world.velocity_mean import VelocityMean

from .loop import Loop

STATEMENTS = {
    "clip": "memoryless clip, for every base that never overshoots",
    "governor": "governor, for a first-order base with nothing hidden",
    "band": "band, for linear loops whose numbers do not change",
}
OF_LINEAR_LOOPS = "memoryless clip, for linear loops with peak gains up to {0:.4g}, {1:.4g}"
BEHIND_SLEW = (
    "clip of commands that change by at most {0:.4g} m/s2, {1:.4g} rad/s2, for linear loops"
)
MILLISECOND = 1e-3
PER_CENT = 1e-2
NEARLY = 0.9
SETTLED = 40.0
"""Time constants after which a base is taken to have settled: e^-40 is below rounding."""
MOST_STEPS = 5000


@dataclass(frozen=True)
class FilterFacts:
    """Results of a command filter on a scenario.

    ``gain``: largest assumed gain of both axes; for the clip of linear loops, the peak gain.
    ``usable``: least and largest speed ("v" [m/s], "omega" [rad/s]) at rest on the weakest base
    that is stated, under a command far beyond the limit.  ``usable_speed``: the smaller of both
    directions.  ``delay_cost``: loss of it by one more millisecond of delay (constant for a band,
    which refuses others).  ``gain_cost``: loss by one more per cent of that gain.  ``broken``:
    violated conditions of the theorem.  For linear loops, ``overshoot``: largest relative overshoot
    of a step, and ``overshoot_cost``: loss by one more per cent of it.  For a band, ``rise`` [s]:
    time that commands far beyond the limit take to reach NEARLY all of it, and ``rise_cost``:
    increase by one more per cent of overshoot, since its speed at rest hardly falls.
    """

    kind: str
    statement: str
    gain: float
    usable_speed: Pair
    usable: Mapping[str, Pair]
    delay_cost: Pair | None
    gain_cost: Pair | None
    broken: tuple[str, ...]
    overshoot: Pair | None = None
    overshoot_cost: Pair | None = None
    rise: Pair | None = None
    rise_cost: Pair | None = None


def filter_facts(setup: Setup) -> FilterFacts | None:
    """The results of a setup's filter; None without a filter."""
    scenario, stated = setup.scenario, setup.scenario.filter
    if not setup.takes_velocity or stated.kind == "none":
        return None
    named, broken = usable_sides(scenario), broken_hypotheses(scenario, setup.bound)
    usable, sided = _smaller(named), dict(zip(("v", "omega"), named, strict=True))
    later = stated.each("delay", lambda ends: (ends[0], ends[1] + MILLISECOND))
    high = max(most for _, most in stated.intervals("gain"))
    statement = STATEMENTS[stated.kind]
    if stated.loop != FIRST_ORDER:  # where a command acts is no matter to a clip, nor to a band
        late: Pair | None = (0.0, 0.0)
        strong = None
        if stated.kind == "clip":
            peaks = [peak.gain for peak in peak_gains(scenario)]
            statement, high = OF_LINEAR_LOOPS.format(*peaks), max(peaks)
            sent = [speed + d for speed, d in zip(usable, stated.d, strict=True)]
            lost = [
                (u + d * (loop == "pi")) / 101
                for u, d, loop in zip(sent, stated.d, stated.loop, strict=True)
            ]
            strong = lost[0], lost[1]
        if stated.slew is not None:  # what varies of a delay is what costs
            statement, strong = BEHIND_SLEW.format(*stated.slew), None
            late = _cost(scenario, usable, {"filter.delay": later})
        swung, rise = _swung(scenario, usable, usable_speed), None
        slower = None
        if stated.kind == "band" and (rise := rise_times(scenario)) is not None:
            more = _swung(scenario, rise, rise_times)
            slower = None if more is None else (-more[0], -more[1])
        return FilterFacts(
            stated.kind, statement, high, usable, sided, late, strong, broken, overshoot(scenario),
            swung, rise, slower,
        )  # fmt: skip
    delayed = _cost(scenario, usable, {"filter.delay": later})
    larger = stated.each("gain", lambda ends: (ends[0], ends[1] * 1.01))
    stronger = _cost(scenario, usable, {"filter.gain": larger})
    return FilterFacts(stated.kind, statement, high, usable, sided, delayed, stronger, broken)


ON_THE_SPOT = {
    "base.min_radius": 0.0, "filter.free_error": None, "filter.nearing": 0.0, "filter.decel": None,
}  # fmt: skip
"""Overrides for a base whose axes move independently and which has no obstacles."""


def usable_speed(scenario: Scenario) -> Pair:
    """The slower direction of `usable_sides`, for each axis."""
    return _smaller(usable_sides(scenario))


def _smaller(sides: tuple[Pair, Pair]) -> Pair:
    linear, angular = (min(-low, high) for low, high in sides)
    return linear, angular


def usable_sides(scenario: Scenario) -> tuple[Pair, Pair]:
    """Speeds at rest in both directions of each axis [m/s, rad/s]: see `_usable`."""
    ahead = _usable(scenario, 1)
    back = _usable(scenario, -1) if scenario.limits.unequal else ahead
    return (-back[0], ahead[0]), (-back[1], ahead[1])


def _usable(scenario: Scenario, way: int) -> Pair:
    """Speeds at rest in one direction, ``way``, of the weakest base that the filter is stated for.

    The filter's own graph drives it, one axis at a time.  It has the smallest gain and is pushed
    back by d.  Its odometry has the stated age and always reads too high by its whole error; it is
    absent if the sensors' odometry is older.  In steady state neither time constant nor delay
    matters.  For a band: the speed admitted after eight times as many commands as its longest
    tables contain.  For a governor of wheels, whose weakest base is not known: the speed admitted
    without odometry, which is less.
    """
    stated, free = scenario.filter, dict[str, object](ON_THE_SPOT)
    if stated.kind == "clip":  # it is told a rest with distances alone
        free["filter.rest"] = None
    filtering = CommandFilter(override(scenario, free))
    alone = stated.channels == "body" and stated.wheel_speed is None
    ends = [0.0, 0.0]
    for axis, limit in enumerate(scenario.limits.v_u1):
        filtering.start()
        asked = [0.0, 0.0]
        asked[axis] = way * 10 * limit
        if alone and hears(scenario):
            ends[axis] = way * _governed(filtering, scenario, asked, axis, way)
        else:
            sent = [filtering.step(asked).command for _ in range(_steps(scenario))][-1]
            ends[axis] = stated.intervals("gain")[axis][0] * way * sent[axis] - stated.d[axis]
    return ends[0] + 0.0, ends[1] + 0.0  # no -0.0


def hears(scenario: Scenario) -> bool:
    """True if a governor's odometry is recent enough to be used."""
    stated, age = scenario.filter, scenario.section(VelocityMean).velocity_age
    young = age <= stated.age + NEAR * scenario.clock.control
    return stated.kind == "governor" and stated.odometry is not None and young


def _governed(
    filtering: CommandFilter, scenario: Scenario, asked: Sequence[float], axis: int, way: int
) -> float:
    """Steady speed of the weakest base of an axis behind a governor."""
    stated = scenario.filter
    assert stated.odometry is not None
    (_, tau), (_, last), (K, _) = (stated.intervals(key)[axis] for key in ("tau", "delay", "gain"))
    T, d = scenario.clock.control, way * stated.d[axis]
    whole, part = divmod(last / T, 1.0)
    v, commands, measured = 0.0, [0.0] * (int(whole) + 2), [0.0, 0.0]
    for _ in range(_steps(scenario)):
        measured[axis] = v + way * stated.odometry[axis]
        sent = filtering.step(asked, measured, age=stated.age).command[axis]
        commands = [sent, *commands[:-1]]
        for command, share in ((commands[int(whole) + 1], part), (commands[int(whole)], 1 - part)):
            v -= math.expm1(-share * T / tau) * (K * command - d - v)
    return v


def rise_times(scenario: Scenario) -> Pair | None:
    """Times [s] after which a filter sends NEARLY all of its limits; None if it never does.

    For commands far beyond them, from rest, one axis at a time; linear between samples.
    """
    scenario = override(scenario, {"filter.scale": "axes", **ON_THE_SPOT})
    step, limits = CommandFilter(scenario).step, np.array(scenario.limits.v_max)
    asked = (10 * limits).tolist()
    sent = np.array([(0.0, 0.0), *(step(asked).command for _ in range(_steps(scenario)))])
    times = []
    for share in (sent / (NEARLY * limits)).T:
        if share.max() < 1:
            return None
        k = int(np.argmax(share >= 1))
        times.append(scenario.clock.control * (k - (share[k] - 1) / (share[k] - share[k - 1])))
    return times[0], times[1]


def _swung(
    scenario: Scenario,
    usable: Pair,
    of: Callable[[Scenario], Pair | None],
) -> Pair | None:
    """Loss of ``of`` if steps of v, and of omega, overshoot by one per cent more."""
    costs = [0.0, 0.0]
    for axis, loop in enumerate(scenario.filter.loop):
        if loop == "first-order":
            continue
        key = "damping" if loop == "second-order" else "kp"
        share = less_damped(scenario, axis, PER_CENT)
        harder = scenario.filter.each(key, partial(_weakened, share))
        if (loss := _cost(scenario, usable, {f"filter.{key}": harder}, of)) is None:
            return None
        costs[axis] = loss[axis]
    return costs[0], costs[1]


def _weakened(share: float, ends: Pair) -> Pair:
    return share * ends[0], ends[1]


def _steps(scenario: Scenario) -> int:
    """Number of commands after which a filter's output is steady."""
    stated, T = scenario.filter, scenario.clock.control
    if stated.kind == "governor":
        times = zip(stated.intervals("tau"), stated.intervals("delay"), strict=True)
        longest = max(SETTLED * tau + last for (_, tau), (_, last) in times)
        return min(MOST_STEPS, int(longest / T) + 2)
    if stated.slew is not None:
        limits = zip(scenario.limits.v_max, stated.slew, strict=True)
        return math.ceil(max(V / a for V, a in limits) / T) + 1
    return 8 * MOST_COMMANDS if stated.kind == "band" else 1  # pushes make it slow to get there


def _cost(
    scenario: Scenario,
    usable: Pair,
    overrides: Mapping[str, Intervals],
    of: Callable[[Scenario], Pair | None] | None = None,
) -> Pair | None:
    """Loss of usable speed under a more demanding statement; None if the filter refuses it."""
    try:
        less = (of or usable_speed)(override(scenario, overrides))
    except ScenarioError:
        return None
    return None if less is None else (usable[0] - less[0], usable[1] - less[1])


def filter_advice(setup: Setup) -> str:
    """Advice on how to set a filter."""
    if assumed := [key for key in setup.scenario.assumed if key.startswith("filter.")]:
        return f"Before you set filter.kind, state {', '.join(assumed)}: nobody did."
    return 'Set filter.kind = "clip"; what [filter] has to state for it is then named.'


def velocity_base(loop: Loop) -> Iterator[Warning]:
    """Yield what is not guaranteed for a base that takes velocities."""
    scenario = loop.scenario
    if not loop.setup.takes_velocity:
        return
    if scenario.filter.kind == "none":
        yield Warning(
            "filter.kind",
            'filter.kind = "none": nothing guarantees that the base keeps limits.v_u1. '
            f"{filter_advice(loop.setup)}",
            "docs/filter.md",
            objects=False,
        )
    stated, sensed = scenario.filter, scenario.section(VelocityMean).velocity_age
    if stated.kind == "governor" and stated.odometry is not None and not hears(scenario):
        yield Warning(
            "filter.age",
            f"filter.age = {stated.age:g} s: the sensors' velocity is {sensed:g} s old, "
            "so the governor uses none of it and leaves no more than a clip. Raise filter.age to "
            f"{sensed:g} s, or leave out filter.odometry.",
            "docs/filter.md",
            objects=False,
        )
    if stated.kind != "none" and unbounded(scenario):
        yield Warning(
            "disturbance.truncate",
            f"disturbance.truncate = inf: torque noise beyond {SIGMAS:g} std can break the limits, "
            f"since the filter assumes no more. Set it to {SIGMAS:g} for a guarantee.",
            "docs/filter.md",
            objects=False,
        )
    for key, sentence in unproved_roundings(scenario):
        yield Warning(key, sentence, "docs/filter.md", objects=False)
    for sentence in broken_hypotheses(scenario, loop.setup.bound):
        yield Warning("filter.trust", f"The filter has no guarantee: {sentence}", "docs/filter.md")
