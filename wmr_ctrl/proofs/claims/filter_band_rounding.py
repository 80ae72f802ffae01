"""Rounding of the command filter's band: forecasts and limits as the compiled text computes them.

A computed number is whatever roundings of at most 2^-53 of each operation give (`rounded`).
"""

import casadi as ca

from wmr_ctrl.filter.forecast import PIECES
from wmr_ctrl.proofs.claim import Claims, Mutation
from wmr_ctrl.proofs.claims.filter_band import TABLES, WAYS, BandAxis, BandStep, bound_of
from wmr_ctrl.proofs.ledger import HAND
from wmr_ctrl.proofs.methods.spec import Z3
from wmr_ctrl.proofs.statement import Relation, Statement, above, at_least, symbols, within

STEP = 2.0**-46
"""Share of c by which a change of the command may leave a computed forecast too low."""
WIDER = 2.0**-44
"""Share of c by which a computed limit may be that of a larger c."""
SIZES = f"{TABLES}, high <= 5; |u|, |to| <= 2 c, |over|, |under|, |past| <= 4 c"
claim = Claims(by=Z3(effort=100))


def _sizes(a: BandAxis) -> tuple[Relation, ...]:
    """Bounds of what is known, and of both commands, in sizes of c."""
    s, c, numbers = a.symbols, a.symbols["c"], range(a.size)
    columns = (a.column(word)[i] for word in ("over", "under") for i in numbers)
    sizes = (*columns, s["past_over"], s["past_under"])
    return (
        *(at_least(ca.SX(5), a.table.high[i]) for i in numbers), *within(s["u"], 2 * c),
        *within(s["to"], 2 * c), *(part for item in sizes for part in within(item, 4 * c)),
    )  # fmt: skip


@claim(
    "filter.rounding.band-{word}",
    given=f"{SIZES}; {{sign}}v <= {{sign}}u + {{word}} + e; low <= S <= high, the base's response",
    premises="assumption.libm",
    over=WAYS,
)
def forecast(mutation: Mutation, word: str, way: int) -> Statement:
    """{sign}(v + (to - u) S) <= {sign}to + {word} + e + 2^-46 c, {word} as the text computes it for
    the changed command.

    A change of the command leaves a computed forecast too low by at most 2^-46 of c.
    """
    a = BandAxis()
    s, changed = a.symbols | symbols("e made"), a.forecast.changed(a.symbols["to"], a.table)
    known = bound_of(a.forecast, way)
    given = (
        *a.stated, *_sizes(a), at_least(s["e"]), at_least(s["S"], a.table.low[0]),
        at_least(way * s["u"] + known + s["e"], way * s["v"]), at_least(a.table.high[0], s["S"]),
    )  # fmt: skip
    past = s[f"past_{word}"]
    most = way * s["to"] + past + s["made"] + s["e"] + mutation(1, 2.0**-9) * STEP * s["c"]
    goal = at_least(most, way * (s["v"] + (s["to"] - s["u"]) * s["S"]))
    made = {"over": changed.over, "under": changed.under}[word]
    return Statement(s, (goal,), given, computed={"made": made})


@claim(
    "filter.rounding.band-tail",
    given="left, tail >= 0; f > 0, the share that stays in a period; fading >= f (1 + 2^-41)",
    premises="assumption.libm",
)
def tail(mutation: Mutation) -> Statement:
    """(tail + |to - u| left) f <= the tail that the text computes for the next sample.

    Behind the tables the computed forecast is never too low.
    """
    a = BandAxis()
    s = a.symbols | symbols("f made")
    after = a.forecast.changed(s["to"], a.table).later(a.table)
    given = (
        above(s["f"]), at_least(s["fading"], (1 + mutation(1, 0) * 2.0**-41) * s["f"]),
        at_least(s["left"]), at_least(s["tail"]),
    )  # fmt: skip
    stays = s["f"] * (s["tail"] + ca.fabs(s["to"] - s["u"]) * s["left"])
    return Statement(s, (at_least(s["made"], stays),), given, computed={"made": after.tail})


LINES = (
    {"id": "rise", "stops": False, "way": 1, "told": "to >= u; inverse slope <= 1"},
    {"id": "fall", "stops": False, "way": -1, "told": "to <= u; inverse slope <= 1"},
    {"id": "stop-rise", "stops": True, "way": 1, "told": "to >= u; inverse slope <= 1"},
    {"id": "stop-fall", "stops": True, "way": -1,
     "told": "to <= u; slope > 0, inverse slope >= 1"},
)  # fmt: skip


@claim(
    "filter.rounding.band-{id}",
    given=f"{SIZES}; {{told}}; 0 <= slope <= 10, inverse >= 1/16; to within what this condition "
    "admits, as the text computes it",
    premises="assumption.libm",
    over=LINES,
)
def limit(mutation: Mutation, stops: bool, way: int) -> Statement:
    """slope (to - u) <= what is left of c'' (1 + 2^-44), or c' (1 + 2^-44) where 0 follows, there.

    A command that is admitted by roundings is admitted without them for a hardly larger limit.
    """
    a = BandStep()
    s, table = a.symbols | symbols("limit wider inverse slope"), a.table
    wider, u, slope, inverse = s["wider"], s["u"], s["slope"], s["inverse"]
    up = way > 0 or stops  # a fall that is held is a change the other way
    if stops:
        room, left = (
            a.forecast.rooms(c, u)[1][PIECES] - u * table.after[0]
            for c in (a.most(not stops), wider)
        )
    else:
        room, left = (a.forecast.rooms(c, u)[0 if up else 1][0] for c in (a.most(not stops), wider))
    change, product = s["to"] - u, inverse * slope
    text = u + room * inverse if up else u - room * inverse
    own = {item.name() for item in ca.symvar(ca.vertcat(text, left, s["to"]))}
    known = (*a.stated, *_sizes(a), *within(table.after[0], ca.SX(5)))
    given = (
        *(part for part in known if {item.name() for item in ca.symvar(part.expr)} <= own),
        at_least(way * change), above(s["c"]), at_least(16 * inverse, ca.SX(1)),
        above(slope) if stops else at_least(slope),
        at_least(product, ca.SX(1)) if stops and way < 0 else at_least(ca.SX(1), product),
        at_least(ca.SX(10), slope),
        at_least(s["limit"], s["to"]) if up else at_least(s["to"], s["limit"]),
        at_least(wider, a.most(not stops) * (1 + mutation(1, -1) * WIDER)),
    )  # fmt: skip
    goal = at_least(left, slope * change * (1 if up else -1))
    return Statement(s, (goal,), given, computed={"limit": text})


@claim(
    "filter.rounding.band",
    given="the hypotheses of filter.band.induction; high <= 5, left <= 1/5, fading <= 1 - 2^-40; "
    "tables of at most 128 periods; no overflow, and no underflow but of the tail",
    by=HAND,
    premises="filter.band.induction filter.rounding.band-over filter.rounding.band-under "
    "filter.rounding.band-tail filter.rounding.band-rise filter.rounding.band-fall "
    "filter.rounding.band-stop-rise filter.rounding.band-stop-fall filter.rounding.clip",
)
def band() -> None:
    """|v| <= V, V the stated limit, behind what the band's text computes: a piece of time is
    carried through at most 128 periods, of which each adds 2^-45 of c.

    The margin that is kept back covers the band's roundings, for ever.
    """
