"""The band of the command filter: what its forecasts bound, and what it admits.

Tables of one piece and the tail: every piece of longer ones is reckoned alike.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import casadi as ca

from wmr_ctrl.filter.band import Forecast, ResponseTable
from wmr_ctrl.proofs.claim import Claims, Mutation
from wmr_ctrl.proofs.ledger import HAND
from wmr_ctrl.proofs.methods.spec import Z3
from wmr_ctrl.proofs.statement import Relation, Statement, above, at_least, stacked, symbols

TABLES = "0 <= low <= high on every piece, left, fading in [0, 1]"
claim = Claims(by=Z3(effort=100))


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
        """What is known at the sample."""
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
    over=({"word": "over", "sign": "", "way": 1}, {"word": "under", "sign": "-", "way": -1}),
)
def forecast(mutation: Mutation, word: str, way: int) -> Statement:
    """{sign}(v + (to - u) S) <= {sign}to + {word} of the changed forecast.

    A change of the command keeps the forecast one, whatever member of the family the base is.
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


@claim(
    "filter.band.mirrored",
    given=f"{TABLES}",
)
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


@claim(
    "filter.band.superposition",
    given="a linear loop of the family that reaches its command at rest, its numbers constant, at "
    "rest at the start; commands take over one period after the other; |d| <= dbar",
    by=HAND,
    premises="filter.band.over filter.band.under filter.peak-gain",
)
def superposition() -> None:
    """v(t) = sum of Delta_j S(age_j) + what pushes lead to, of which at most delta.

    Forecasts that bound the sum bound the speed, at every instant of every member of the family.
    """
