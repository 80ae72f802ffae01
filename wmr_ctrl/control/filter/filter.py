"""Command filter as one sampled System, and as an object for Python programs.

A command (v, omega) goes in, with odometry if there is any, and the nearest safe command comes out.
Either one factor scales both axes, so that the path keeps its curvature, or each axis has its own.
"""

import math
import warnings
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import casadi as ca
import numpy as np

from wmr_ctrl.control.sides import LIMITS
from wmr_ctrl.core.errors import ArgumentError, ScenarioError
from wmr_ctrl.core.fields.arguments import checks_arguments
from wmr_ctrl.core.fields.section import quantities
from wmr_ctrl.core.fields.units import meant, rounded
from wmr_ctrl.core.fields.values import Pair
from wmr_ctrl.core.signals import ASKED, ODOMETRY_AGE, Signal
from wmr_ctrl.world.model.evaluate import evaluated
from wmr_ctrl.world.model.system import Output, System, port, stack, values
from wmr_ctrl.world.scenario import Scenario, load_scenario, override, unit_questions
from wmr_ctrl.world.scenario.command_filter import FIRST_ORDER, Filter

from .asked import for_base
from .band import NAMES, BandGovernor, check_beat
from .channels import (
    AXES,
    ELAPSED,
    FLAG_NAMES,
    FREE,
    FREE_AGE,
    ROUNDING,
    largest_commands,
)
from .clip import Clip, slew_reach
from .enclosure import Floats
from .governor_step import Governor, check_jitter
from .heard import ODOMETRY
from .peak_gain import peak_gains, pi_loop, refuse_all
from .ramp_stop import RampStopper
from .stopping import StoppingGovernor


def _damped(scenario: Scenario, axis: int) -> str:
    """Advice on how to lower a loop's peak gain to just below LARGEST_PEAK.

    For a PI loop it names each change of one bound that leaves a valid interval, or all changes if
    none does.
    """
    fades, stated = -1.02 * math.log(1 - 2 / (LARGEST_PEAK + 1)) / math.pi, scenario.filter
    if stated.loop[axis] == "second-order":
        return f"{stated.place('damping', axis, 1)} of at least {rounded(fades, 3)}"
    loop = pi_loop(scenario, axis)
    (least, most), (soft, stiff), (light, heavy) = loop.kp, loop.ki, loop.M
    firm, bound = 2 * fades * math.sqrt(stiff * heavy), (least / (2 * fades)) ** 2
    inert = scenario.robot.l**2 if axis else 1.0
    heaviest = rounded(bound / stiff * inert, 3, up=False)
    ends = {
        f"kp[1] of at least {rounded(firm, 3)}": firm <= most,
        f"ki[2] of at most {rounded(bound / heavy, 3, up=False)}": bound / heavy >= soft,
        f"{('mass', 'inertia')[axis]}[2] of at most {heaviest}": bound / stiff >= light,
    }
    fit = [f"filter.{text}" for text, fits in ends.items() if fits or not any(ends.values())]
    return " or ".join(fit)


def _which(reached: float, limit: float, of: str) -> tuple[str, str, float, float]:
    """Texts of the speed that pushes cause and of the bound that it violates.

    Then factors for the stated push and for the limit that would satisfy the bound.
    """
    if reached >= limit:
        return f"{reached:g}", f"{of} = {limit:g}", limit / reached, 1.0
    room = limit * (1 - ROUNDING)
    return f"{reached:.12g}", f"{of} less 1.5e-8 of it for rounding, {room:.12g}", 0.99, 1.01


def _finite(speed: float) -> str:
    return "any speed" if speed == math.inf else f"{speed:.3g}"


def check_filter(scenario: Scenario) -> None:
    """Raise ScenarioError if no command is safe, or if there is nothing to filter."""
    settings, sizes = scenario.filter, [(high, -low) for low, high in scenario.limits.sides]
    if settings.kind == "none":
        raise ScenarioError(
            'filter.kind = "none": this scenario has no command filter. Set filter.kind = "clip", '
            '"governor" or "band".'
        )
    if settings.least and not any((*scenario.base.deadband, scenario.base.wheel_deadband)):
        raise ScenarioError(
            "filter.least = true sends the least command that acts for a smaller one, and "
            "base.deadband and base.wheel_deadband are 0: every command acts. State a dead band, "
            "or leave out filter.least."
        )
    if scenario.base.min_radius and settings.scale != "curvature":
        raise ScenarioError(
            f'filter.scale = "{settings.scale}" may slow the base down while it turns, tighter '
            f"than base.min_radius = {scenario.base.min_radius:g} m. Use "
            'filter.scale = "curvature".'
        )
    peaks, K = peak_gains(scenario), settings.intervals("gain")
    reached = [item.push for item in peaks]
    high = [i for i in AXES if peaks[i].gain > LARGEST_PEAK * K[i][1]]
    faults = []
    if high:
        driven = " and ".join(f"{NAMES[i]} to {_finite(peaks[i].gain)}" for i in high)
        pi = settings.loop[high[0]] == "pi"
        most = f"{LARGEST_PEAK:g}{'' if pi else ' ' + settings.place('gain', high[0], 2)}"
        advice = " and ".join(dict.fromkeys(_damped(scenario, i) for i in high))
        faults.append(
            f"filter.loop: commands of at most 1 can drive {driven}, the peak gain N. N <= {most} "
            "is required: a loop with hardly any damping leaves no useful limit. State "
            f"{advice}, if that holds for the base."
        )
    faults += [*_unequal(scenario, reached)]
    for i in AXES:
        largest = max(sizes[i])
        if i not in high and reached[i] >= largest * (1 - ROUNDING):
            key, _ = scenario.limits.side(i, 1 if largest == sizes[i][0] else -1)
            far, bound, less, more = _which(reached[i], largest, key)
            pushes = settings.loop[i] == "pi" and any(settings.push)
            name, stated = ("push", settings.push) if pushes else ("d", settings.d)
            faults.append(
                f"filter.{name}[{i + 1}] = {stated[i]:.12g} alone drives the base to {far}, "
                f"which must be below {bound}: no command is safe. State a push below "
                f"{rounded(stated[i] * less, 3, up=False)}, or a limit above "
                f"{rounded(reached[i] * more, 3)}."
            )
    refuse_all(faults)
    if settings.kind == "band":
        check_beat(scenario)
    if settings.slew is not None:
        _check_slew(scenario, settings.slew)
    _check_rim(scenario, reached)


def _check_rim(scenario: Scenario, reached: Sequence[float]) -> None:
    """Raise ScenarioError if pushes alone take a wheel's speed to its limit."""
    settings, sizes = scenario.filter, [(high, -low) for low, high in scenario.limits.sides]
    rim, apart = reached[0] + scenario.robot.l * reached[1], settings.channels == "wheels"
    tops = [settings.wheel_speed] if settings.wheel_speed is not None else []
    tops += [min(sizes[0]), scenario.robot.l * min(sizes[1])] if apart else []
    if tops and rim >= min(tops) * (1 - ROUNDING):
        least = (
            "the least of filter.wheel_speed, of the limits of v and robot.l times those of omega"
        )
        far, bound, *_ = _which(rim, min(tops), f"{least} that limits it")
        raise ScenarioError(
            f"filter.d drives a wheel to {far} m/s by itself, which must be below {bound}: no "
            "command is safe. State a smaller push, or a higher limit."
        )


def _unequal(scenario: Scenario, reached: Sequence[float]) -> Iterator[str]:
    """Objections to limits that differ by direction and cannot be kept; ``reached``: speeds that
    pushes cause.
    """
    settings, limits = scenario.filter, scenario.limits
    for i in limits.unequal:
        named = f"limits.v_min[{i + 1}] = {limits.v_min[i]:g}, limits.v_max[{i + 1}] ="
        differ = f"{named} {limits.v_max[i]:g}: both directions differ, and"
        if settings.kind == "band":
            yield f'{differ} filter.kind = "band" keeps one for both. State one, or take the clip.'
        elif settings.loop[i] != "first-order" and (settings.slew or settings.channels == "wheels"):
            key = "filter.slew" if settings.slew else "filter.channels"
            yield (
                f"{differ} with {key} the swing of a loop that overshoots (filter.loop) is bounded "
                f"only for one limit both ways. State one, or leave out {key}."
            )
        for way, size in ((1, limits.v_max[i]), (-1, -limits.v_min[i])):
            key, _ = limits.side(i, way)
            if size < reached[i]:
                yield (
                    f"filter.d[{i + 1}] = {settings.d[i]:g} alone drives the base to "
                    f"{way * reached[i]:g}, and {key} is {way * size:g}: nothing keeps it from "
                    f"rolling that way. State {key} = {way * reached[i]:g}: then no command that "
                    "way is ever sent."
                )


def _check_slew(scenario: Scenario, slew: tuple[float, float]) -> None:
    """Raise ScenarioError if the slew limit does not allow larger commands."""
    check_jitter(scenario)
    refuse_all(
        f"filter.slew[{i + 1}] = {slew[i]:g} brings no gain: from {worth:.3g} on, slow commands "
        "get no larger limit than others. State a smaller value, leave out filter.slew, or use "
        'filter.kind = "band".'
        for i, worth in enumerate(worthwhile_slew(scenario))
        if slew[i] >= worth
    )


def worthwhile_slew(scenario: Scenario) -> tuple[float, float]:
    """Slew [m/s2, rad/s2] of a linear loop above which slow commands get no larger limit."""
    reach, peaks, K = slew_reach(scenario), peak_gains(scenario), scenario.filter.intervals("gain")
    linear, angular = (
        (scenario.limits.smaller[i] - peak.push) * (1 - K[i][1] / peak.gain) / reach[i]
        for i, peak in enumerate(peaks)
    )
    return linear, angular


LARGEST_PEAK = 100.0
"""Largest peak gain of a filter: beyond it less than a per cent of the limit is left."""

SHRUNK = 1 - 1e-12
"""Share of a limit within which a command passes, roundings of the filter's own sums included."""
SIDES = ("v", "omega", "the right wheel", "the left wheel")
UNITS_COUNT = ("filter.", "limits.", "clock.")
"""Keys by which a filter's numbers come."""
STANDING = -1.0
"""Time since the last step by a clock that did not go on: 0 would say that nobody tells it."""
TOLD = Signal("told", "1", "1: the time since the previous sample was told before")


def graph_of(scenario: Scenario) -> Clip | Governor | BandGovernor:
    """Graph of a scenario's filter, which depends on the filter's kind and inputs."""
    settings = scenario.filter
    if settings.kind == "clip":
        return Clip(scenario) if settings.free_error is None else RampStopper(scenario)
    if settings.kind == "governor":
        return StoppingGovernor(scenario) if settings.is_told else Governor(scenario)
    return BandGovernor(scenario)


def derived_numbers(scenario: Scenario) -> dict[str, tuple[Signal, tuple[float, ...]]]:
    """Parameters of a linear loop's filter that are derived, not stated, by name.

    These are peak gains, responses to pushes, and tables of step responses.
    """
    if scenario.filter.kind == "none" or scenario.filter.loop == FIRST_ORDER:
        return {}
    stated = {f"filter.{name}" for name, _ in quantities(Filter)}
    own = (item for item in filter_system(scenario).params if item.signal.name not in stated)
    return {
        item.signal.name: (item.signal, item.value)
        for item in own
        if item.signal.name.startswith("filter.")
    }


def filter_system(scenario: Scenario) -> System:
    """The command filter of a scenario; inputs and outputs as in `CommandFilter.step`.

    Raises ScenarioError if no filter is set, or if its limit cannot be kept.
    """
    check_filter(scenario)
    return for_base(graph_of(scenario).system, scenario)


def filter_questions(scenario: Scenario) -> Iterator[str]:
    """Questions about filter numbers whose unit looks mistaken, or that nobody stated."""
    for key, question in unit_questions(scenario):
        if key.startswith(UNITS_COUNT):
            yield question
    if assumed := [key for key in scenario.assumed if key.startswith(("filter.", "limits."))]:
        keys = ", ".join(assumed)
        yield f"Nobody stated {keys}: the limits are kept only while these values hold. Measure."


def called_filter(scenario: Scenario) -> System:
    """`filter_system` for Python: once a step's time was not 0, 0 means that no time passed.

    Before that, 0 means that the time is unknown.  A clip without memory ignores repeated calls:
    its limits do not depend on the time.
    """
    system = filter_system(scenario)
    if not system.state:
        return system
    (elapsed,) = (item.sym for item in system.inputs if item.signal == ELAPSED)
    memory = port(TOLD)
    repeated = ca.logic_and(memory.sym > 0, elapsed == 0)
    since = ca.if_else(repeated, STANDING, elapsed)
    exprs = (system.update, *(item.expr for item in system.outputs))
    update, *outputs = ca.substitute(list(exprs), [elapsed], [since])
    signals = (item.signal for item in system.outputs)
    return replace(
        system,
        state=(*system.state, memory),
        update=ca.vertcat(update, ca.if_else(elapsed == 0, memory.sym, 1)),
        outputs=tuple(map(Output, signals, outputs)),
    )


def passing_commands(scenario: Scenario) -> list[tuple[str, Pair, Pair]]:
    """Commands that always pass: by name, a speed's parts of v and omega, and the two ends.

    This is valid for any history: the limits are the clip's own, and a governor's are never
    smaller, since its speed bound is at most V (ledger: filter.contains-clip).  It serves a clip
    without slew and a governor, as runs have them; it is empty without a filter.  Both ends are 0
    if no command surely passes, for example with obstacles in the way.
    """
    if scenario.filter.kind == "none":
        return []
    check_filter(scenario)
    plain = override(scenario, {"filter.changing": False})
    built: Clip | Governor = Clip(plain) if plain.filter.kind == "clip" else Governor(plain)
    if isinstance(built, Clip):
        ways = built.limits, built.behind
    else:
        ways = largest_commands(built.channels)
    ahead, back = (ca.vertcat(*way) for way in ways)
    units = ((1, 0), (0, 1))
    rows = ca.vertcat(*(ca.horzcat(*map(item.of, units)) for item in built.channels))
    ports = built.p.ports
    numbers = [stack(item.sym for item in ports)]
    graph = ca.Function("passing", numbers, [ca.horzcat(-back, ahead), rows, built.sound])
    most, sides, sound = (item.full() for item in graph(values(ports)))
    most = most * sound * (scenario.filter.free_error is None or not scenario.obstacles)
    names = SIDES[2:] if scenario.filter.channels == "wheels" else SIDES
    found = [
        (name, (float(row[0]), float(row[1])), (float(ends[0]) * SHRUNK, float(ends[1]) * SHRUNK))
        for name, row, ends in zip(names, sides, most, strict=False)
    ]
    if scenario.filter.channels == "wheels" and scenario.filter.scale == "turn":
        _, (_, arm), (low, high) = found[0]
        least = min(-low, high)  # it goes first, as if v were 0
        found.append(("the turn alone", (0.0, arm), (-least, least)))
    return found


@dataclass(frozen=True)
class Filtered:
    """Result of a filter: velocities [m/s, rad/s], and flags as texts."""

    command: tuple[float, float]
    flags: tuple[str, ...]


class CommandFilter:
    """The command filter of a scenario, step by step; see `command_filter`."""

    def __init__(self, scenario: Scenario) -> None:
        """Build the graph; raises ScenarioError if no filter is set, or if its limit cannot be
        kept.
        """
        self.system, self._scenario = called_filter(scenario), scenario
        self.period = scenario.clock.control
        dense = [ca.densify(item) for item in (self.system.update, self.system.y)]
        self._step, self._p = self.system.function("filter", dense), np.array(self.system.p0)
        self.start()

    def __reduce__(self) -> tuple[object, ...]:
        """Pickle as the scenario and the memory."""
        return CommandFilter, (self._scenario,), {"_x": self._x.copy()}

    def start(self) -> None:
        """Restart with 0 as the last command.

        Start a band or a clip with slew only while the base rests; in motion a band breaks its
        limit. A governor's base may have any speed within its limits, but earlier commands must
        have ceased to act, unless delay, losses and age are 0. A clip has no memory.
        """
        self._x = np.array(self.system.x0)
        self._limits = tuple(end for side in self._scenario.limits.sides for end in side)

    @checks_arguments
    def step(
        self,
        command: Sequence[float] | Floats,
        measured: Sequence[float] | Floats | None = None,
        age: float = 0.0,
        dt: float | None = None,
        limits: Sequence[Sequence[float]] | None = None,
        free: Sequence[float] | None = None,
        free_age: float = 0.0,
        turn: Sequence[float] = (math.inf, math.inf),
    ) -> Filtered:
        """The safe command (v [m/s], omega [rad/s]) nearest to ``command``, and flags.

        ``measured``: the odometry's velocities, ``age`` [s] old, if there are any. ``dt`` [s]: time
        since the last step by a steady clock (`time.monotonic`), by default the clock's period, and
        a band's steps must then come on that beat; once a ``dt`` was given, a missing one counts as
        0. 0 or less means that the clock stopped or was set back; a ``dt`` longer than the time
        that has passed breaks a band's limit. A command that is not a number counts as (0, 0). The
        flags are `channels.FLAG_NAMES` (docs/filter.md). ``limits``: of v and of omega, each (least
        [m/s, rad/s], largest); ``free``: free distance ahead and behind [m], ``free_age`` [s] old;
        ``turn``: free turning to the left and to the right [rad].  Raises ArgumentError for wrong
        lengths.
        """
        if dt is not None and dt > 100 * self.period:
            self._ask(dt)
        seen = (0.0, 0.0) if measured is None else _pair(measured, "measured")
        told = {
            ASKED: _pair(command, "command"),
            ODOMETRY: seen,
            ODOMETRY_AGE: (-1.0 if measured is None else age,),
            ELAPSED: (0.0 if dt is None else dt or STANDING,),
            **self._told(limits, free, free_age, turn),
        }
        u = [number for item in self.system.inputs for number in told[item.signal]]
        self._x, y = evaluated(self._step, u, self._x, self._p)
        sent = y.ravel().tolist()
        names = tuple(name for bit, name in FLAG_NAMES.items() if int(sent[2]) & bit)
        return Filtered((sent[0], sent[1]), names)

    def _told(
        self,
        limits: Sequence[Sequence[float]] | None,
        free: Sequence[float] | None,
        free_age: float,
        turn: Sequence[float],
    ) -> dict[Signal, tuple[float, ...]]:
        """Limits (the last ones if none are given) and free distances; ArgumentError if
        unusable.
        """
        settings = self._scenario.filter
        if limits is not None:
            if not settings.changing:
                raise ArgumentError(
                    "limits is given, but this filter's never change. Set filter.changing = true."
                )
            if len(limits) != 2:
                raise ArgumentError(
                    f"limits has {len(limits)} pairs and must have two: {MEANINGS['limits']}."
                )
            linear, angular = (_pair(side, "limits") for side in limits)
            self._limits = (*linear, *angular)
        ways = (math.inf, math.inf) if free is None else _pair(free, "free")
        told = (*ways, *_pair(turn, "turn"))
        if settings.free_error is None and (free is not None or told != (math.inf,) * 4):
            raise ArgumentError(
                "free or turn is given, but this filter asks for no distances. Set "
                "filter.free_error [m]."
            )
        age = -1.0 if free is None else float(free_age)
        return {LIMITS: self._limits, FREE: told, FREE_AGE: (age,)}

    def _ask(self, dt: float) -> None:
        """Warn if a time looks like the clock's period in another unit."""
        if asked := meant(dt, "s", (0.5 * self.period, 2 * self.period)):
            warnings.warn(
                f"dt = {dt:g} s: clock.control is {self.period:g} s. {asked}", stacklevel=4
            )


@checks_arguments
def command_filter(scenario: Scenario | str) -> CommandFilter:
    """The command filter of a scenario with a section [filter], as an object with memory.

    Warns of numbers that look like another unit, such as milliseconds, and of assumed ones.
    Raises ScenarioError if no filter is set, or if its limit cannot be kept.
    """
    settings = load_scenario(scenario) if isinstance(scenario, str) else scenario
    built = CommandFilter(settings)
    for question in filter_questions(settings):
        warnings.warn(question, stacklevel=3)
    return built


COMMAND = "v [m/s], omega [rad/s]"
MEANINGS = {
    "limits": "(v_min, v_max) [m/s], (omega_min, omega_max) [rad/s]",
    "free": "ahead [m], behind [m]",
    "turn": "left [rad], right [rad]",
}


def _pair(values: Sequence[float] | Floats, name: str) -> tuple[float, float]:
    meaning = MEANINGS.get(name, COMMAND)
    if isinstance(values, np.ndarray) and (values.ndim != 1 or values.dtype.kind not in "fiu"):
        raise ArgumentError(
            f"{name} is an array of {values.dtype} with shape {values.shape} and must be two real "
            f"numbers: {meaning}."
        )
    if len(values) != 2:
        raise ArgumentError(f"{name} has {len(values)} numbers and must have two: {meaning}.")
    return float(values[0]), float(values[1])
