"""Governor of linear loops of any damping that uses the commands sent and no odometry.

The base: v = sum of Delta_j S(age_j) + the response to pushes, which is at most delta in size.  The
Delta_j are the changes of its command so far, and S is a step response between low and high
(`step_response`), the same at all times.  If the command stays as it is, v and -v at s from now are
bounded by

    v(s) <= u + over(s),   -v(s) <= -u + under(s)                                        s >= 0
    over(s) = sum Delta_j^+ (high(age_j + s) - 1) + Delta_j^- (1 - low(age_j + s))

with the parts Delta^+ - Delta^- of each change; ``under`` has the parts exchanged.  Behind the
tables both brackets are left exp(-rate t).  A change D of the command u adds D^+ high(s) - D^-
low(s) to the first bound and D^- high(s) - D^+ low(s) to the second.  The change is admitted if
both stay within c = (V - delta)/K for all s, also if the command 0 follows a period later.  So 0 is
always admitted, and the admitted commands are an interval around it.  A constant delay only shifts
all of this in time.  The governor must start while the base is at rest.  The elapsed time that a
step is given must be the true one; 0 or less means that it is unknown.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from itertools import chain

import casadi as ca
import numpy as np

from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.core.signals import ASKED, LARGEST, Signal
from wmr_ctrl.world.model.system import Output, Parameters, Port, System, port
from wmr_ctrl.world.scenario import Scenario

from .channels import (
    AXES,
    DELTA,
    ELAPSED,
    FLAGS,
    LATE,
    SENT,
    TINY,
    UNSOUND,
    channels_of,
    gains_of,
    limited,
    passed,
    scaled,
    sound,
    usable_command,
    within,
)
from .forecast import (
    HELD,
    PIECES,
    SPARE,
    Fading,
    Forecast,
    ResponseTable,
    bounds_after,
    inverse_slopes,
    spread_of,
    stays_of,
)
from .governor import NEAR, largest_command
from .peak_gain import PiLoop, peak_gains, pi_loop
from .step_response import Band, band, pi_cells, second_order_cells

MOST_COMMANDS = 128
LARGEST_LEFT = 0.2
"""Largest deviation behind the tables: a family that leaves more is too slow for its period."""


CONDITIONS = {
    "held": "1 over the slope for a command held",
    "stop_rise": "1 over the slope where 0 follows a rise",
    "stop_fall": "1 over the slope where 0 follows a fall",
}


@dataclass(frozen=True)
class AxisPorts:
    """Ports of one axis: state of its `Forecast` and of its `Fading`, and parameters.

    ``numbers``: those of its `ResponseTable`, then its initial bound and decay.  ``slopes``: the
    divisors of its conditions.
    """

    forecast: tuple[Port, ...]
    far: tuple[Port, ...]
    numbers: tuple[Port, ...]
    slopes: tuple[Port, ...]

    @property
    def table(self) -> ResponseTable:
        """The step response's table."""
        return ResponseTable(*_symbols(self.numbers[:-3]))

    @property
    def fading(self) -> list[ca.SX]:
        """Initial bound, rate, and what remains after the shortest period."""
        return _symbols(self.numbers[-3:])

    @property
    def inverse(self) -> list[ca.SX]:
        """The divisors, in the order of CONDITIONS."""
        return _symbols(self.slopes)


def _axis_ports(scenario: Scenario, axis: int) -> AxisPorts:
    """Ports of an axis; encloses the step responses of its family of loops."""
    known, name, unit = enclosed(scenario, axis), NAMES[axis], UNITS[axis]
    numbers = _table(axis, known, scenario.clock.control, scenario.filter.jitter)
    forecast, slopes = _forecast(axis, len(known.low)), _slopes(axis, known)
    return AxisPorts(forecast, _faded_ports(name, unit), numbers, slopes)


def _symbols(ports: Sequence[Port]) -> list[ca.SX]:
    return [item.sym for item in ports]


class BandGovernor:
    """Graph of the band's step; its state is the forecast of each axis."""

    def __init__(self, scenario: Scenario) -> None:
        """Create the ports."""
        self.scenario, self.asked, self.elapsed = scenario, port(ASKED), port(ELAPSED)
        self.last, self.spread = port(LAST), port(SPREAD)
        self.axes = [_axis_ports(scenario, axis) for axis in AXES]
        delta = port(DELTA, [item.push for item in peak_gains(scenario)])
        numbers = (*(own.numbers for own in self.axes), *(own.slopes for own in self.axes))
        self.p = Parameters(scenario, (delta, *chain(*numbers)))
        gains, self.T = gains_of(self.p), self.p.take("clock.control")
        self.channels = channels_of(scenario, self.p, (*gains, delta.sym))
        self.sound = sound(self.channels)
        self.command, self.refused = usable_command(self.asked.sym)

    @cached_property
    def off(self) -> ca.SX:
        """Lateness of the sample: time since the previous one, less a period."""
        return passed(self.elapsed.sym, self.T) - self.T

    @cached_property
    def apart(self) -> ca.SX:
        """Largest earliness and lateness (2,) among the samples on its beat, including itself."""
        return spread_of(self.spread.sym, self.off)

    @cached_property
    def came(self) -> ca.SX:
        """1 if one beat fits this sample and all since the last untimely one, within the jitter."""
        most = 2 * self.scenario.filter.jitter + NEAR * self.T
        return ca.logic_and(within(self.off, most), ca.sum1(self.apart) <= most)

    @cached_property
    def faded(self) -> list[Fading]:
        """Remainder of each axis' past at the sample."""
        time, rows = passed(self.elapsed.sym, self.T), []
        for i, own in enumerate(self.axes):
            _, rate, soonest = own.fading
            known = Fading(*_symbols(own.far))
            rows.append(known.aged(self.came, self.last.sym[i], stays_of(rate, time), soonest))
        return rows

    @cached_property
    def forecasts(self) -> list[Forecast]:
        """Forecast of each axis at the sample."""
        share = ca.fmax(ca.if_else(self.came, 1, 0), 0)  # a factor, no choice: loops in C
        rows = []
        for i, own in enumerate(self.axes):
            over, under, tail = _symbols(own.forecast)
            past = self.faded[i].bounds(self.most[i])
            known = Forecast(over, under, tail, self.last.sym[i], *past)
            rows.append(known.later(own.table).kept(share))
        return rows

    @cached_property
    def most(self) -> list[ca.SX]:
        """Largest constant command of each axis."""
        bounds = (self.channels[axis].bounds for axis in AXES)
        return [largest_command(b.V, b) for b in bounds]

    @cached_property
    def ends(self) -> list[tuple[ca.SX, ca.SX]]:
        """Least and largest command of each axis that may be kept from now on."""
        both = []
        for i in AXES:
            known = self.forecasts[i]
            rise, fall = known.steps(self.most[i] * HELD, self.axes[i].inverse[0])
            both.append((known.u - fall, known.u + rise))
        return both

    @cached_property
    def stopping(self) -> list[ca.SX]:
        """Largest command, in the requested direction, that may be followed by 0."""
        rows = []
        for i, (least, most) in enumerate(self.ends):
            ahead = self.command[i] >= 0
            known = self.forecasts[i].mirrored(ca.if_else(ahead, 1, -1))
            own = self.axes[i]
            stopped = known.largest(self.most[i], own.table, own.inverse[1:])
            rows.append(ca.fmax(ca.fmin(stopped, ca.if_else(ahead, most, -least)), 0))
        return rows

    @cached_property
    def limits(self) -> list[ca.SX]:
        """Largest command that is sent in the requested direction.

        If 0 is not admitted, after an untimely sample, the last command may be repeated.
        """
        rows = []
        for i, (least, most) in enumerate(self.ends):
            turned = ca.if_else(self.command[i] >= 0, least, -most) > 0
            stays = ca.if_else(turned, ca.fabs(self.last.sym[i]), 0)
            rows.append(ca.fmax(self.stopping[i], stays))
        return rows

    @cached_property
    def sent(self) -> ca.SX:
        """The safe command (2,), within its limits and such that it may be kept from now on."""
        asked = [ca.if_else(self.sound, r, 0) for r in self.command]
        room = [ca.fmin(ca.fmax(limit, TINY), LARGEST) for limit in self.limits]
        back, scale = [-most for most in room], self.scenario.filter.scale
        safe = scaled(asked, self.channels, back, room, scale)
        limited = (ca.fmin(ca.fmax(safe[i], -most), most) for i, most in enumerate(self.limits))
        return self.held(list(limited))

    def held(self, safe: Sequence[ca.SX]) -> ca.SX:
        """The nearest command (2,) that may be kept; 0 if the parameters are unsound."""
        within = (ca.fmin(ca.fmax(safe[i], ends[0]), ends[1]) for i, ends in enumerate(self.ends))
        return ca.if_else(self.sound, ca.vertcat(*within), 0)

    @property
    def system(self) -> System:
        """The sampled System."""
        pairs = zip(self.forecasts, self.axes, strict=True)
        after = [was.changed(self.sent[i], own.table) for i, (was, own) in enumerate(pairs)]
        flags = limited(self.sent, self.command) + self.refused + ca.if_else(self.came, 0, LATE)
        flags = ca.if_else(self.sound, flags, UNSOUND)
        apart = ca.if_else(self.came, self.apart, 0)
        parts = [part for f in after for part in (f.over, f.under, f.tail)]
        for i, known in enumerate(self.faded):
            change = self.sent[i] - self.last.sym[i]
            now = known.changed(change, self.axes[i].fading[0])
            parts += [now.reach, now.past, now.held]
        return System(
            "filter", "command filter (band)", inputs=(self.asked, self.elapsed),
            state=(*chain(*(own.forecast for own in self.axes), *(own.far for own in self.axes)),
                   self.last, self.spread),
            params=self.p.ports, update=ca.vertcat(*parts, self.sent, apart),
            outputs=(Output(SENT, self.sent), Output(FLAGS, flags)),
            period=self.scenario.clock.control,
        )  # fmt: skip


LAST = Signal("v_last", "m/s, rad/s", "command that was sent last", 2)
SPREAD = Signal("spread", "s", "largest earliness and lateness on the beat", 2)
NAMES = ("v", "omega")


UNITS = ("m/s", "rad/s")


def _forecast(axis: int, size: int) -> tuple[Port, ...]:
    name, unit = NAMES[axis], UNITS[axis]
    return (
        port(Signal(f"over_{name}", unit, f"bound of {name} over its command, ahead", size)),
        port(Signal(f"under_{name}", unit, f"bound of {name} under its command, ahead", size)),
        port(Signal(f"tail_{name}", unit, f"bound of {name} from its command, far ahead")),
    )


def _slopes(axis: int, known: Band) -> tuple[Port, ...]:
    """Divisors of the conditions, computed once, since divisions take most of a step's time."""
    slopes = zip(CONDITIONS.items(), rounded_slopes(response_table(known)), strict=True)
    return tuple(
        port(Signal(f"filter.{name}_{NAMES[axis]}", "1", what, len(own)), own)
        for (name, what), own in slopes
    )


def _faded_ports(name: str, unit: str) -> tuple[Port, ...]:
    """Ports of a `Fading`, in the order of its fields."""
    return (
        port(Signal(f"reach_{name}", unit, f"bound of |{name} - its command|, at the sample")),
        port(Signal(f"past_{name}", unit, "the same, from before the last untimely sample")),
        port(Signal(f"held_{name}", "m/s, rad/s", "command at that sample")),
    )


def response_table(known: Band) -> ResponseTable:
    """A Band as a ResponseTable without fading."""
    above, below = (np.nextafter(item, np.inf) for item in (known.high - 1, 1 - known.low))
    none, left = ca.SX(0, 1), ca.SX(known.left)
    table = ResponseTable(ca.SX(ca.DM(above)), ca.SX(ca.DM(below)), none, left, ca.SX(0))
    return replace(table, after=bounds_after(table.high))


def rounded_slopes(table: ResponseTable) -> list[np.ndarray]:
    """`inverse_slopes`, rounded so that none admits a larger command."""
    held, rise, fall = (np.array(_numbers_of(item)) for item in inverse_slopes(table))
    wider = 2.0**-50
    return [1 / (1 / held + wider), 1 / (1 / rise + wider), 1 / (1 / fall - wider)]


def _numbers_of(values: ca.SX) -> list[float]:
    """Values of a column without symbols."""
    return [float(item) for item in ca.DM(values).full().ravel()]


def _table(axis: int, known: Band, T: float, jitter: float) -> tuple[Port, ...]:
    """Ports of a `ResponseTable`, in the order of its fields, then its initial bound and decay."""
    name, table = NAMES[axis], response_table(known)
    times = np.array([T, T - 2 * jitter - NEAR * T])
    fading, soonest = np.exp(-known.rate * times) * SPARE
    own = (
        ("above", "1", "largest step response of {}, less 1", _numbers_of(table.above)),
        ("below", "1", "1 less the least step response of {}", _numbers_of(table.below)),
        ("after", "1", "largest step response of {}, a period later", _numbers_of(table.after)),
        ("left", "1", "{} from its command, behind", [known.left]),
        ("fading", "1", "what stays of that in a period", [fading]),
        ("reach", "1", "{} from its command, at most", [known.reach * SPARE]),
        ("rate", "1/s", "rate at which that fades", [known.rate]),
        ("soonest", "1", "what stays of it in the shortest period", [soonest]),
    )
    return tuple(
        port(Signal(f"filter.{key}_{name}", unit, meaning.format(name), len(values)), values)
        for key, unit, meaning, values in own
    )


def check_beat(scenario: Scenario) -> None:
    """Raise ScenarioError if samples may be too far from their beat."""
    settings, T = scenario.filter, scenario.clock.control
    if settings.jitter > T / 4:
        raise ScenarioError(
            f'filter.jitter = {settings.jitter:g} s: with filter.kind = "band" samples may be off '
            f"their beat by at most a quarter of clock.control = {T:g} s, that is {T / 4:g} s. "
            "State that much, and give each step the time since the last one (elapsed), which "
            "shows how late or early each is."
        )


def enclosed(scenario: Scenario, axis: int) -> Band:
    """Tables of an axis' family of loops.  Raises ScenarioError if it is too slow for the control
    period.
    """
    settings, T = scenario.filter, scenario.clock.control
    if settings.loop[axis] == "pi":
        known = _pi_band(pi_loop(scenario, axis), T, settings.jitter)
    else:
        family = settings.intervals("frequency")[axis], settings.intervals("damping")[axis]
        known = _second_order_band(*family, T, settings.jitter)
    if not known.left <= LARGEST_LEFT:
        far = f"{known.left:.2g} times that" if known.left < np.inf else "any amount"
        raise ScenarioError(
            f"filter: after {MOST_COMMANDS} periods of clock.control = {T:g} s the step response "
            f"of {NAMES[axis]} may still be off its final value by {far}, and the band looks no "
            'further. Narrow the intervals, choose a longer period, or set filter.kind = "clip".'
        )
    return known


@lru_cache(maxsize=32)
def _pi_band(loop: PiLoop, T: float, jitter: float) -> Band:
    return band(pi_cells(loop), T, PIECES, MOST_COMMANDS, jitter)


@lru_cache(maxsize=32)
def _second_order_band(
    frequency: tuple[float, float], damping: tuple[float, float], T: float, jitter: float
) -> Band:
    return band(second_order_cells(frequency, damping), T, PIECES, MOST_COMMANDS, jitter)
