"""The band of the command filter: what its forecasts bound, and what it admits.

Tables of a few pieces and the tail: every piece of longer ones is reckoned alike.
"""

from dataclasses import dataclass
from functools import cached_property

import casadi as ca

from wmr_ctrl.filter.band import (
    FLATTEST,
    PIECES,
    BandGovernor,
    Forecast,
    ResponseTable,
    inverse_slopes,
)
from wmr_ctrl.proofs.claim import Claims, Mutation
from wmr_ctrl.proofs.claims.common import elements_of
from wmr_ctrl.proofs.ledger import HAND
from wmr_ctrl.proofs.methods.spec import Z3
from wmr_ctrl.proofs.statement import Relation, Statement, above, at_least, stacked, symbols, within
from wmr_ctrl.scenario import load_scenario

TABLES = "0 <= low <= high on every piece, left, fading in [0, 1]"
claim = Claims(by=Z3(effort=100))
WAYS = ({"word": "over", "sign": "", "way": 1}, {"word": "under", "sign": "-", "way": -1})


@dataclass(frozen=True)
class BandAxis:
    """Symbols of one axis: tables, forecast, the new command ``to`` and the base's own response."""

    size: int = 1

    @cached_property
    def symbols(self) -> dict[str, ca.SX]:
        """Every number by name."""
        numbers, parts = range(1, self.size + 1), ("low", "high", "over", "under")
        names = " ".join(f"{part}{i}" for part in parts for i in numbers)
        return symbols(f"{names} left fading tail u to c v S")

    def column(self, name: str) -> ca.SX:
        """Numbers of all pieces."""
        return stacked(self.symbols, name, self.size)

    @cached_property
    def table(self) -> ResponseTable:
        """Tables as the filter's graph reads them."""
        s = self.symbols
        low, high = ca.vertcat(self.column("low"), 1 - s["left"]), 1 + s["left"]
        return ResponseTable(low, ca.vertcat(self.column("high"), high), s["left"], s["fading"])

    @cached_property
    def forecast(self) -> Forecast:
        """Forecast at the sample."""
        s = self.symbols
        return Forecast(self.column("over"), self.column("under"), s["tail"], s["u"])

    @property
    def stated(self) -> tuple[Relation, ...]:
        """0 <= low <= high; left and fading in [0, 1]; the tail's bound is not negative; c > 0."""
        s, low, high = self.symbols, self.column("low"), self.column("high")
        order = [part for i in range(self.size)
                 for part in (at_least(low[i]), at_least(high[i], low[i]))]  # fmt: skip
        shares = [part for name in ("left", "fading")
                  for part in (at_least(s[name]), at_least(ca.SX(1), s[name]))]  # fmt: skip
        return (*order, *shares, at_least(s["tail"]), above(s["c"]))


@claim(
    "filter.band.{word}",
    given=f"{TABLES}; {{sign}}v <= {{sign}}u + {{word}}; low <= S <= high, the base's response",
    over=WAYS,
)
def forecast(mutation: Mutation, word: str, way: int) -> Statement:
    """{sign}(v + (to - u) S) <= {sign}to + {word} of the changed forecast.

    After a change of the command the forecast still bounds every member of the family.
    """
    a = BandAxis()
    s, changed = a.symbols, a.forecast.changed(a.symbols["to"], a.table)
    known = {"over": a.forecast.over, "under": a.forecast.under}[word]
    given = [*a.stated, at_least(way * s["u"] + known, way * s["v"])]
    given += [
        at_least(s["S"], mutation(1, 0.9) * a.table.low[0]),
        at_least(a.table.high[0], s["S"]),
    ]
    bound = {"over": changed.over, "under": changed.under}[word]
    goal = at_least(way * s["to"] + bound, way * (s["v"] + (s["to"] - s["u"]) * s["S"]))
    return Statement(s, (goal,), tuple(given))


@claim("filter.band.mirrored", given=f"{TABLES}")
def mirrored(mutation: Mutation) -> Statement:
    """the changed forecast of -v is that of v with over and under exchanged.

    Backwards the band does what it does forwards.
    """
    a = BandAxis()
    s = a.symbols
    there = a.forecast.mirrored(ca.SX(-1)).changed(-mutation(1, 1.1) * s["to"], a.table)
    here = a.forecast.changed(s["to"], a.table).mirrored(ca.SX(-1))
    goals = [at_least(x - y) for one, other in ((there, here), (here, there))
             for x, y in ((one.over, other.over), (one.under, other.under))]  # fmt: skip
    return Statement(s, tuple(goals), a.stated)


PARTS = ({"part": "piece", "told": "a piece of the tables"},
         {"part": "tail", "told": "behind the tables"})  # fmt: skip
EACH = tuple(way | part for way in WAYS for part in PARTS)
INSIDE = (
    "before it u + over, -u + under <= c', and over, under <= c' once 0 is sent, c' = c (1 + 2^-30)"
)


@dataclass(frozen=True)
class BandStep(BandAxis):
    """A step of the band on tables of a period and one piece, and the conditions it is held to."""

    size: int = PIECES + 1

    @cached_property
    def lines(self) -> list[ca.SX]:
        """Largest command of each condition, as the filter's graph reckons it."""
        inverse = inverse_slopes(self.table.low, self.table.high)
        return self.forecast.lines(self.symbols["c"], self.table, inverse)

    @property
    def most(self) -> ca.SX:
        """c (1 + FLATTEST)."""
        return self.symbols["c"] * (1 + FLATTEST)

    def within(self, forecast: Forecast, part: int, way: int) -> Relation:
        """The forecast keeps v (or -v) within `most` on one part: a piece, or -1 for the tail."""
        bounds = forecast.over if way > 0 else forecast.under
        return at_least(self.most, way * forecast.u + (forecast.tail if part < 0 else bounds[part]))

    def inside(self, *parts: int) -> tuple[Relation, ...]:
        """Bounds of these parts before the step: with the command held, and with 0 sent."""
        kept = self.forecast, self.forecast.changed(ca.SX(0), self.table)
        return tuple(self.within(f, part, way) for f in kept for part in parts for way in (1, -1))


@claim("filter.band.least", given="any tables, forecast and command")
def least(mutation: Mutation) -> Statement:
    """the largest command is 0, or at most what each of the conditions admits.

    None of the conditions is left out.
    """
    a = BandStep()
    cuts = {f"line {i} {k}": line[k] for i, line in enumerate(a.lines)
            for k in range(line.numel())}  # fmt: skip
    inverse = inverse_slopes(a.table.low, a.table.high)
    largest = mutation(1, 1.1) * a.forecast.largest(a.symbols["c"], a.table, inverse)
    goals = tuple(at_least(ca.fmax(line, 0), largest) for line in cuts.values())
    return Statement(a.symbols, goals, (), cuts)


@claim(
    "filter.band.held-{word}-{part}",
    given=f"{TABLES}; 0 <= to <= what the condition admits; {INSIDE}",
    over=EACH,
)
def held(mutation: Mutation, word: str, way: int, part: str) -> Statement:
    """{sign}to + {word} of the changed forecast <= c', on {told}.

    A command that is admitted, and then held, keeps the forecast within the limit.
    """
    a = BandStep()
    k, to = (-1 if part == "tail" else 0), a.symbols["to"]
    admitted = at_least(a.lines[0][k], to) if way > 0 else at_least(to)
    known = tuple(item for item in a.inside(k))
    changed = a.forecast.changed(mutation(1, 1.5 * way) * to, a.table)
    given = (*a.stated, at_least(to), admitted, *known)
    return Statement(a.symbols, (a.within(changed, k, way),), given)


@claim(
    "filter.band.stop-{word}-{part}",
    given=f"{TABLES}; 0 <= to <= what the conditions admit; {INSIDE}",
    over=EACH,
)
def stopped(mutation: Mutation, word: str, way: int, part: str) -> Statement:
    """{word} of the forecast <= c' if 0 follows a period behind the admitted command, from {told}.

    A stop a period later keeps the forecast within the limit, so that 0 is admitted then.
    """
    a = BandStep()
    line, to = (-1 if part == "tail" else 0), a.symbols["to"]
    admitted = tuple(at_least(limit[line], to) for limit in a.lines[1:])
    changed = a.forecast.changed(mutation(1, 1.5) * to, a.table).later(a.table)
    after = changed.changed(ca.SX(0), a.table)
    parts = (*range(1, a.size), -1) if part == "tail" else (0,)
    goals = tuple(a.within(after, k, way) for k in parts)
    return Statement(a.symbols, goals, (*a.stated, at_least(to), *admitted))


@claim("filter.band.zero", given=f"{TABLES}; {INSIDE}")
def zero(mutation: Mutation) -> Statement:
    """0 keeps the forecast within c', held or sent again a period later.

    A stop is always admitted, whatever the conditions say.
    """
    a = BandStep()
    everywhere = (*range(a.size), -1)
    now = a.forecast.changed(ca.SX(0), a.table)
    after = now.later(a.table).changed(mutation(0, 1) * a.symbols["c"], a.table)
    goals = [a.within(f, part, way) for f in (now, after) for part in everywhere for way in (1, -1)]
    return Statement(a.symbols, tuple(goals), (*a.stated, *a.inside(*everywhere)))


BANDED = {
    "filter.kind": "band", "filter.loop": "second-order", "filter.damping": (0.5, 1.0),
    "filter.frequency": (4.0, 5.0), "clock.control": 0.1,
}  # fmt: skip
"""Settings for the structure of the band's graph; its numbers are symbols."""


@claim(
    "filter.band.sent-{id}",
    given="every command (NaN included), any parameters",
    over=({"id": "linear", "axis": 0}, {"id": "angular", "axis": 1}),
)
def sent(mutation: Mutation, axis: int) -> Statement:
    """|u| <= the largest command, u what the whole band sends on the {id} axis, and u never turns
    against what was asked for.

    Nothing bypasses the filter: no command, not even NaN, and no scaling of the other axis.
    """
    graph = BandGovernor(load_scenario("paper-simulation", BANDED))
    limits, u = graph.limits, mutation(1, 1.1) * graph.sent[axis]
    named = elements_of(*graph.system.inputs)
    cuts = {f"limit {i}": limit for i, limit in enumerate(limits)} | {"sound": graph.sound}
    goals = (*within(u, limits[axis]), at_least(u * graph.command[axis]))
    return Statement(named, goals, tuple(at_least(limit) for limit in limits), cuts)


@claim(
    "filter.band.superposition",
    given="a linear loop of the family that reaches its command at rest, its numbers constant, at "
    "rest at the start; commands take over one period after the other; |d| <= dbar",
    by=HAND,
    premises="filter.band.over filter.band.under filter.peak-gain",
)
def superposition() -> None:
    """v(t) = sum of Delta_j S(age_j) + the response to pushes, which is at most delta.

    Forecasts that bound the sum bound the speed, at every instant of every member of the family.
    """


@claim(
    "filter.band.induction",
    given="a linear loop of the family, its numbers constant, at rest at the start; commands take "
    "over one period after the other, by a delay that is constant; |d| <= dbar",
    by=HAND,
    premises="filter.band.superposition filter.band.least filter.band.held-over-piece "
    "filter.band.held-over-tail filter.band.held-under-piece filter.band.held-under-tail "
    "filter.band.stop-over-piece filter.band.stop-over-tail filter.band.stop-under-piece "
    "filter.band.stop-under-tail filter.band.zero filter.band.mirrored filter.band.sent-linear "
    "filter.band.sent-angular",
)
def induction() -> None:
    """|v| <= K_max c (1 + 2^-30) + delta <= V at every instant: forecasts that are within c' stay
    so from sample to sample, whatever is asked for.

    The band keeps a loop that overshoots within its limit.
    """
