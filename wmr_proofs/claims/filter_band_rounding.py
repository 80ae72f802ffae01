"""Rounding of the command filter's band: forecasts and limits as the compiled text computes them.

A computed number is any result of rounding each operation by at most 2^-53 of it (`rounded`).
"""

from casadi import SX, symvar, vertcat

from wmr_ctrl.control.filter.forecast import PAST, PIECES, Fading, spread_of, stays_of
from wmr_proofs.claim import Claims, Mutation
from wmr_proofs.statement import Relations, Statement, between, listed, nonnegative, symbols, within

from .filter_band import WAYS, BandAxis, BandStep, bound_of

STEP = 2.0**-46
"""Share of c by which a change of the command may leave a computed forecast too low."""
WIDER = 2.0**-44
"""Share of c by which a computed limit may be that of a larger c."""
LEVEL = PAST - 2.0**-47
"""Share of c within which a command that is held keeps the speed, whatever was rounded."""

claim = Claims(premises="assumption.libm")


def _sizes(a: BandAxis) -> Relations:
    """Bounds of the known part and of both commands, in units of c."""
    s, c, numbers = a.symbols, a.c, range(a.size)
    columns = (s[f"{word}{i + 1}"] for word in ("over", "under") for i in numbers)
    sizes = *columns, s.past_over, s.past_under
    known = [within(item, 4 * c) for item in sizes]
    return [a.table.high[i] <= 5 for i in numbers], within(s.u, 2 * c), within(s.to, 2 * c), known


@claim("filter.rounding.band-forecast", each=WAYS)
def forecast(mutation: Mutation, way: int) -> Statement:
    """v + (to - u) S <= to + over + e + 2^-46 c and -v - (to - u) S <= -to + under + e + 2^-46 c,
    with over and under as computed for the changed command.

    A change of the command leaves a computed forecast too low by at most 2^-46 of c.

    Given: {BAND_SIZES}; v <= u + over + e, -v <= -u + under + e; low <= S <= high, the base's
    response.
    """
    a = BandAxis()
    s, changed = a | symbols("e made"), a.forecast.changed(a.to, a.table)
    bounded = way * s.u + bound_of(a.forecast, way) + s.e >= way * s.v, a.table.high[0] >= s.S
    given = a.stated, _sizes(a), s.e >= 0, a.table.low[0] <= s.S, bounded
    past, made = (s.past_over, changed.over) if way > 0 else (s.past_under, changed.under)
    most = way * s.to + past + s.made + s.e + mutation(1, 2.0**-9) * STEP * s.c
    return Statement(s, most >= way * (s.v + (s.to - s.u) * s.S), given, computed={"made": made})


@claim("filter.rounding.band-tail")
def tail(mutation: Mutation) -> Statement:
    """(tail + |to - u| left) f <= the tail that the text computes for the next sample.

    Behind the tables the computed forecast is never too low.

    Given: left, tail >= 0; f > 0, the share that stays in a period; fading >= f (1 + 2^-41).
    """
    a = BandAxis()
    s = a | symbols("f made")
    after = a.forecast.changed(s.to, a.table).later(a.table)
    given = s.f > 0, s.fading >= (1 + mutation(1, 0) * 2.0**-41) * s.f, nonnegative(s.left, s.tail)
    stays = s.f * (s.tail + abs(s.to - s.u) * s.left)
    return Statement(s, s.made >= stays, given, computed={"made": after.tail})


@claim(
    "filter.rounding.band-limit",
    each={
        f"{'stop-' * stops}{word}": {"stops": stops, "way": way}
        for stops in (False, True)
        for word, way in (("rise", 1), ("fall", -1))
    },
)
def limit(mutation: Mutation, stops: bool, way: int) -> Statement:
    """slope (to - u), or slope (u - to) of a fall that is held, is at most the room left of c'' (1
    + 2^-44), or of c' (1 + 2^-44) if 0 follows; for rises and falls.

    A command that the rounded conditions admit is admitted by the exact ones for a hardly larger
    limit.

    Given: {BAND_SIZES}; inverse slope <= 1, or >= 1 and slope > 0 of a fall behind which 0 follows;
    0 <= slope <= 10, inverse >= 1/16; to within the computed limit of this condition.
    """
    a = BandStep()
    s, table = a | symbols("limit wider inverse slope"), a.table
    wider, u, slope, inverse = s.wider, s.u, s.slope, s.inverse
    up = way > 0 or stops  # a fall that is held is a change the other way
    rooms = (a.forecast.rooms(c) for c in (a.most(not stops), wider))
    if stops:
        room, left = (both[1][PIECES] - u * table.after[0] for both in rooms)
    else:
        room, left = (both[0 if up else 1][0] for both in rooms)
    change, product = s.to - u, inverse * slope
    text = u + room * inverse if up else u - room * inverse
    own = {item.name() for item in symvar(vertcat(text, left, s.to))}
    known = listed((a.stated, _sizes(a), within(table.after[0], 5)))
    given = (
        [part for part in known if {item.name() for item in symvar(part.expr)} <= own],
        way * change >= 0, s.c > 0, 16 * inverse >= 1,
        slope > 0 if stops else slope >= 0,
        product >= 1 if stops and way < 0 else product <= 1,
        slope <= 10, s.limit >= s.to if up else s.to >= s.limit,
        wider >= a.most(not stops) * (1 + mutation(1, -1) * WIDER),
    )  # fmt: skip
    return Statement(s, left >= slope * change * (1 if up else -1), given, computed={"limit": text})


@claim("filter.rounding.band-beat")
def beat(mutation: Mutation) -> Statement:
    """-before' - e - 2^-51 T <= p' <= behind' + e + 2^-51 T for the next sample, as computed.

    Over the periods that tables reach back, rounding adds far less to a beat than is allowed.

    Given: -before - e <= p <= behind + e, the time at which a sample came, less whole periods,
    after the last one; 0 <= before, behind <= T; the next one comes 0 to 2 T after that; operations
    rounded by at most 2^-53.
    """
    s = symbols("before behind since T e p made_before made_behind")
    T, off = s.T, s.since - s.T
    after = spread_of(vertcat(s.before, s.behind), off)
    most, p = s.e + mutation(1, 2.0**-4) * 2.0**-51 * T, s.p - off
    given = (
        T > 0, between(0, s.since, 2 * T), s.e >= 0, between(0, s.before, T),
        between(0, s.behind, T), s.p + s.e >= -s.before, s.behind + s.e >= s.p,
    )  # fmt: skip
    goals = p + most >= -s.made_before, s.made_behind + most >= p
    return Statement(s, goals, given, computed={"made_before": after[0], "made_behind": after[1]})


@claim("filter.rounding.band-stays")
def stays(mutation: Mutation) -> Statement:
    """g (1 + 2^-41) <= the share that stays, as the text computes it.

    The computed remainder of earlier effects is not too small, however short the time since the
    last sample.

    Given: g, rate, time >= 0, g (1 + x + x^2/2) <= 1, x = rate time, the time since the last
    sample; operations rounded by at most 2^-53.
    """
    s = symbols("rate time g made")
    rate, time, g, made = s.values()
    x = rate * time
    given = nonnegative(rate, time, g), g * (1 + x + 0.5 * x * x) <= 1
    goal = made >= g * (1 + mutation(2.0**-41, 2.0**-39))
    return Statement(s, goal, given, computed={"made": stays_of(rate, time)})


@claim("filter.rounding.band-fading", premises="assumption.libm filter.rounding.band-stays")
def fading(mutation: Mutation) -> Statement:
    """r g (1 + 2^-42) and p g, or r g alone if the sample is untimely, are at most the computed
    bounds.

    The stored bounds of earlier effects are never too small, so errors do not accumulate.

    Given: 0 <= r <= reach, 0 <= p <= past; what stays of both is g >= 0, g (1 + 2^-41) <= the
    computed share, or the one of the shortest period where the sample came on its beat; operations
    rounded by at most 2^-53.
    """
    s = symbols("reach past held u came stays soonest r p g made_reach made_past")
    came = s.came
    after = Fading(s.reach, s.past, s.held).aged(came, s.u, s.stays, s.soonest)
    kept = s.g * (1 + mutation(2.0**-41, 0))
    signs = nonnegative(came * (came - 1), came * (1 - came), s.g, s.r, s.p)
    shares = s.soonest >= came * kept, s.stays >= (1 - came) * kept
    given = signs, s.reach >= s.r, s.past >= s.p, shares
    left = came * s.p + (1 - came) * s.r
    goals = s.made_reach >= s.r * s.g * (1 + 2.0**-42), s.made_past >= left * s.g
    return Statement(s, goals, given, computed={"made_reach": after.reach, "made_past": after.past})


@claim("filter.rounding.band-reached")
def reached(mutation: Mutation) -> Statement:
    """r + |to - u| reached <= the computed bound of the distance of the base from its command.

    A change of the command increases the decaying bound by enough.

    Given: r >= 0, r (1 + 2^-42) <= reach; reached >= 0, reached (1 + 2^-41) <= the number in the
    tables; operations rounded by at most 2^-53.
    """
    s = symbols("reach furthest r reached u to made")
    reach, furthest, r, reached, u, to, made = s.values()
    change = to - u
    none = SX(0)
    after = Fading(reach, none, none).changed(change, furthest)
    listed = furthest >= reached * (1 + mutation(1, 0) * 2.0**-41)
    given = nonnegative(r, reached), reach >= r * (1 + 2.0**-42), listed
    return Statement(s, made >= r + abs(change) * reached, given, computed={"made": after.reach})


@claim("filter.rounding.band-past", each=WAYS)
def past(mutation: Mutation, way: int) -> Statement:
    """v - held and held - v are at most the computed bounds of earlier commands' effects.

    After an untimely sample the computed bounds are no smaller than the certain ones.

    Given: c > 0, |held| <= 2 c; v <= c (1 + 2^-29 - 2^-47) and v - held <= past, as long as the
    command stays held; under it, the same of -v and -held; operations rounded by at most 2^-53.
    """
    s = symbols("c past held v made")
    bounds = Fading(SX(0), s.past, s.held).bounds(s.c)
    v, most = way * (s.v - s.held), mutation(LEVEL, PAST + 2.0**-47) * s.c
    given = s.c > 0, within(s.held, 2 * s.c), s.past >= v, most >= way * s.v
    return Statement(s, s.made >= v, given, computed={"made": bounds[0 if way > 0 else 1]})
