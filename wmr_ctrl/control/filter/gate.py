"""Gate before a base: a command filter with ramps, time-outs, a stop, and a latch after it.

The source of commands may die, repeat itself, jump or send nonsense.  A command that is too old,
missing odometry if it is required, a base faster than its bounds allow, and a stop each lead to
zeros.  The filter is the last stage, so for any input the output is a command that the filter may
send.
"""

import math
from dataclasses import dataclass
from functools import reduce

import casadi as ca

from wmr_ctrl.core.errors import ArgumentError, ScenarioError
from wmr_ctrl.core.signals import ASKED, LARGEST, ODOMETRY_AGE, Signal, places
from wmr_ctrl.world.model.system import Output, System, port
from wmr_ctrl.world.scenario import Scenario

from .channels import AXES, ELAPSED, FLAG_NAMES, LIMITED, TOLD, usable_time, within
from .filter import filter_system
from .heard import ODOMETRY
from .stopping import WAITED

COMMAND_AGE = Signal("command_age", "s", "time since the command came; negative: there is none")
STOP = Signal("stop", "1", "1: stop at once, and stay stopped")
RESET = Signal("reset", "1", "1: unlatch after a stop or after a base too fast")
LATCHED = Signal("latched", "1", "1: stopped until a reset")
LAST = Signal("v_last", "m/s, rad/s", "command of the step before", 2)
SENT = Signal("v_gate", "m/s, rad/s", "command that goes to the base", 2)
FLAGS = Signal("gate_flags", "1", "sum of the flags that are set")

STOPPED, NO_COMMAND, NO_ODOMETRY, TOO_FAST, RAMPED = 64, 128, 256, 512, 1024
GATE_FLAGS = {
    **FLAG_NAMES,
    STOPPED: "stopped",
    NO_COMMAND: "no-command",
    NO_ODOMETRY: "no-odometry",
    TOO_FAST: "too-fast",
    RAMPED: "ramped",
}
"""Bits of the flags beside the filter's own: see `Gate.step`."""
ODOMETRY_USES = ("none", "watched", "required")


@dataclass(frozen=True, kw_only=True)
class GateSettings:
    """Times and ramps of a gate.

    ``command_timeout`` and ``odometry_timeout`` [s]: older messages are ignored.  ``odometry``:
    "required" (without it the base is brought to rest), "watched" (its absence is reported) or
    "none". ``rise`` and ``fall``: largest change of the command away from zero and towards it
    [m/s2, rad/s2].  ``excess`` [m/s, rad/s]: odometry this far beyond the limits means that an
    assumption of the filter is wrong.
    """

    command_timeout: float = 0.25
    odometry_timeout: float = 0.1
    odometry: str = "watched"
    rise: tuple[float, float] = (1.0, 2.0)
    fall: tuple[float, float] = (2.0, 4.0)
    excess: tuple[float, float] = (0.05, 0.1)

    def __post_init__(self) -> None:
        """Refuse settings that no gate can satisfy."""
        if self.odometry not in ODOMETRY_USES:
            raise ArgumentError(
                f"odometry = {self.odometry!r} must be one of {', '.join(ODOMETRY_USES)}."
            )
        for name in ("command_timeout", "odometry_timeout", "rise", "fall", "excess"):
            value = getattr(self, name)
            numbers = value if isinstance(value, tuple) else (value,)
            if not all(0 < number < math.inf for number in numbers):
                raise ArgumentError(f"{name} = {value!r} must be positive and finite.")


def gate_system(scenario: Scenario, settings: GateSettings) -> System:
    """The gate of a scenario's filter; inputs and outputs as in `Gate.step`.

    Raises ScenarioError if no filter is set, or if its limit cannot be kept.
    """
    return gate_and_goal(scenario, settings)[0]


def gate_and_goal(scenario: Scenario, settings: GateSettings) -> tuple[System, ca.SX]:
    """`gate_system`, and the command and flags that its ramp aims at."""
    if scenario.filter.slew is not None:
        raise ScenarioError(
            "filter.slew: a gate sends 0 at once when its program stops, but this filter "
            "assumes that commands change only as it sends them. Leave it out: without it, "
            'filter.kind = "clip" or "band" keeps its promise behind a gate.'
        )
    if scenario.filter.least:
        raise ScenarioError(
            "filter.least: a gate ramps commands, and would make up for each small one on a ramp. "
            "Leave it out: a gate sends small commands as they are asked for."
        )
    inner = filter_system(scenario)
    ports = {item.signal: item for item in inner.inputs}
    asked, age, stop, reset = port(ASKED), port(COMMAND_AGE, -1.0), port(STOP), port(RESET)
    odometry = ports.get(ODOMETRY, port(ODOMETRY))
    odometry_age = ports.get(ODOMETRY_AGE, port(ODOMETRY_AGE, -1.0))
    elapsed = ports.get(ELAPSED, port(ELAPSED))
    latched, last = port(LATCHED), port(LAST)

    seen = _fresh(odometry_age.sym, settings.odometry_timeout)
    over = ca.logic_and(seen, _beyond(odometry.sym, scenario, settings))
    holds = ca.logic_or(latched.sym > 0, over)
    stays = ca.logic_or(stop.sym > 0, ca.if_else(reset.sym > 0, over, holds))
    came = ca.logic_and(_fresh(age.sym, settings.command_timeout), _usable(asked.sym))
    blind = ca.logic_not(seen) if settings.odometry == "required" else ca.SX(0)
    drives = ca.logic_and(came, ca.logic_not(ca.logic_or(stays, blind)))

    (own,) = (item for item in inner.inputs if item.signal == ASKED)

    def filtered(command: ca.SX) -> list[ca.SX]:
        return list(ca.substitute([inner.y, inner.update], [own.sym], [command]))

    wanted = ca.if_else(drives, asked.sym, 0)
    # first, so that a ramp ends at a curvature that was asked for
    goal, aimed = filtered(wanted)
    budget = usable_time(elapsed.sym, ca.SX(scenario.clock.control))
    ramped = ca.vertcat(*(
        ramp(last.sym[i], goal[i], (settings.rise[i], settings.fall[i]), budget)
        for i in AXES
    ))  # fmt: skip
    offered = ca.if_else(stop.sym > 0, 0, ramped)
    y, update = filtered(offered)
    sent = y[:2]
    update, following = _leaving(inner, (update, aimed), (offered, sent))
    missing = ca.logic_not(seen) if settings.odometry != "none" else ca.SX(0)
    less = ca.logic_and(_same(goal, wanted), ca.logic_not(_same(sent, offered)))
    bits = ((less, LIMITED), (stays, STOPPED), (ca.logic_not(came), NO_COMMAND),
            (missing, NO_ODOMETRY), (over, TOO_FAST),
            (ca.logic_not(_same(offered, goal)), RAMPED))  # fmt: skip
    flags = reduce(lambda total, bit: total + ca.if_else(bit[0], bit[1], 0), bits, goal[2])
    further = (ports[signal] for signal in TOLD if signal in ports)
    inputs = (asked, age, odometry, odometry_age, elapsed, stop, reset, *further)
    gate = System(
        "gate", f"gate before a base: {inner.title}", inputs=inputs,
        state=(*inner.state, latched, last), params=inner.params,
        update=ca.vertcat(update, ca.if_else(stays, 1, 0), following),
        outputs=(Output(SENT, sent), Output(FLAGS, flags)), period=inner.period,
    )  # fmt: skip
    return gate, goal


def _leaving(
    inner: System, updates: tuple[ca.SX, ca.SX], commands: tuple[ca.SX, ca.SX]
) -> tuple[ca.SX, ca.SX]:
    """The filter's next state, and the command from which the next ramp begins.

    ``updates``: next states for the ``offered`` command and for the requested one.  The request
    counts while a base waits to leave, and the ramp begins meanwhile.  ``commands``: offered and
    sent.
    """
    (update, aimed), (offered, sent) = updates, commands
    rows = places(item.signal for item in inner.state).get(WAITED.name)
    if rows is None:
        return update, sent
    update[rows] = aimed[rows]
    return update, ca.if_else(ca.sum1(aimed[rows]) > 0, offered, sent)


def ramp(last: ca.SX, wanted: ca.SX, rates: tuple[float, float], time: ca.SX) -> ca.SX:
    """The value nearest to ``wanted`` that is reachable from ``last`` in a ``time`` [s].

    ``rates``: away from 0 and towards it; a change of sign uses each for its part of the time.
    """
    rise, fall = rates
    up, down = last + fall * time, last - fall * time  # beyond 0 the rest of the time rises
    high = ca.if_else(last < 0, ca.if_else(up > 0, rise / fall * up, up), last + rise * time)
    low = ca.if_else(last > 0, ca.if_else(down < 0, rise / fall * down, down), last - rise * time)
    return ca.fmin(ca.fmax(wanted, low), high)


def _same(one: ca.SX, other: ca.SX) -> ca.SX:
    return ca.logic_and(one[0] == other[0], one[1] == other[1])


def _fresh(age: ca.SX, timeout: float) -> ca.SX:
    return ca.logic_and(age >= 0, age <= timeout)


def _usable(pair: ca.SX) -> ca.SX:
    return reduce(ca.logic_and, (within(pair[i], LARGEST) for i in AXES))


def _beyond(odometry: ca.SX, scenario: Scenario, settings: GateSettings) -> ca.SX:
    """1 if odometry exceeds a limit by more than the excess, or is not a number."""
    tests = [
        ca.logic_and(
            odometry[i] >= low - settings.excess[i], odometry[i] <= high + settings.excess[i]
        )
        for i, (low, high) in enumerate(scenario.limits.sides)
    ]
    return ca.logic_not(reduce(ca.logic_and, tests))


@dataclass(frozen=True)
class Gated:
    """Result of a gate's step: velocities [m/s, rad/s], and flags as texts."""

    command: tuple[float, float]
    flags: tuple[str, ...]
