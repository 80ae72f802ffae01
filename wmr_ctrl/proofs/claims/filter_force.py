"""The band of bases whose motors give only so much force: what its forecasts bound and admit.

Tables of one piece and the tail: every piece of longer ones is reckoned alike.
"""

from dataclasses import dataclass
from functools import cached_property

import casadi as ca

from wmr_ctrl.filter.band import Forecast, ResponseTable, inverse_slopes
from wmr_ctrl.filter.force_band import (
    ForceBand,
    force_steps,
    inverse_force_slopes,
    speed_steps,
)
from wmr_ctrl.proofs.claim import Claims, Mutation
from wmr_ctrl.proofs.claims.common import elements_of
from wmr_ctrl.proofs.claims.filter_band import WAYS, BandAxis
from wmr_ctrl.proofs.ledger import HAND
from wmr_ctrl.proofs.methods.spec import Z3
from wmr_ctrl.proofs.statement import Relation, Statement, above, at_least, equal, symbols
from wmr_ctrl.scenario import load_scenario

claim = Claims(by=Z3(effort=100))
FORCES = "low <= high on every piece, 0 < high on the first, left >= 0, fading in [0, 1]"


@dataclass(frozen=True)
class ForceAxis:
    """Symbols of one axis' force: tables, forecast, the new command ``to``, the base's response."""

    @cached_property
    def symbols(self) -> dict[str, ca.SX]:
        """Every number by name; f is the force that is left to change the speed."""
        return symbols("low high over under left fading tail u to f F W")

    @cached_property
    def table(self) -> ResponseTable:
        """Tables as the filter's graph reads them."""
        s = self.symbols
        low, high = ca.vertcat(s["low"], -s["left"]), ca.vertcat(s["high"], s["left"])
        return ResponseTable(low, high, s["left"], s["fading"], rest=0)

    @cached_property
    def forecast(self) -> Forecast:
        """What is known at the sample."""
        s = self.symbols
        return Forecast(s["over"], s["under"], s["tail"], s["u"])

    @property
    def stated(self) -> tuple[Relation, ...]:
        """low <= high, 0 < high; left and tail are not negative; f > 0."""
        s = self.symbols
        shares = at_least(s["fading"]), at_least(ca.SX(1), s["fading"]), at_least(s["left"])
        signs = above(s["high"]), at_least(s["high"], s["low"]), at_least(s["tail"]), above(s["f"])
        return (*shares, *signs)


@claim(
    "filter.band.force-{word}",
    given=f"{FORCES}; {{sign}}F <= {{word}}; low <= W <= high, the force behind a step",
    over=WAYS,
)
def forecast(mutation: Mutation, word: str, way: int) -> Statement:
    """{sign}(F + (to - u) W) <= {word} of the changed forecast.

    After a change of the command the forecast still bounds the force of every member.
    """
    a = ForceAxis()
    s, changed = a.symbols, a.forecast.changed(a.symbols["to"], a.table)
    known = {"over": a.forecast.over, "under": a.forecast.under}[word]
    given = (
        *a.stated, at_least(known, way * s["F"]), at_least(s["W"], a.table.low[0]),
        at_least(mutation(1, 1.1) * a.table.high[0], s["W"]),
    )  # fmt: skip
    bound = {"over": changed.over, "under": changed.under}[word]
    return Statement(s, (at_least(bound, way * (s["F"] + (s["to"] - s["u"]) * s["W"])),), given)


@claim(
    "filter.band.ramp-speed",
    given="0 <= low <= high on every piece, left in [0, 1]; v and -v within c before, on every "
    "piece and behind; to between what a fall and a rise are admitted",
)
def ramped_speed(mutation: Mutation) -> Statement:
    """to + over, -to + under of the changed forecast <= c, on the piece and behind.

    A command that is admitted and held keeps the speed's forecast within the limit.
    """
    a = BandAxis()
    s, c, to, u = a.symbols, a.symbols["c"], a.symbols["to"], a.symbols["u"]
    inverse = inverse_slopes(_longer(a.table.low), _longer(a.table.high))[0][-2:]
    rise, fall = speed_steps(a.forecast, c, inverse)
    before, after = (_parts(f) for f in (a.forecast, a.forecast.changed(to, a.table)))
    given = (
        *a.stated, *(at_least(c, part + way * u) for part, way in before),
        at_least(u + mutation(1, 1.2) * rise, to), at_least(to, u - fall),
    )  # fmt: skip
    return Statement(s, tuple(at_least(c, part + way * to) for part, way in after), given)


@claim(
    "filter.band.ramp-force",
    given=f"{FORCES}; F and -F within f before, on every piece and behind; to between what a fall "
    "and a rise are admitted",
)
def ramped_force(mutation: Mutation) -> Statement:
    """over, under of the changed forecast of the force <= f, on the piece and behind.

    A command that is admitted and held keeps the force within what is left.
    """
    a = ForceAxis()
    s, f, to, u = a.symbols, a.symbols["f"], a.symbols["to"], a.symbols["u"]
    rise, fall = force_steps(a.forecast, f, inverse_force_slopes(a.table))
    before, after = (_parts(item) for item in (a.forecast, a.forecast.changed(to, a.table)))
    given = (
        *a.stated, *(at_least(f, part) for part, _ in before),
        at_least(u + mutation(1, 1.2) * rise, to), at_least(to, u - fall),
    )  # fmt: skip
    return Statement(s, tuple(at_least(f, part) for part, _ in after), given)


def _longer(values: ca.SX) -> ca.SX:
    """Tables of as many pieces as conditions on a stop ask for; the first ones are not used."""
    return ca.vertcat(values[0], values[0], values)


def _parts(known: Forecast) -> list[tuple[ca.SX, int]]:
    """Bounds on the piece and behind it, of the quantity (1) and of its negative (-1)."""
    return [(known.over, 1), (known.tail, 1), (known.under, -1), (known.tail, -1)]


WEAK = {
    "filter.kind": "band", "filter.loop": "pi", "filter.mass": (50, 65), "filter.inertia": (4, 6),
    "filter.kp": (135, 165), "filter.ki": (270, 330), "filter.force": (300, 100),
    "clock.control": 0.5,
}  # fmt: skip
"""Settings for the structure of the band's graph; its numbers are symbols."""


@claim(
    "filter.band.ramp-sent-{id}",
    given="every command (no number, too), parameters that are sound; 0 <= what a fall and a rise "
    "are admitted",
    over=({"id": "linear", "axis": 0}, {"id": "angular", "axis": 1}),
)
def sent(mutation: Mutation, axis: int) -> Statement:
    """u_before - fall <= u <= u_before + rise, u what the whole band sends on the {id} axis.

    Nothing bypasses the filter: no number that is asked for, nor the other axis' scaling.
    """
    graph = ForceBand(load_scenario("paper-simulation", WEAK))
    named = elements_of(*graph.system.inputs)
    cuts = {f"end {i} {k}": end for i, pair in enumerate(graph.ends) for k, end in enumerate(pair)}
    (least, most), u = graph.ends[axis], mutation(1, 1.1) * graph.sent[axis]
    ordered = tuple(at_least(high, low) for low, high in graph.ends)
    given = (*ordered, equal(graph.sound, 1))
    goals = at_least(most, u), at_least(u, least)
    return Statement(named, goals, given, cuts | {"sound": graph.sound})


@claim(
    "filter.band.force",
    given="a PI loop of the family, its numbers constant, at rest at the start, whose motors give "
    "what it asks for; commands take over one period after the other; |d| <= dbar, |v| <= V",
    by=HAND,
    premises="filter.band.force-over filter.band.force-under filter.peak-gain",
)
def force() -> None:
    """F = sum of Delta_j M S'(age_j) + c v_u + what pushes make it give, at most N dbar, v_u what
    commands alone lead to, |v_u| <= V.

    Forecasts that bound the sum by f = F_max - c_max V - N dbar bound what the loop asks for.
    """


@claim(
    "filter.band.ramp",
    given="a PI loop of the family, its numbers constant, at rest at the start; motors that give "
    "F_max; commands take over one period after the other, by a constant delay; |d| <= dbar",
    by=HAND,
    premises="filter.band.superposition filter.band.force filter.band.ramp-speed "
    "filter.band.ramp-force filter.band.ramp-sent-linear filter.band.ramp-sent-angular",
)
def ramp() -> None:
    """|v| <= c + delta <= V and |F| <= F_max at every instant: forecasts that are within c and f
    stay so from sample to sample, and the command before may always be held.

    The band keeps a loop that overshoots within its limit, however weak its motors are.
    """
