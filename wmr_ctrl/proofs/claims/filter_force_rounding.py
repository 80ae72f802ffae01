"""Rounding of the command filter's band of weak motors, as the compiled text computes it.

A computed number is whatever roundings of at most 2^-53 of each operation give (`rounded`).  d is
how far the command moves, A the largest force that a command of 1 leads to, and ``slope`` what a
quantity changes by where the command moves by 1.
"""

import casadi as ca

from wmr_ctrl.filter import force_band
from wmr_ctrl.filter.forecast import Forecast
from wmr_ctrl.proofs.claim import Claims, Mutation
from wmr_ctrl.proofs.claims.filter_band import WAYS, BandAxis, bound_of
from wmr_ctrl.proofs.ledger import HAND
from wmr_ctrl.proofs.methods.spec import Z3
from wmr_ctrl.proofs.relation import Relation, above, at_least, between, positive, within
from wmr_ctrl.proofs.statement import UNIT, Statement
from wmr_ctrl.proofs.symbols import Symbols, symbols

STRONGEST = 2.0**8
"""Most of a step by c that a loop may ask for, over f."""
ENDED = 2.0**-50
"""Share of c by which a rounded sum may admit more than its rise."""
ROOM, LINED, STEP = 2.0**-47, 2.0**-40, 2.0**-38
"""Shares of f by which a room is off, a line admits too much, and a change passes f at most."""
CHANGED = 2.0**-40
"""Share of f by which a change may leave a computed forecast of the force too low."""
SPEED = 2.0**-46
"""Share of c by which a change may take a forecast of the speed beyond c."""
ROUNDED = "operations rounded by at most 2^-53"
TURNS = ({"turn": "rise", "rises": True}, {"turn": "fall", "rises": False})
NONE, ZERO = ca.SX(0, 1), ca.SX(0)
claim = Claims(by=Z3(effort=100), premises="assumption.libm")


def _strong(s: Symbols, most: float = STRONGEST) -> tuple[Relation, ...]:
    """c, f > 0; A c <= 2^8 f."""
    return *positive(s.f, s.c), at_least(most * s.f, s.A * s.c)


def _moved(s: Symbols, most: ca.SX) -> tuple[Relation, ...]:
    """0 <= d <= 6 c, and at most what the text admits, but for the rounding of the sum with u."""
    d, c = s.d, s.c
    return *between(0, d, 6 * c), at_least(ca.fmax(most, 0) + ENDED * c, d)


@claim(
    "filter.rounding.force-sum",
    given="force and drag speed of at most 4 f, drag u of at most 2 f in size, of what is past, "
    f"too; {ROUNDED}",
)
def summed(mutation: Mutation) -> Statement:
    """force + drag speed, of what is past, too, and drag u, miss what the text computes for them by
    at most 2^-49 f.

    Force and friction together are foreseen well enough.
    """
    s = symbols("force speed past_force past_speed drag u f ahead past ends")
    f, u, drag = s.f, s.u, s.drag
    force, speed = (
        Forecast(NONE, NONE, s[name], u, s[f"past_{name}"], ZERO) for name in ("force", "speed")
    )
    both = force_band.with_drag(force, speed, drag)
    computed = {"ahead": both.tail, "past": both.past_over, "ends": both.u}
    exact = {"ahead": s.force + drag * s.speed,
             "past": s.past_force + drag * s.past_speed, "ends": drag * u}  # fmt: skip
    given = [above(f), *within(drag * u, 2 * f)]
    for name, share in (("force", 1), ("speed", drag)):
        for own in (name, f"past_{name}"):
            given += within(share * s[own], 4 * f)
    spare = mutation(1, 2.0**-4) * 2.0**-49 * f
    goals = tuple(part for name in exact for part in within(s[name] - exact[name], spare))
    return Statement(s, goals, tuple(given), computed=computed)


@claim(
    "filter.rounding.force-room",
    given=f"what is ahead and what is past of at most 9 f, where it ends of at most 3 f; {ROUNDED}",
    premises="assumption.libm filter.rounding.force-sum",
)
def room(mutation: Mutation) -> Statement:
    """|above - (f - (ends + past + ahead))|, |below - (f - (past + ahead - ends))| <= 2^-47 f, of
    the rooms that the text computes.

    What is left of the force is computed well enough, with friction and, with drag = 0, without.
    """
    s = symbols("ahead past ends f above below")
    f, ends, past = s.f, s.ends, s.past
    left = Forecast(NONE, NONE, s.ahead, ends, past, past).rooms(f, ends)
    given = (above(f), *within(s.ahead, 9 * f), *within(past, 9 * f), *within(ends, 3 * f))
    goals = list[Relation]()
    for name, way in (("above", 1), ("below", -1)):
        exact = f - (s.ahead + past + way * ends)
        goals += within(s[name] - exact, mutation(1, 2.0**-4) * ROOM * f)
    return Statement(s, tuple(goals), given, computed={"above": left[0], "below": left[1]})


@claim(
    "filter.rounding.force-slope",
    given=f"drag >= 0; |low|, |high| <= A of the force, at most 5 of the speed; {ROUNDED}",
)
def slope(mutation: Mutation) -> Statement:
    """the computed sums of force and drag times speed are off by at most 2^-51 (A + 5 drag).

    What a change takes of the motors, friction included, is computed well enough.
    """
    s = symbols("low high low_speed high_speed drag A least most")
    pairs = (s.high, -s.low), (s.high_speed, -s.low_speed)
    force, speed = (force_band.force_response(*pair, ZERO, ZERO) for pair in pairs)
    low, high = force_band.dragging(force, speed, s.drag)
    given, goals = [at_least(s.drag)], list[Relation]()
    spare = mutation(1, 2.0**-3) * 4 * UNIT * (s.A + 5 * s.drag)
    for name, made in (("low", "least"), ("high", "most")):
        own = s[f"{name}_speed"]
        given += [*within(s[name], s.A), *within(own, 5)]
        goals += within(s[made] - (s[name] + s.drag * own), spare)
    computed = {"least": low[0], "most": high[0]}
    return Statement(s, tuple(goals), tuple(given), computed=computed)


@claim(
    "filter.rounding.force-line-{word}",
    given="|slope| <= A, A c <= 2^9 f; |room| <= 16 f; 0 <= d <= 6 c, d at most the line that the "
    f"text computes, or 0, and 2^-50 c; {ROUNDED}",
    over=({"word": "up", "sign": 1}, {"word": "down", "sign": -1}),
)
def lined(mutation: Mutation, sign: int) -> Statement:
    """d slope <= max(room, 0) + 2^-40 f.

    A change that a computed line admits takes no more than the room, however flat the line is.
    """
    s = symbols("first slope room f c A d line")
    rising = s.slope if sign > 0 else -s.slope
    low, high = ca.vertcat(0, rising), ca.vertcat(s.first, rising)
    inverse = force_band.inverse_force_slopes(low, high)[0 if sign > 0 else 1][1]
    sizes = *within(s.slope, s.A), *within(s.room, 16 * s.f)
    given = (*_strong(s, 2 * STRONGEST), above(s.first), *sizes, *_moved(s, s.line))
    most = ca.fmax(s.room, 0) + mutation(1, 2.0**-8) * LINED * s.f
    goals = (at_least(most, s.d * s.slope),)
    return Statement(s, goals, given, computed={"line": force_band.line(s.room, inverse)})


@claim(
    "filter.rounding.force-{word}",
    given="A c <= 2^8 f; |low|, |high| <= A; |u|, |to| <= 2 c; |over|, |under| <= 4 f; {sign}F <= "
    f"{{word}} + e; low <= W <= high, the force behind a step; {ROUNDED}",
    over=WAYS,
)
def forecast(mutation: Mutation, word: str, way: int) -> Statement:
    """{sign}(F + (to - u) W) <= {word} + e + 2^-40 f, {word} as the text computes it for the
    changed command.

    A change of the command leaves a computed forecast of the force too low by at most 2^-40 of f.
    """
    s = symbols("low high over under u to f c A F W e made")
    table = force_band.force_response(s.high, -s.low, ZERO, ZERO)
    known = Forecast(s.over, s.under, ZERO, s.u, ZERO, ZERO)
    changed = known.changed(s.to, table)
    given = [*_strong(s), at_least(s.e), *between(s.low, s.W, s.high)]
    sizes = {"low": s.A, "high": s.A, "u": 2 * s.c, "to": 2 * s.c}
    for name, most in (sizes | dict.fromkeys(("over", "under"), 4 * s.f)).items():
        given += within(s[name], most)
    given.append(at_least(s[word] + s.e, way * s.F))
    most = s.made + s.e + mutation(1, 2.0**-8) * CHANGED * s.f
    goal = at_least(most, way * (s.F + (s.to - s.u) * s.W))
    made = changed.over if way > 0 else changed.under
    return Statement(s, (goal,), tuple(given), computed={"made": made})


@claim(
    "filter.rounding.force-end",
    given="|u| <= 2 c; rises and falls of at least 0, the first ones of at most 6 c; to between "
    f"the ends of the text; {ROUNDED}",
)
def end(mutation: Mutation) -> Statement:
    """-(fall + 2^-50 c) <= to - u <= rise + 2^-50 c, for each of the three rises and falls.

    A command goes no further than every condition admits, but for the rounding of one sum.
    """
    names = [(f"rise{i}", f"fall{i}") for i in (1, 2, 3)]
    every = [name for pair in names for name in pair]
    s = symbols(f"u to c least most {' '.join(every)}")
    c, change = s.c, s.to - s.u
    least, most = force_band.reached(s.u, [(s[rise], s[fall]) for rise, fall in names])
    given = [above(c), *within(s.u, 2 * c), at_least(s.most, s.to)]
    given.append(at_least(s.to, s.least))
    given += [*map(at_least, (s[name] for name in every))]
    given += [at_least(6 * c, s[name]) for name in names[0]]
    spare = mutation(1, 2.0**-3) * ENDED * c
    goals = list[Relation]()
    for rise, fall in names:
        goals += at_least(s[rise] + spare, change), at_least(change, -s[fall] - spare)
    return Statement(s, tuple(goals), tuple(given), computed={"least": least, "most": most})


@claim(
    "filter.rounding.force-speed-{turn}",
    given="|high| <= 5 on the piece, 0 <= left <= 1/5; |over|, |under| <= 4 c, -c <= "
    "past <= 4 c, 0 <= tail <= 4 c, |u| <= 2 c; inverse high <= 1, inverse >= 1/16; 0 <= d <= the "
    f"{{turn}} of the text and 2^-50 c; {ROUNDED}",
    over=TURNS,
)
def speed(mutation: Mutation, rises: bool) -> Statement:
    """d <= 6 c; the bound before and d high <= max(the bound before, c) + 2^-46 c, on the piece and
    behind.

    A command that is admitted by roundings keeps the speed's forecast within c but for roundings.
    """
    a = BandAxis()
    s, c = a.symbols | symbols("d turn inverse inverse_behind"), a.c
    way = 1 if rises else -1
    d = s.d
    inverse = ca.vertcat(s.inverse, s.inverse_behind)
    steps = a.forecast.steps(c, inverse)
    given = [*a.faded, *within(a.table.high[0], 5), at_least(0.2, s.left), at_least(4 * c, s.tail)]
    given += *within(s.u, 2 * c), *within(s.over1, 4 * c), *within(s.under1, 4 * c)
    given += between(0, d, s.turn + ENDED * c)
    for word in ("over", "under"):
        given += [at_least(4 * c, s[f"past_{word}"]), at_least(s[f"past_{word}"], -c)]
    for item, high in zip(ca.vertsplit(inverse), ca.vertsplit(a.table.high), strict=True):
        given += [at_least(1, item * high), at_least(16 * item, ca.SX(1))]
    spare, goals = mutation(1, 2.0**-8) * SPEED * c, [at_least(6 * c, d)]
    for part, high in zip((0, -1), ca.vertsplit(a.table.high), strict=True):
        before = bound_of(a.forecast, way, part) + way * s.u
        goals.append(at_least(ca.fmax(before, c) + spare, before + d * high))
    return Statement(s, tuple(goals), tuple(given), computed={"turn": steps[0 if rises else 1]})


@claim(
    "filter.rounding.force-least-{turn}",
    given="any forecast, limit and lines, on a piece and behind",
    over=TURNS,
    premises="",
)
def least(mutation: Mutation, rises: bool) -> Statement:
    """0 <= the {turn} <= the larger of 0 and each line, of the rooms above and below.

    The text compares each room with what the change takes of it, up or down.
    """
    s = symbols("over under tail past_over past_under u f held up down up_behind down_behind")
    past = s.past_over, s.past_under
    known, f = Forecast(s.over, s.under, s.tail, s.u, *past), s.f
    up, down = (ca.vertcat(s[name], s[f"{name}_behind"]) for name in ("up", "down"))
    inverse = up, down
    most = force_band.force_steps(known, f, inverse, s.held)[0 if rises else 1]
    lines = [
        force_band.line(left, inverse[(way > 0) != rises])
        for left, way in zip(known.rooms(f, s.held), (1, -1), strict=True)
    ]
    each = {f"line{i}": item for i, item in enumerate(ca.vertsplit(ca.vertcat(*lines)))}
    goals = [at_least(ca.fmax(item, 0), mutation(1, 1.1) * most) for item in each.values()]
    return Statement(s, (*goals, at_least(most)), cuts=each)


@claim(
    "filter.rounding.force",
    given="the hypotheses of filter.band.ramp; high <= 5 of the speed, left <= 1/5, fading <= 1 - "
    "2^-40; tables of at most 128 periods; A c <= 2^8 f, A the largest size in the force's tables, "
    "0 <= drag c <= f; no overflow, and no underflow but of the tails",
    by=HAND,
    premises="filter.band.ramp filter.rounding.force-sum filter.rounding.force-room "
    "filter.rounding.force-slope "
    "filter.rounding.force-line-up filter.rounding.force-line-down "
    "filter.rounding.force-least-rise filter.rounding.force-least-fall filter.rounding.force-end "
    "filter.rounding.force-speed-rise filter.rounding.force-speed-fall "
    "filter.rounding.force-over filter.rounding.force-under filter.rounding.band-over "
    "filter.rounding.band-under filter.rounding.band-tail filter.rounding.band-untimely "
    "filter.rounding.clip",
)
def force() -> None:
    """|v| <= V and |F| <= F_max, V and F_max as stated, behind what the text of the band of weak
    motors computes, whenever it is called: a piece of time is carried through at most 128 periods,
    of which each adds 2^-45 of c and 2^-37 of f.

    The margin that is kept back covers the roundings of the band of weak motors, for ever.
    """
