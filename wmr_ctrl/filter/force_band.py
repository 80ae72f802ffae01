"""The band of a base whose motors give only so much force: speed and force, held within both.

A PI loop is linear as long as its motors give what it asks for, F = M v' + c v - d.  Commands lead
to the part sum of Delta_j M S'(age_j) of M v', which fades to 0 behind each change and lies between
tables of M S' over the whole family (`step_response.force_band`), and to a part v_u of v, which the
`Forecast` of the speed bounds.  Pushes make the loop give at most N dbar, N its peak gain.  So with

    sum of Delta_j M S'(age_j) + max(0, c_max v_u) <= f,    f = filter.force - N dbar

and the same of its negative the loop never asks for more than filter.force.  What is known of speed
and of force ahead, if the command stays as it is, is a `Forecast` each.  A change is admitted where
both stay within c and f for ever if the new command is held: so the old command always is, and the
admitted ones are an interval around it.  Zero at once may take more force than there is: a stop is
the fastest admitted ramp.
"""

from collections.abc import Sequence
from functools import cached_property, lru_cache, reduce
from itertools import chain

import casadi as ca
import numpy as np

from wmr_ctrl.fields.units import rounded
from wmr_ctrl.filter.band import (
    MOST_COMMANDS,
    NAMES,
    BandGovernor,
    faded_ports,
    numbers_of,
    response_table,
)
from wmr_ctrl.filter.channels import AXES, ROUNDING, TINY, scaled
from wmr_ctrl.filter.forecast import (
    FLATTEST,
    PIECES,
    SPARE,
    Forecast,
    ResponseTable,
    at_most,
)
from wmr_ctrl.filter.peak_gain import PiLoop, peak_gains, pi_loop, refuse_all
from wmr_ctrl.filter.step_response import Band, force_band, pi_cells
from wmr_ctrl.model.system import Port, port
from wmr_ctrl.scenario import Scenario
from wmr_ctrl.signals import LARGEST, Signal

UNITS = ("N", "N.m")
ROOM = Signal("filter.force_room", "N, N.m", "force that pushes leave", 2)
DRAG = Signal("filter.drag", "N.s/m, N.m.s", "largest friction over speed", 2)


def force_room(scenario: Scenario) -> tuple[float, float]:
    """f of both axes [N, N m], less what roundings may do; ScenarioError where nothing is left."""
    settings, l = scenario.filter, scenario.robot.l
    assert settings.force is not None  # the band asks for it
    arms, peaks, left, faults = (1.0, l**2), peak_gains(scenario), [], []
    for i in AXES:
        friction = settings.friction[1] * arms[i] * scenario.limits.v_u1[i]
        pushed = peaks[i].gain * settings.push[i]
        needed = (friction + pushed) * (1 + 2.0**-40)
        given = settings.force[i] * (1 - ROUNDING)
        left.append(given - pushed * (1 + 2.0**-40))
        if given <= needed:
            faults.append(
                f"filter.force[{i + 1}] = {settings.force[i]:g} {UNITS[i]} leaves nothing to "
                f"change the speed with: friction at the limit takes up to {friction:.4g}, and "
                f"against pushes the loop may give {pushed:.4g}. State more than "
                f"{rounded(needed, 4)}, a smaller push or friction, or a lower limit."
            )
    refuse_all(faults)
    return left[0], left[1]


def largest_drag(scenario: Scenario) -> tuple[float, float]:
    """c_max of both axes [N s/m, N m s], rounded up."""
    c = scenario.filter.friction[1] * (1 + 2.0**-50)
    return c, c * scenario.robot.l**2 * (1 + 2.0**-50)


def force_table(scenario: Scenario, axis: int) -> tuple[Port, ...]:
    """Tables of M S' of an axis, in the order of a ResponseTable; and how far it reaches."""
    known = _tables(pi_loop(scenario, axis), scenario.clock.control, scenario.filter.jitter)
    share = (1.0, scenario.robot.l**2)[axis] * (1 + 2.0**-50)  # the loop's numbers are at the rim
    above, below = (_wider(item, share) for item in (known.high, -known.low))
    left, reach = known.left * share, known.reach * share * SPARE
    name, unit = NAMES[axis], ("N.s/m", "N.m.s")[axis]
    own = (
        ("above_force", "largest force behind a step of {}", above),
        ("below_force", "largest force against a step of {}", below),
        ("left_force", "force behind the tables of {}", [left]),
        ("reach_force", "force behind a step of {} at most, which fades", [reach]),
    )
    return tuple(
        port(Signal(f"filter.{key}_{name}", unit, meaning.format(name), len(values)), values)
        for key, meaning, values in own
    )


def _wider(high: np.ndarray, share: float) -> np.ndarray:
    """Upper bounds times ``share``, rounded up."""
    return np.asarray(high * share + 2.0**-49 * np.abs(high * share))


@lru_cache(maxsize=32)
def _tables(loop: PiLoop, T: float, jitter: float) -> Band:
    return force_band(pi_cells(loop), T, PIECES, MOST_COMMANDS, jitter)


def force_forecast(axis: int, size: int) -> tuple[Port, ...]:
    """Forecast of an axis' force: bounds of it and of its negative, piece by piece and beyond."""
    name, unit = NAMES[axis], UNITS[axis]
    return (
        port(Signal(f"over_force_{name}", unit, f"bound of the force on {name}, ahead", size)),
        port(Signal(f"under_force_{name}", unit, f"bound of its negative on {name}, ahead", size)),
        port(Signal(f"tail_force_{name}", unit, f"bound of the force on {name}, far ahead")),
    )


def inverse_force_slopes(low: ca.SX, high: ca.SX) -> tuple[ca.SX, ca.SX]:
    """1 over high and over -low where they are positive, else -1: there a change takes no force."""
    least = FLATTEST * high[0]
    return _inverse(high, least), _inverse(-low, least)


def _inverse(slope: ca.SX, least: ca.SX) -> ca.SX:
    return ca.if_else(slope > 0, 1 / ca.fmax(slope, least), -1)


def with_drag(force: Forecast, speed: Forecast, drag: ca.SX) -> Forecast:
    """Forecast of a force and of ``drag`` times the speed together, over drag times u."""
    names = ("over", "under", "tail", "past_over", "past_under")
    sums = {name: getattr(force, name) + drag * getattr(speed, name) for name in names}
    return Forecast(u=drag * speed.u, **sums)


def dragging(force: ResponseTable, speed: ResponseTable, drag: ca.SX) -> tuple[ca.SX, ca.SX]:
    """Least and largest force behind a step with ``drag`` times the speed."""
    return force.low + drag * speed.low, force.high + drag * speed.high


def force_response(above: ca.SX, below: ca.SX, left: ca.SX, fading: ca.SX) -> ResponseTable:
    """Tables of the force behind a step, which ends at 0."""
    return ResponseTable(above, below, ca.SX(0, 1), left, fading, rest=0)


def force_steps(
    known: Forecast, f: ca.SX, inverse: tuple[ca.SX, ca.SX], held: ca.SX | None = None
) -> tuple[ca.SX, ca.SX]:
    """The same for the force and its negative, within f; ``held``: where it ends, by default 0."""
    above, below = known.rooms(f, ca.SX(0) if held is None else held)
    up, down = inverse
    rise = ca.fmin(line(above, up), line(below, down))
    fall = ca.fmin(line(above, down), line(below, up))
    return at_most(rise), at_most(fall)


def line(room: ca.SX, inverse: ca.SX) -> ca.SX:
    """Change that leaves no room, at least LARGEST where it takes none: no choice, a loop in C."""
    return ca.fmax(room * inverse, -LARGEST * inverse)


def reached(u: ca.SX, steps: Sequence[tuple[ca.SX, ca.SX]]) -> tuple[ca.SX, ca.SX]:
    """Least and largest command that every rise and fall admits."""
    rise, fall = (reduce(ca.fmin, some) for some in zip(*steps, strict=True))
    return u - fall, u + rise


class ForceBand(BandGovernor):
    """The graph of the step; its state is the forecast of both speeds, then of both forces."""

    conditions = ("held",)

    def __init__(self, scenario: Scenario) -> None:
        """Take the ports, and enclose the family's step responses and what force they take."""
        self.room, self.drag = port(ROOM, force_room(scenario)), port(DRAG, largest_drag(scenario))
        self.force_tables = [force_table(scenario, axis) for axis in AXES]
        further = (item for own in self.force_tables for item in own)
        super().__init__(scenario, (self.room, self.drag, *further))
        for axis, own in enumerate(self.force_tables):
            above, below, left, reach = (item.sym for item in own)
            self.tables.append(force_response(above, below, left, self.tables[axis].fading))
            self.fading.append([reach, *self.fading[axis][1:]])
            self.state.append(force_forecast(axis, above.numel()))
            self.far.append(faded_ports(f"force_{NAMES[axis]}", UNITS[axis]))
        self.most += ca.vertsplit(self.room.sym)
        f, drag = self.room.sym, self.drag.sym
        tests = ((f[i] > 0, f[i] <= LARGEST, drag[i] >= 0, drag[i] <= LARGEST) for i in AXES)
        self.sound = reduce(ca.logic_and, chain.from_iterable(tests), self.sound)

    def _slopes(self, axis: int, known: Band) -> list[Port]:
        """Those of the speed, then of the force alone and of the force with friction."""
        above, below, left, _ = (ca.SX(ca.DM(item.value)) for item in self.force_tables[axis])
        force = force_response(above, below, left, ca.SX(0))
        dragged = dragging(force, response_table(known), ca.SX(self.drag.value[axis]))
        slopes, name = super()._slopes(axis, known), NAMES[axis]
        for what, pair in (("force", (force.low, force.high)), ("drag", dragged)):
            for way, own in zip(("up", "down"), inverse_force_slopes(*pair), strict=True):
                meaning, values = f"1 over the {what} of a change {way}", numbers_of(own)
                signal = Signal(f"filter.{what}_{way}_{name}", "1", meaning, len(values))
                slopes.append(port(signal, values))
        return slopes

    @cached_property
    def ends(self) -> list[tuple[ca.SX, ca.SX]]:
        """Least and largest command of each axis that are admitted."""
        both = []
        for i in AXES:
            speed, force = self.forecasts[i :: len(AXES)]
            held, *inverse = self.inverse[i]
            c, f = self.most[i :: len(AXES)]
            dragged = with_drag(force, speed, self.drag.sym[i])
            steps = (
                speed.steps(c, held),
                force_steps(force, f, (inverse[0], inverse[1])),
                force_steps(dragged, f, (inverse[2], inverse[3]), dragged.u),
            )
            both.append(reached(speed.u, steps))
        return both

    @cached_property
    def sent(self) -> ca.SX:
        """The command (2,): scaled as far as the ends away from 0 say, then within both ends."""
        back = [ca.fmax(ca.fmin(least, -TINY), -LARGEST) for least, _ in self.ends]
        room = [ca.fmin(ca.fmax(most, TINY), LARGEST) for _, most in self.ends]
        asked = [ca.if_else(self.sound, r, 0) for r in self.command]
        safe = scaled(asked, self.channels, back, room, self.scenario.filter.scale)
        return self.held(ca.vertsplit(safe))
