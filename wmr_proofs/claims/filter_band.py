"""The band of the command filter: bounds from its forecasts, and admitted commands; the whole band
at punctual samples and at any time.

Tables of a few pieces and the tail: the pieces of longer tables are all treated in the same way.
"""

from functools import reduce
from itertools import product

from casadi import SX, fmax, logic_and, sum1, vertcat

from wmr_ctrl.control.filter.band import BandGovernor
from wmr_ctrl.control.filter.forecast import (
    FLATTEST,
    HELD,
    PAST,
    PIECES,
    Fading,
    Forecast,
    ResponseTable,
    inverse_slopes,
    spread_of,
    stays_of,
)
from wmr_ctrl.world.scenario import load_scenario
from wmr_proofs.claim import Claims, Mutation
from wmr_proofs.statement import (
    Group,
    Named,
    Relations,
    Statement,
    between,
    nonnegative,
    stacked,
    symbols,
    when,
    within,
)

from .command_filter import STATED, Keys
from .common import elements_of, ports_of

claim = Claims()
WAYS = {"over": {"way": 1}, "under": {"way": -1}}


class BandAxis(Named):
    """Symbols of one axis: tables, forecast, the new command ``to`` and the base's own response.

    ``table`` and ``forecast`` at the sample are as the filter's graph reads them.
    """

    def __init__(self, size: int = 1) -> None:
        self.size, numbers, parts = size, range(1, size + 1), ("above", "below", "over", "under")
        names = " ".join(f"{part}{i}" for part in parts for i in numbers)
        names += "".join(f" after{i}" for i in range(1, size + 2 - PIECES))
        self.symbols = s = symbols(f"{names} left fading tail past_over past_under u to c v S")
        high, low, over, under = (stacked(s, part, size) for part in parts)
        after = stacked(s, "after", size + 1 - PIECES)
        self.table = ResponseTable(high, low, after, s.left, s.fading)
        self.forecast = Forecast(over, under, s.tail, s.u, s.past_over, s.past_under)

    @property
    def stated(self) -> Relations:
        """0 <= low <= high, and `faded`."""
        low, high = self.table.low, self.table.high
        return [between(0, low[i], high[i]) for i in range(self.size)], self.faded

    @property
    def faded(self) -> Relations:
        """Hypotheses: left and fading in [0, 1]; the tail's bound is not negative; c > 0."""
        return between(0, self.left, 1), between(0, self.fading, 1), self.tail >= 0, self.c > 0


def bound_of(forecast: Forecast, way: int, part: int = 0) -> SX:
    """Bound of v - u (way 1) or of u - v on one part: a piece, or -1 for the tail."""
    pieces = forecast.over if way > 0 else forecast.under
    past = forecast.past_over if way > 0 else forecast.past_under
    return past + (forecast.tail if part < 0 else pieces[part])


@claim("filter.band.forecast", each=WAYS)
def forecast(mutation: Mutation, way: int) -> Statement:
    """v + (to - u) S <= to + over and -v - (to - u) S <= -to + under of the changed forecast.

    After a change of the command the forecast still bounds every member of the family.

    Given: {TABLES}; v <= u + over, -v <= -u + under; low <= S <= high, the base's response.
    """
    a = BandAxis()
    s = a.symbols
    given = [a.stated, way * s.u + bound_of(a.forecast, way) >= way * s.v]
    given += [between(mutation(1, 0.9) * a.table.low[0], s.S, a.table.high[0])]
    most = way * s.to + bound_of(a.forecast.changed(a.to, a.table), way)
    return Statement(s, most >= way * (s.v + (s.to - s.u) * s.S), given=given)


@claim("filter.band.mirrored")
def mirrored(mutation: Mutation) -> Statement:
    """the changed forecast of -v is that of v with over and under exchanged.

    Backwards the band does what it does forwards.

    Given: {TABLES}.
    """
    a = BandAxis()
    s = a.symbols
    there = a.forecast.mirrored(SX(-1)).changed(-mutation(1, 1.1) * s.to, a.table)
    here = a.forecast.changed(s.to, a.table).mirrored(SX(-1))
    goals = [bound_of(x, way, part) >= bound_of(y, way, part)
             for x, y in ((there, here), (here, there))
             for way in (1, -1) for part in (0, -1)]  # fmt: skip
    return Statement(s, goals, a.stated)


class BandStep(BandAxis):
    """A step of the band on tables of a period and one piece, and the conditions on it.

    ``everywhere``: all pieces and the tail; ``inverse``: reciprocal slopes of all conditions, for a
    constant command and if 0 follows; ``steps``: largest rise and fall of a constant command;
    ``stopped``: largest change that each condition allows if 0 follows.
    """

    def __init__(self) -> None:
        super().__init__(PIECES + 1)
        self.everywhere = (*range(self.size), -1)
        self.inverse = inverse_slopes(self.table)
        self.steps = self.forecast.steps(self.most(True), self.inverse[0])
        self.stopped = self.forecast.stopped(self.c, self.table, self.inverse[1:])

    @property
    def stated(self) -> Relations:
        """Hypotheses on forecasts; ``after`` bounds the next one, by height or by slope."""
        own, high = self.table.after, self.table.high
        over = [own[i] - high[PIECES + i] for i in range(own.numel())]
        last = [high[k] for k in range(own.numel() - 1, high.numel())]
        younger = [own[i] >= high[i] for i in range(own.numel() - 1)]
        younger += [own[-1] >= item for item in last]
        return super().stated, younger, [item * (item - FLATTEST) >= 0 for item in over]

    def most(self, held: bool) -> SX:
        """c'' for a constant command, c' if 0 follows."""
        return self.c * (HELD if held else 1 + FLATTEST)

    def within(self, forecast: Forecast, part: int, way: int, *, held: bool = True) -> Relations:
        """The forecast keeps v (or -v) within `most` on one part: a piece, or -1 for the tail."""
        return self.most(held) >= way * forecast.u + bound_of(forecast, way, part)

    def held(self, *parts: int) -> Relations:
        """Bounds of these parts before the step, for a constant command."""
        return tuple(self.within(self.forecast, part, way) for part in parts for way in (1, -1))

    def inside(self, *parts: int) -> Relations:
        """Goals for v, and for -v with 0 sent."""
        stop = self.forecast.changed(SX(0), self.table)
        return self.held(*parts), *(self.within(stop, part, -1, held=False) for part in parts)


@claim("filter.band.least")
def least(mutation: Mutation) -> Statement:
    """the largest command is at most 0, or at most the command that each condition admits if 0
    follows.

    None of the conditions is left out.

    Given: any tables, forecast and command.
    """
    a = BandStep()
    lines = a.stopped
    cuts = {f"line {k}": lines[k] for k in range(lines.numel())}
    most = mutation(1, 1.1) * a.forecast.largest(a.c, a.table, a.inverse[1:])
    goals = (fmax(a.u + line, 0) >= most for line in cuts.values())
    return a.states(*goals, cuts=cuts)


@claim("filter.band.held", each={"rise": {"rises": True}, "fall": {"rises": False}})
def held(mutation: Mutation, rises: bool) -> Statement:
    """to + over, -to + under of the changed forecast <= c'', on every piece and behind.

    If an admitted command is held, the forecast stays within the limit.

    Given: {AFTER}; {WITHIN}, on every piece and behind; u - fall <= to <= u + rise, with the
    admitted fall and rise.
    """
    a = BandStep()
    s, (rise, fall) = a.symbols, a.steps
    to, u = s.to, s.u
    share = mutation(1, 1.2)
    turn = (to >= u, to <= u + share * rise) if rises else (u >= to, to >= u - share * fall)
    after = a.forecast.changed(to, a.table)
    goals = tuple(a.within(after, part, way) for part in a.everywhere for way in (1, -1))
    return Statement(s, goals, (a.stated, a.held(*a.everywhere), turn))


@claim(
    "filter.band.stop",

    each={f"{word}-{part}": {"part": part, **way} for word, way in WAYS.items()
          for part in ("piece", "tail")},
)  # fmt: skip
def stopped(mutation: Mutation, way: int, part: str) -> Statement:
    """over of the forecast <= c'' and under <= c' if 0 follows an admitted command a period later,
    on each piece of the tables and behind them.

    A stop a period later keeps the forecast within the limit, so that 0 is admitted then.

    Given: {AFTER}; {BAND_INSIDE}; to + over <= c'' if held; 0 <= to <= the largest admitted
    command.
    """
    a = BandStep()
    line, to = (-1 if part == "tail" else 0), a.to
    known = a.forecast.changed(to, a.table)
    behind = -1 if part == "tail" else PIECES
    admitted = (a.within(known, behind, 1),) if way > 0 else (a.u + a.stopped[line] >= to,)
    after = a.forecast.changed(mutation(1, 1.5) * to, a.table).later(a.table)
    after = after.changed(SX(0), a.table)
    parts = (*range(1, a.size), -1) if part == "tail" else (0,)
    goals = tuple(a.within(after, k, way, held=way > 0) for k in parts)
    return Statement(a, goals, (a.stated, a.inside(behind), to >= 0, admitted))


@claim("filter.band.zero")
def zero(mutation: Mutation) -> Statement:
    """0 keeps over <= c'' and under <= c' of the forecast, held or sent again a period later.

    A stop is always admitted, in spite of any condition.

    Given: {AFTER}; u >= 0; {BAND_INSIDE}.
    """
    a = BandStep()
    now = a.forecast.changed(SX(0), a.table)
    after = now.later(a.table).changed(mutation(0, 1) * a.c, a.table)
    every = product((now, after), a.everywhere, (1, -1))
    goals = (a.within(f, part, way, held=way > 0) for f, part, way in every)
    return a.states(*goals, given=(a.stated, a.u >= 0, a.inside(*a.everywhere)))


@claim("filter.band.zero-held")
def zero_held(mutation: Mutation) -> Statement:
    """u - fall <= 0 <= u + rise.

    While steps come in time, the band never holds back a stop.

    Given: {AFTER}; 2^-30 <= high on every piece; u >= 0; {BAND_INSIDE}, on every piece and behind.
    """
    a = BandStep()
    s, (rise, fall) = a.symbols, a.steps
    known = tuple(a.table.high[i] >= SX(FLATTEST) for i in range(a.size))
    goals = mutation(1, 0.9) * fall >= s.u, s.u + rise >= 0
    return Statement(s, goals, (a.stated, known, s.u >= 0, a.inside(*a.everywhere)))


whole_claim = Claims()
BANDED = {
    "filter.kind": "band", "filter.loop": "second-order", "filter.damping": (0.5, 1.0),
    "filter.frequency": (4.0, 5.0), "filter.gain": STATED["filter.gain"], "clock.control": 0.1,
}  # fmt: skip
"""Settings for the structure of the band's graph; its numbers are symbols."""


@whole_claim(
    "filter.band.sent",
    each={
        **{scale: {"stated": BANDED | {"filter.scale": scale}}
           for scale in ("curvature", "axes", "turn", "drive")},
        "pi": {"stated": {
            "filter.kind": "band", "filter.loop": "pi", "clock.control": 0.1,
            "filter.mass": (50.0, 65.0), "filter.inertia": (4.0, 6.0), "filter.kp": (135.0, 165.0),
            "filter.ki": (270.0, 330.0)}},
    },
)  # fmt: skip
def sent(mutation: Mutation, stated: Keys) -> Statement:
    """u_before - fall <= u <= u_before + rise, u what the whole band sends on each axis; where 0 is
    between these ends on both, |u| <= the largest command behind which 0 may follow, and u never
    turns against what was asked for: for second-order loops, scaled in any way, and PI ones, by one
    factor.

    Nothing bypasses the filter: no command and no scaling of the other axis. Behind every command
    that is sent in time 0 may follow.

    Given: {COMMANDS}, at any time; 0 <= what a fall and a rise are admitted together, and 0 <= the
    largest command behind which 0 may follow; the first of these goals for parameters that are
    sound, the others for any.
    """
    graph = BandGovernor(load_scenario("paper-simulation", stated))
    cuts, goals, given = {"sound": graph.sound}, Group(), Group()
    around = [item for low, high in graph.ends for item in (low <= 0, high >= 0)]
    for i, (low, high) in enumerate(graph.ends):
        stop, u = graph.stopping[i], mutation(1, 1.1) * graph.sent[i]
        cuts |= {f"low {i}": low, f"high {i}": high, f"stop {i}": stop}
        given += [high >= low, stop >= 0]
        goals += when(graph.sound, between(low, u, high))
        goals += when(reduce(logic_and, around), (within(u, stop), u * graph.command[i] >= 0))
    return Statement(elements_of(*ports_of(graph.system)), goals, given, cuts)


@whole_claim("filter.band.beat")
def beat(mutation: Mutation) -> Statement:
    """-before' <= p', q', 0 <= behind' and p' - q' <= before' + behind', for the next sample.

    Samples whose spread is within twice the jitter have a common beat.

    Given: -before <= p, q <= behind, the times at which two samples came, less whole periods, after
    the last one; before, behind >= 0; the next one comes a period and ``off`` after that.
    """
    s = symbols("before behind off p q")
    after = spread_of(vertcat(s.before, s.behind), s.off)
    p, q = (s[name] - mutation(1, 0.9) * s.off for name in ("p", "q"))
    given: list[Relations] = [nonnegative(s.before, s.behind)]
    goals: list[Relations] = [nonnegative(after[0], after[1]), sum1(after) >= p - q]
    for name, own in (("p", p), ("q", q)):
        given.append(between(-s.before, s[name], s.behind))
        goals.append(between(-after[0], own, after[1]))
    return Statement(s, goals, given)


@whole_claim("filter.band.fading")
def fading(mutation: Mutation) -> Statement:
    """r g and p g, or r g alone if the sample is untimely, are at most their stored bounds.

    The distance of the base from its command is bounded whenever the next command comes.

    Given: 0 <= r <= reach, 0 <= p <= past; what stays of both is g >= 0, with g (1 + x + x^2/2) <=
    1, x the rate times the time since the last sample, both at least 0; 0 <= soonest, and g <=
    soonest if the sample came on its beat.
    """
    s = symbols("reach past held u came rate time soonest r p g")
    came, x = s.came, s.rate * s.time
    after = Fading(s.reach, s.past, s.held).aged(came, s.u, stays_of(s.rate, s.time), s.soonest)
    stays = s.g * (1 + x + 0.5 * x * x) <= 1, s.soonest >= came * s.g
    signs = nonnegative(came * (came - 1), came * (1 - came), s.g, s.rate, s.time, s.r, s.p)
    given = stays, signs, s.soonest >= 0, s.reach >= s.r, s.past >= s.p
    left = came * s.p + (1 - came) * s.r
    goals = after.reach >= mutation(1, 1.1) * s.r * s.g, after.past >= left * s.g
    return Statement(s, goals, given)


@whole_claim("filter.band.past", each=WAYS)
def past(mutation: Mutation, way: int) -> Statement:
    """v - held and held - v are at most the bounds of earlier commands' effects, above and below.

    After an untimely sample the bounds that hold in any case remain.

    Given: c >= 0; v - held <= past; v <= c (1 + 2^-29), as long as the command stays held; under
    it, the same of -v and -held.
    """
    s = symbols("past held c v")
    bound = Fading(SX(0), s.past, s.held).bounds(s.c)[0 if way > 0 else 1]
    v = way * (s.v - s.held)
    known = s.past >= mutation(1, 0.9) * v, PAST * s.c >= way * s.v
    return Statement(s, bound >= v, (known, s.c >= 0))
