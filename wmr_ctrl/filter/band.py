"""Governor of linear loops of any damping, from the commands that it sent: no odometry is used.

The base: v = sum of Delta_j S(age_j) + what pushes lead to, |.| <= delta, with Delta_j the changes
of its command so far and a step response S between low and high (`step_response`), the same at
all times.  What is known of v and of -v at s from now, if the command stays as it is, is

    v(s) <= u + over(s),   -v(s) <= -u + under(s)                                        s >= 0
    over(s) = sum Delta_j^+ (high(age_j + s) - 1) + Delta_j^- (1 - low(age_j + s))

with the parts Delta^+ - Delta^- of each change, ``under`` the same with the parts exchanged, and
behind the tables left exp(-rate t) for both brackets.  A change D to the command u adds D^+ high(s)
- D^- low(s) to the first and D^- high(s) - D^+ low(s) to the second.  It is admitted where both
stay within c = (V - delta)/K for all s, and also if the command 0 follows a period later: so 0 is
always admitted, and the admitted commands are an interval around it.  A delay that is constant
moves all of this in time, for every command alike.  Motors that give only so much force:
`force_band`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache, reduce

import casadi as ca
import numpy as np

from wmr_ctrl.errors import ScenarioError
from wmr_ctrl.filter.channels import (
    AXES,
    DELTA,
    FLAGS,
    SENT,
    TINY,
    UNSOUND,
    channels_of,
    limited,
    scaled,
    sound,
    usable_command,
)
from wmr_ctrl.filter.governor import largest_command
from wmr_ctrl.filter.peak_gain import PiLoop, peak_gains, pi_loop
from wmr_ctrl.filter.step_response import Band, band, pi_cells, second_order_cells
from wmr_ctrl.model.system import Output, Parameters, Port, System, port
from wmr_ctrl.scenario import Scenario
from wmr_ctrl.signals import ASKED, LARGEST, Signal

PIECES = 2
"""Pieces of the tables in a period."""
MOST_COMMANDS = 128
LARGEST_LEFT = 0.2
"""Largest deviation behind the tables: a family that leaves more is too slow for its period."""
FLATTEST = 2.0**-30
"""Smallest slope of a condition; by this share of c the bound may be passed, a sixteenth of what is
kept back against rounding."""


@dataclass(frozen=True)
class ResponseTable:
    """Bounds of the step response on each piece, the last one for ever, and how the tail fades.

    ``rest``: where the response ends.
    """

    low: ca.SX
    high: ca.SX
    left: ca.SX
    fading: ca.SX
    rest: int = 1


@dataclass(frozen=True)
class Forecast:
    """Bounds of v - u and of -v + u on each piece, if the command stays u; the tail's; u itself."""

    over: ca.SX
    under: ca.SX
    tail: ca.SX
    u: ca.SX

    def changed(self, to: ca.SX, table: ResponseTable) -> Forecast:
        """The same with another command from now on."""
        up, down = ca.fmax(to - self.u, 0), ca.fmax(self.u - to, 0)
        high, low = table.high[:-1] - table.rest, table.rest - table.low[:-1]
        return Forecast(
            self.over + up * high + down * low,
            self.under + up * low + down * high,
            self.tail + (up + down) * table.left,
            to,
        )

    def later(self, table: ResponseTable) -> Forecast:
        """The same as seen a period later."""
        new = ca.repmat(self.tail, PIECES, 1)
        over, under = (ca.vertcat(item[PIECES:], new) for item in (self.over, self.under))
        return Forecast(over, under, self.tail * table.fading, self.u)

    def mirrored(self, way: ca.SX) -> Forecast:
        """The forecast of way v, way being 1 or -1."""
        ahead = way > 0
        over = ca.if_else(ahead, self.over, self.under)
        under = ca.if_else(ahead, self.under, self.over)
        return Forecast(over, under, self.tail, way * self.u)

    def largest(self, c: ca.SX, table: ResponseTable, inverse: Sequence[ca.SX]) -> ca.SX:
        """Largest u >= 0 with v <= c and -v <= c from now on, also if 0 follows a period later.

        Each condition is a line in u on each side of the old command, g + slope u <= c, so that the
        set is what all lines leave; ``inverse`` as `inverse_slopes` gives them.  Where 0 follows,
        they aim at c (1 + FLATTEST).
        """
        held, *stopped = self.lines(c, table, inverse)
        later = reduce(ca.fmin, (held[PIECES:], *stopped))  # piece by piece: a loop in C
        first, last = ca.vertsplit(held[:PIECES]), later[-1]
        return ca.fmax(reduce(ca.fmin, (least_of(later[:-1]), last, *first)), 0)

    def lines(self, c: ca.SX, table: ResponseTable, inverse: Sequence[ca.SX]) -> list[ca.SX]:
        """Largest u of each condition: for v held, then for v and -v where 0 follows, twice."""
        over, under = (ca.vertcat(item, self.tail) for item in (self.over, self.under))
        later, spare, pairs = slice(PIECES, None), FLATTEST * c, iter(inverse)
        room = c - (self.u + over)
        most = [self.u + ca.fmin(room * next(pairs), room * next(pairs))]
        ahead, back = room[later] + spare, c - (under - self.u)[later] + spare
        for response in (table.high[later], table.low[later]):
            old = self.u * response
            most += [(ahead + old) * next(pairs), (back - old) * next(pairs)]
        return most


def inverse_slopes(low: ca.SX, high: ca.SX) -> list[ca.SX]:
    """1 over the slopes of all conditions: for v held by high and low, then where 0 follows.

    Slopes are at least FLATTEST: a line that is flat leaves every u that the others do.
    """
    after_high, after_low = _younger(high, ca.fmax), _younger(low, ca.fmin)
    slopes = [high, low]
    for response in (high[PIECES:], low[PIECES:]):
        slopes += [response - after_low, after_high - response]
    return [1 / ca.fmax(slope, FLATTEST) for slope in slopes]


def _younger(values: ca.SX, worse: Callable[[ca.SX, ca.SX], ca.SX]) -> ca.SX:
    """Bounds a period before each piece from the second period on; the last holds for ever."""
    last = [values[k] for k in range(-PIECES - 1, 0)]
    return ca.vertcat(values[: -PIECES - 1], reduce(worse, last))


def least_of(values: ca.SX) -> ca.SX:
    """The least element, by halves, which are loops in C."""
    while values.numel() > 1:
        half = (values.numel() + 1) // 2
        values = ca.fmin(values[:half], values[values.numel() - half :])
    return values


CONDITIONS = {
    "held_high": "for v held, by the largest response",
    "held_low": "for v held, by the least response",
    "stop_high": "for v where 0 follows, by the largest response",
    "stop_high_back": "for -v where 0 follows, by the largest response",
    "stop_low": "for v where 0 follows, by the least response",
    "stop_low_back": "for -v where 0 follows, by the least response",
}


class BandGovernor:
    """The graph of the band's step; its state is the forecast of each axis.

    ``conditions``: names of those that it holds its commands to.
    """

    conditions: tuple[str, ...] = tuple(CONDITIONS)

    def __init__(self, scenario: Scenario, further: tuple[Port, ...] = ()) -> None:
        """Take the ports, and enclose the family's step responses."""
        self.scenario, self.asked = scenario, port(ASKED)
        pushes = [item.push for item in peak_gains(scenario)]
        tables = [enclosed(scenario, axis) for axis in AXES]
        self.state = [_forecast(axis, len(tables[axis].low)) for axis in AXES]
        self.last = port(LAST)
        known = [_table(axis, tables[axis], scenario.clock.control) for axis in AXES]
        delta, slopes = port(DELTA, pushes), [self._slopes(axis, *known[axis][:2]) for axis in AXES]
        ports = (
            delta,
            *(item for own in known for item in own),
            *(s for own in slopes for s in own),
            *further,
        )
        self.p = Parameters(scenario, ports)
        gain = self.p.take("filter.gain")
        self.tables = [
            ResponseTable(low.sym, high.sym, left.sym, fading.sym)
            for low, high, left, fading in known
        ]
        self.inverse = [[item.sym for item in own] for own in slopes]
        numbers = ca.vertcat(gain[0], gain[0]), ca.vertcat(gain[1], gain[1]), delta.sym
        self.channels = channels_of(scenario, self.p, numbers, ca.SX(0))
        self.sound = sound(self.channels)
        self.command, self.refused = usable_command(self.asked.sym)

    def _slopes(self, axis: int, low: Port, high: Port) -> list[Port]:
        """Divisors of the conditions, worked out once: divisions take most of a step's time."""
        inverse = ca.Function("inverse", [low.sym, high.sym], inverse_slopes(low.sym, high.sym))
        values = [item.full().ravel() for item in inverse(low.value, high.value)]
        return [
            port(
                Signal(f"filter.{name}_{NAMES[axis]}", "1", f"1 over the slope {what}", len(own)),
                own,
            )
            for (name, what), own in zip(CONDITIONS.items(), values, strict=True)
            if name in self.conditions
        ]

    @property
    def forecasts(self) -> list[Forecast]:
        """Forecast of each channel at the sample."""
        return [
            Forecast(over.sym, under.sym, tail.sym, self.last.sym[number % len(AXES)])
            for number, (over, under, tail) in enumerate(self.state)
        ]

    @cached_property
    def limits(self) -> list[ca.SX]:
        """Largest size of a command that is safe in the direction that is asked for."""
        return [
            self.forecasts[i]
            .mirrored(ca.if_else(self.command[i] >= 0, 1, -1))
            .largest(
                largest_command(self.channels[i].bounds.V, self.channels[i].bounds),
                self.tables[i],
                self.inverse[i],
            )
            for i in AXES
        ]

    @cached_property
    def sent(self) -> ca.SX:
        """The safe command (2,); 0 where the parameters are unsound.

        There 0 is asked for, whose share is 1 within any limits: no branch holds up the loops of C.
        """
        asked = [ca.if_else(self.sound, r, 0) for r in self.command]
        room = [ca.fmin(ca.fmax(limit, TINY), LARGEST) for limit in self.limits]
        back, scale = [-most for most in room], self.scenario.filter.scale
        safe = scaled(asked, self.channels, back, room, scale)
        return ca.vertcat(*(ca.fmin(ca.fmax(safe[i], -most), most)
                            for i, most in enumerate(self.limits)))  # fmt: skip

    @property
    def system(self) -> System:
        """The sampled System."""
        pairs = zip(self.forecasts, self.tables, strict=True)
        after = [
            was.changed(self.sent[number % len(AXES)], table).later(table)
            for number, (was, table) in enumerate(pairs)
        ]
        flags = ca.if_else(self.sound, limited(self.sent, self.command) + self.refused, UNSOUND)
        parts = [part for f in after for part in (f.over, f.under, f.tail)]
        return System(
            "filter", "command filter (band)", inputs=(self.asked,),
            state=(*(item for ports in self.state for item in ports), self.last),
            params=self.p.ports, update=ca.vertcat(*parts, self.sent),
            outputs=(Output(SENT, self.sent), Output(FLAGS, flags)),
            period=self.scenario.clock.control,
        )  # fmt: skip


LAST = Signal("v_last", "m/s, rad/s", "command that was sent last", 2)
NAMES = ("v", "omega")


def _forecast(axis: int, size: int) -> tuple[Port, Port, Port]:
    name, unit = NAMES[axis], ("m/s", "rad/s")[axis]
    return (
        port(Signal(f"over_{name}", unit, f"bound of {name} over its command, ahead", size)),
        port(Signal(f"under_{name}", unit, f"bound of {name} under its command, ahead", size)),
        port(Signal(f"tail_{name}", unit, f"bound of {name} from its command, far ahead")),
    )


def _table(axis: int, known: Band, T: float) -> tuple[Port, Port, Port, Port]:
    name, size = NAMES[axis], len(known.low) + 1
    low, high = np.append(known.low, 1 - known.left), np.append(known.high, 1 + known.left)
    fading = float(np.exp(-known.rate * T) * (1 + 2.0**-40))
    return (
        port(Signal(f"filter.low_{name}", "1", f"least step response of {name}", size), low),
        port(Signal(f"filter.high_{name}", "1", f"largest step response of {name}", size), high),
        port(Signal(f"filter.left_{name}", "1", f"{name} from its command, behind"), known.left),
        port(Signal(f"filter.fading_{name}", "1", "what stays of that in a period"), fading),
    )


def enclosed(scenario: Scenario, axis: int) -> Band:
    """Tables of an axis' family.  ScenarioError where it is too slow for the control period."""
    settings, T = scenario.filter, scenario.clock.control
    if settings.loop == "pi":
        known = _pi_band(pi_loop(scenario, axis), T)
    else:
        known = _second_order_band(settings.interval("frequency"), settings.interval("damping"), T)
    if not known.left <= LARGEST_LEFT:
        raise ScenarioError(
            f"filter: after {MOST_COMMANDS} periods of clock.control = {T:g} s the step response "
            f"of {NAMES[axis]} may still be {known.left:.2g} from its final value, and the band "
            "looks no further. Narrow the intervals, choose a longer period, or set filter.kind = "
            '"clip".'
        )
    return known


@lru_cache(maxsize=8)
def _pi_band(loop: PiLoop, T: float) -> Band:
    return band(pi_cells(loop), T, PIECES, MOST_COMMANDS)


@lru_cache(maxsize=8)
def _second_order_band(
    frequency: tuple[float, float], damping: tuple[float, float], T: float
) -> Band:
    return band(second_order_cells(frequency, damping), T, PIECES, MOST_COMMANDS)
