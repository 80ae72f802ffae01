"""The command filter as one sampled System, and as an object that Python programs call.

A command (v, omega) goes in, with odometry where there is some, and the nearest safe one comes out:
both axes scaled by one factor, so that the path keeps its curvature, or each by its own.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, reduce
from typing import TypeAlias

import casadi as ca

from wmr_ctrl.errors import ArgumentError, ScenarioError
from wmr_ctrl.fields.arguments import checks_arguments
from wmr_ctrl.filter.governor import (
    NEAR,
    FirstOrder,
    Schedule,
    SpeedBound,
    admitted,
    drive,
    largest_command,
)
from wmr_ctrl.guard.lateness import Times
from wmr_ctrl.model.system import Output, Parameters, System, port
from wmr_ctrl.scenario import Scenario, load_scenario
from wmr_ctrl.scenario.sections import MOST_PERIODS
from wmr_ctrl.signals import LARGEST, Signal

AXES = (0, 1)
WAYS = (1, -1)
Sides: TypeAlias = list[list[ca.SX]]
"""A number of both axes, of v first, then of -v."""
ROUNDING = 2.0**-26
"""Share of V that the filter stays away from the limit: some hundred roundings of doubles, and
times that are taken for the same (1e-9 of a period), are far below it."""

ASKED = Signal("v_asked", "m/s, rad/s", "commanded velocity (linear, angular)", 2)
ODOMETRY = Signal("v_odometry", "m/s, rad/s", "velocity that odometry tells", 2)
AGE = Signal("odometry_age", "s", "age of the odometry; negative: there is none")
ELAPSED = Signal("elapsed", "s", "time since the previous sample; 0: the clock's period")
SENT = Signal("v_sent", "m/s, rad/s", "command that is safe", 2)
FLAGS = Signal("filter_flags", "1", "sum of the bits of what is told")
ABOVE = Signal("v_above", "m/s, rad/s", "bound of the velocity", 2)
BELOW = Signal("v_below", "m/s, rad/s", "bound of the velocity's negative", 2)

LIMITED, UNUSED, BOUNDS_LEFT, LATE, REFUSED = 1, 2, 4, 8, 16
"""Bits of the flags, of which CommandFilter.step tells the meaning."""
FLAG_NAMES = {
    LIMITED: "limited",
    UNUSED: "unused",
    BOUNDS_LEFT: "bounds-left",
    LATE: "late",
    REFUSED: "refused",
}


def schedule(scenario: Scenario) -> Schedule:
    """The filter's times in control periods.

    Raises ScenarioError where they span more samples than the filter counts through.
    """
    settings, T = scenario.filter, scenario.clock.control
    if settings.jitter >= T:
        raise ScenarioError(
            f"filter.jitter = {settings.jitter:g} s must be less than the period between samples, "
            f"clock.control = {T:g} s."
        )
    first, last = settings.delay
    times = first, last, settings.jitter, settings.age, settings.hold
    in_periods = (float(item) for item in map(Times(T, scenario.clock.plant).in_periods, times))
    soonest, latest, jitter, age, hold = in_periods
    plan = Schedule((soonest, latest), settings.losses, jitter, age, hold)
    span = (last + settings.age) / (T - settings.jitter) + settings.losses
    if span > MOST_PERIODS:
        raise ScenarioError(
            f"filter: delay, age of odometry and losses span {span:.0f} control periods of {T:g} s "
            f"and the governor counts through at most {MOST_PERIODS}. State shorter ones, or take "
            'filter.kind = "clip", which needs none of them.'
        )
    return plan


def check_filter(scenario: Scenario) -> None:
    """Raise ScenarioError where no command is safe, or where there is nothing to filter."""
    settings, limits = scenario.filter, scenario.limits.v_u1
    if settings.kind == "none":
        raise ScenarioError(
            'filter.kind = "none": this scenario has no command filter. Set filter.kind = "clip" '
            'or "governor".'
        )
    for axis in AXES:
        if settings.d[axis] >= limits[axis] * (1 - ROUNDING):
            raise ScenarioError(
                f"filter.d[{axis + 1}] = {settings.d[axis]:g} must be below "
                f"limits.v_u1[{axis + 1}] = {limits[axis]:g}: such a push alone drives the base to "
                "its limit, so that no command is safe. State a smaller push, or a higher limit."
            )


def filter_system(scenario: Scenario) -> System:
    """The command filter of a scenario; inputs and outputs as in `CommandFilter.step`.

    Raises ScenarioError where the filter is not set, or cannot be met.
    """
    check_filter(scenario)
    return Governor(scenario).system if scenario.filter.kind == "governor" else _clip(scenario)


def _clip(scenario: Scenario) -> System:
    p, asked = Parameters(scenario), port(ASKED)
    r, refused = _command(asked.sym)
    hi = [largest_command(b.V, b) for b in _bounds(scenario, p, ca.SX(0))]
    sent = _limited(r, [-limit for limit in hi], hi, scenario.filter.scale)
    return System(
        "filter", "command filter (clip)", inputs=(asked,), params=p.ports,
        outputs=(Output(SENT, sent), Output(FLAGS, _flag(sent, r) + refused)),
        period=scenario.clock.control,
    )  # fmt: skip


class Governor:
    """The graph of a governor, step by step from odometry to the command that is sent."""

    def __init__(self, scenario: Scenario) -> None:
        """Take the ports; ScenarioError where the times span too many samples."""
        self.scenario, self.plan, self.p = scenario, schedule(scenario), Parameters(scenario)
        self.asked, self.odometry = port(ASKED), port(ODOMETRY)
        self.age, self.elapsed = port(AGE, -1.0), port(ELAPSED)
        self.known = [port(signal, scenario.limits.v_u1) for signal in (ABOVE, BELOW)]
        self.before = [port(_sent(number)) for number in range(1, self.plan.oldest + 1)]
        self.T, tau = self.p.take("clock.control"), self.p.take("filter.tau")
        kappa = 1 / ca.expm1(self.plan.longest * self.T / tau[0])
        self.bounds = _bounds(scenario, self.p, kappa)
        self.motions = [SpeedBound(self.plan, b, (tau[0], tau[1]), self.T) for b in self.bounds]
        self.command, self.refused = _command(self.asked.sym)

    @cached_property
    def seen(self) -> ca.SX:
        """1 where there is odometry, young enough and a number."""
        if self.scenario.filter.odometry is None:
            return ca.SX(0)
        age = 0.5 * self.plan.age * self.T
        young = _within(self.age.sym - age, age + NEAR * self.T)
        return reduce(
            ca.logic_and, [young, *(_within(self.odometry.sym[i], LARGEST) for i in AXES)]
        )

    @cached_property
    def punctual(self) -> ca.SX:
        """1 where the sample came within its jitter."""
        elapsed = ca.if_else(self.elapsed.sym == 0, self.T, self.elapsed.sym)
        return _within(elapsed - self.T, (self.plan.jitter + NEAR) * self.T)

    @cached_property
    def now(self) -> Sides:
        """Bounds of the speed at the sample: what was carried here, and what odometry says."""
        sides = []
        for way, known in zip(WAYS, self.known, strict=True):
            odometry = [
                motion.now(way * self.odometry.sym[i], self.age.sym, self._targets(way, i))
                for i, motion in enumerate(self.motions)
            ]
            carried = [ca.fmin(known.sym[i], self.bounds[i].V) for i in AXES]
            both = [ca.fmin(odometry[i], carried[i]) for i in AXES]
            sides.append([ca.if_else(self.seen, both[i], carried[i]) for i in AXES])
        return sides

    @cached_property
    def agrees(self) -> ca.SX:
        """1 where odometry and the stated bounds do not contradict each other."""
        return reduce(ca.logic_and, [self.now[0][i] + self.now[1][i] >= 0 for i in AXES])

    @cached_property
    def trusted(self) -> ca.SX:
        """1 where the bounds count; else the memoryless clip acts."""
        return ca.logic_and(self.agrees, self.punctual)

    @cached_property
    def start(self) -> Sides:
        """Bounds of the speed at the sample, V where they are not to be trusted."""
        return [
            [ca.if_else(self.trusted, side[i], self.bounds[i].V) for i in AXES] for side in self.now
        ]

    @cached_property
    def limits(self) -> Sides:
        """Largest commands that are safe, forwards and backwards, of both axes."""
        sides = []
        for way, side in zip(WAYS, self.now, strict=True):
            taken = [m.takeover(side[i], self._targets(way, i)) for i, m in enumerate(self.motions)]
            v_bar = [ca.if_else(self.trusted, taken[i], self.bounds[i].V) for i in AXES]
            sides.append([largest_command(v_bar[i], self.bounds[i]) for i in AXES])
        return sides

    @cached_property
    def sent(self) -> ca.SX:
        """The safe command (2,)."""
        upper, lower = self.limits
        return _limited(
            self.command, [-limit for limit in lower], upper, self.scenario.filter.scale
        )

    @cached_property
    def following(self) -> Sides:
        """Bounds of the speed at the next sample."""
        return [
            [
                motion.following(side[i], self._targets(way, i, self.sent))
                for i, motion in enumerate(self.motions)
            ]
            for way, side in zip(WAYS, self.start, strict=True)
        ]

    def _targets(self, way: int, axis: int, newest: ca.SX | None = None) -> list[ca.SX]:
        """Speed towards which each command of an axis may drive, by its age; [0]: the newest."""
        first = self.before[0].sym if newest is None else newest
        commands = [first, *(item.sym for item in self.before)]
        return [drive(way * command[axis], self.bounds[axis]) for command in commands]

    @property
    def system(self) -> System:
        """The sampled System, whose state is the bounds and the commands that may still act."""
        flags = _flag(self.sent, self.command) + self.refused + ca.if_else(self.seen, 0, UNUSED)
        flags += ca.if_else(self.agrees, 0, BOUNDS_LEFT) + ca.if_else(self.punctual, 0, LATE)
        bounds = [item for side in self.following for item in side]
        older = [item.sym for item in self.before[:-1]]
        return System(
            "filter",
            "command filter (governor)",
            inputs=(self.asked, self.odometry, self.age, self.elapsed),
            state=(*self.known, *self.before),
            params=self.p.ports,
            update=ca.vertcat(*bounds, self.sent, *older),
            outputs=(Output(SENT, self.sent), Output(FLAGS, flags)),
            period=self.scenario.clock.control,
        )


def _bounds(scenario: Scenario, p: Parameters, kappa: ca.SX) -> list[FirstOrder]:
    """Numbers of both axes; V is shrunk against rounding."""
    V, gain, d = (p.take(key) for key in ("limits.v_u1", "filter.gain", "filter.d"))
    nbar = p.take("filter.odometry") if scenario.filter.odometry else ca.SX.zeros(2)
    V = V * (1 - ROUNDING)
    return [FirstOrder(V[i], d[i], nbar[i], gain[0], gain[1], kappa) for i in AXES]


def _sent(age: int) -> Signal:
    return Signal(f"v_sent_{age}", "m/s, rad/s", f"command sent {age} samples ago", 2)


def _within(value: ca.SX, size: ca.SX | float) -> ca.SX:
    """1 where |value| <= size; 0 else, and for what is no number."""
    return ca.logic_and(value >= -size, value <= size)


def _command(asked: ca.SX) -> tuple[list[ca.SX], ca.SX]:
    """The command of both axes, 0 where it is no number, and the flag that says so."""
    usable = ca.logic_and(*(_within(asked[i], LARGEST) for i in AXES))
    return [ca.if_else(usable, asked[i], 0) for i in AXES], ca.if_else(usable, 0, REFUSED)


def _limited(r: list[ca.SX], lo: list[ca.SX], hi: list[ca.SX], scale: str) -> ca.SX:
    """The command within its limits, both axes by one factor or each by its own."""
    shares = admitted(r, lo, hi)
    common = ca.fmin(*shares)
    factors = shares if scale == "axes" else [common, common]
    return ca.vertcat(*(ca.fmin(ca.fmax(f * r[i], lo[i]), hi[i]) for i, f in enumerate(factors)))


def _flag(sent: ca.SX, r: list[ca.SX]) -> ca.SX:
    return ca.if_else(ca.logic_and(sent[0] == r[0], sent[1] == r[1]), 0, LIMITED)


@dataclass(frozen=True)
class Filtered:
    """Result of a filter: velocities [m/s, rad/s], and flags as words."""

    command: tuple[float, float]
    flags: tuple[str, ...]


class CommandFilter:
    """The command filter of a scenario, step by step; see `command_filter`."""

    def __init__(self, scenario: Scenario) -> None:
        """Build the graph; ScenarioError where the filter is not set, or cannot be met."""
        self.system = filter_system(scenario)
        self.governs = scenario.filter.kind == "governor"
        self._step = self.system.function("filter", [self.system.update, self.system.y])
        self._p = ca.DM(self.system.p0)
        self.start()

    def start(self) -> None:
        """Begin anew: the base is anywhere within its limits, and stands on no command."""
        self._x = ca.DM(self.system.x0)

    @checks_arguments
    def step(
        self,
        command: Sequence[float],
        measured: Sequence[float] | None = None,
        age: float = 0.0,
        dt: float | None = None,
    ) -> Filtered:
        """The safe command (v [m/s], omega [rad/s]) nearest to ``command``, and what is told.

        ``measured``: the odometry's velocities, ``age`` [s] old, if there are any.  ``dt`` [s]:
        time since the last step, the clock's period unless given.  A command that is no number
        gives (0, 0) and the flag "refused"; further flags are "limited", "unused" (no odometry was
        used), "bounds-left" (odometry contradicts the stated bounds: one of them is wrong) and
        "late" (the step came outside its jitter).  Raises ArgumentError for wrong lengths.
        """
        asked = _pair(command, "command")
        u = list(asked)
        if self.governs:
            seen = (0.0, 0.0) if measured is None else _pair(measured, "measured")
            u += [*seen, -1.0 if measured is None else age, 0.0 if dt is None else dt]
        self._x, y = self._step(ca.DM(u), self._x, self._p)
        sent = y.full().ravel().tolist()
        names = tuple(name for bit, name in FLAG_NAMES.items() if int(sent[2]) & bit)
        return Filtered((sent[0], sent[1]), names)


@checks_arguments
def command_filter(scenario: Scenario | str) -> CommandFilter:
    """The command filter of a scenario with a section [filter], as an object with a memory.

    Raises ScenarioError where the filter is not set, or cannot be met.
    """
    return CommandFilter(load_scenario(scenario) if isinstance(scenario, str) else scenario)


def _pair(values: Sequence[float], name: str) -> tuple[float, float]:
    if len(values) != 2:
        raise ArgumentError(
            f"{name} has {len(values)} numbers and must have two: v [m/s], omega [rad/s]."
        )
    return float(values[0]), float(values[1])
