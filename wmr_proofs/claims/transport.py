"""The level transport: V1 and |w| do not rise when a velocity is carried along with its target.

V1 enters by values at a few points, which are free numbers with known properties: that V1(.; c)
lies above its chords and, by w^2/2, above its minimum at v_c1.
"""

from casadi import SX, eq, if_else, logic_and, logic_or

from wmr_ctrl.control.barrier.proximal import level_share, resolvent, transported
from wmr_ctrl.control.barrier.stable import smooth_barrier, stable_barrier
from wmr_proofs.claim import Claims, Mutation
from wmr_proofs.paper_barrier import f, lyapunov, minimiser
from wmr_proofs.paper_functions import smooth_f, smooth_lyapunov
from wmr_proofs.statement import (
    Relations,
    Statement,
    Symbols,
    between,
    equal,
    nonnegative,
    symbols,
    when,
)

from .common import EITHER_BARRIER

COMPILED = "forms.V1 forms.v_c1 P1.prox smooth.V1 smooth.v_c1"


class Carried:
    """`transported` with its targets, V0, D1 and theta as free numbers; V1(v*; c+) is ``after``.

    ``cuts`` are the expressions of the first five, ``end`` is v*.
    """

    def __init__(self, smooth: bool) -> None:
        self.inputs = t = symbols("v c c_next u1 u2", "u1 u2")
        self.free = symbols("x x_next level excess share after")
        v, limits, form = t.v, (t.u1, t.u2), smooth_barrier if smooth else stable_barrier
        x, x_next = (resolvent(c, SX(1), *limits, smooth) for c in (t.c, t.c_next))
        ahead = x_next + (v - x)
        level = form(t.c, if_else(abs(v) < t.u1, v, 0), *limits).V1
        reached = if_else(abs(ahead) < t.u1, ahead, 0)
        excess = form(t.c_next, reached, *limits).D
        share = level_share(v - x, level, excess)
        self.cuts = {"x": x, "x_next": x_next, "level": level, "excess": excess, "share": share}
        self.end = transported(v, t.c, t.c_next, limits, smooth)

    def states(self, goals: Relations, given: Relations) -> Statement:
        """The statement on the graph of `transported`.

        0 < u2 < u1, |x| and |x+| < u1, x = x+ where the target is held, theta by its entry.
        """
        t = self.inputs | self.free
        u1, share = t.u1, t.share
        inside = [u1 > way * t[x] for way in (1, -1) for x in ("x", "x_next")]
        held = when(eq(t.c, t.c_next), t.x == t.x_next)
        known = t.u2 > 0, u1 > t.u2, inside, held, share >= 0
        return Statement(t, goals, (known, share <= 1, given), self.cuts)


claim = Claims()


@claim("transport.share", premises="eq81")
def transport_share(mutation: Mutation) -> Statement:
    """0 <= theta <= 1 and theta^2 w^2/2 + theta D1 <= V0.

    How far the velocity is carried is chosen such that what V1 allows is not exceeded.

    Given: V0 >= w^2/2, D1 >= 0, any w.
    """
    t = symbols("w level excess")
    w, level, excess = t.values()
    theta = level_share(w, level, excess)
    spent = 0.5 * (theta * w) ** 2 + theta * excess
    room = mutation(level, 0.9 * level)
    given = level >= 0.5 * w**2, excess >= 0
    return Statement(t, (between(0, theta, 1), room >= spent), given)


@claim(
    "transport.moves",
    premises="convex smooth.convex eq81 prox.optimal",
    each=EITHER_BARRIER,
)
def moves(mutation: Mutation, smooth: bool) -> Statement:
    """with D = c+ - c, d = v_c1+ - v_c1, w = v - v_c1: -w D + d^2/2 <= V1i(v; c+) - V1i(v; c) <= -w
    D + D d - d^2/2, hence <= -w D + D^2/2; and <= 0 where w d > 0, |d| <= |w|, with either barrier.

    How much V1 can change because its target moves; a target that comes nearer to the velocity
    lowers it.

    Given: {ANY_TARGETS}; (y - c)^2/2 + f(y) is at least its value at v_c1 and (y - v_c1)^2/2, at
    the other target's v_c1.
    """
    t = symbols("v c c_next u1 u2", "u1 u2")
    v, c, c_next, u1, u2 = t.values()
    form, pull = (smooth_lyapunov, smooth_f) if smooth else (lyapunov, f)
    x, x_next = (
        resolvent(target, SX(1), u1, u2, True) if smooth else minimiser(target, u1, u2)
        for target in (c, c_next)
    )
    w, shift, step = v - x, x_next - x, c_next - c

    def cost(y: SX, target: SX) -> SX:
        return 0.5 * (y - target) ** 2 + pull(y, u1, u2)

    inside = u2 > 0, u1 > u2, [u1 > abs(y) for y in (v, x, x_next)]
    least = cost(x_next, c) >= cost(x, c) + 0.5 * shift**2
    given = inside, least, cost(x, c_next) >= cost(x_next, c_next) + 0.5 * shift**2
    rise = form(v, c_next, u1, u2) - form(v, c, u1, u2)
    nearer = logic_and(w * shift > 0, abs(shift) <= abs(w))
    most = -w * step + 0.5 * mutation(step**2, -(step**2))
    sides = between(-w * step + 0.5 * shift**2, rise, -w * step + step * shift - 0.5 * shift**2)
    goals = sides, most >= rise, when(nearer, rise <= 0)
    return Statement(t | symbols("x x_next"), goals, given, {"x": x, "x_next": x_next})


@claim(
    "transport.level",
    premises=f"transport.share transport.moves convex smooth.convex prox.optimal {COMPILED}",
    each=EITHER_BARRIER,
)
def level(mutation: Mutation, smooth: bool) -> Statement:
    """V1i(v*; c+) <= V1i(v; c) where |v| < v_u1, and |v* - v_c1+| <= |v - v_c1| for every v
    , with either barrier.

    Carrying the velocity along with its target raises neither V1 nor the distance.

    Given: {ANY_TARGETS}; V1i(.; c+) is 0 at v_c1+ and below its chord from there, D1 >= 0, V0 >=
    w^2/2.
    """
    g = Carried(smooth)
    t = g.inputs | g.free
    v, x, x_next, share, after = (t[n] for n in ("v", "x", "x_next", "share", "after"))
    w, shift, left = v - x, x_next - x, g.end - x_next
    within = abs(v) < t.u1
    reaches = logic_and(within, abs(x_next + w) < t.u1)
    on_chord = logic_and(reaches, eq(left, share * w))
    nearer = logic_and(w * shift > 0, abs(shift) <= abs(w))
    stays = logic_and(within, eq(g.end, v))
    held = eq(t.c, t.c_next)
    spent = 0.5 * (share * w) ** 2 + share * t.excess
    given = (
        when(reaches, t.level >= spent),
        when(within, t.level >= 0.5 * w**2),
        when(on_chord, spent >= after),
        when(eq(left, 0), after == 0),
        when(logic_and(stays, logic_or(nearer, held)), t.level >= after),
    )
    lost = mutation(t.level, 0.9 * t.level) >= after
    return g.states((when(within, lost), w**2 >= left**2), given)


@claim("transport.inside", premises="transport.share prox.optimal", each=EITHER_BARRIER)
def stays_inside(mutation: Mutation, smooth: bool) -> Statement:
    """|v| <= v_u1 implies |v*| <= v_u1, |v| < v_u1 implies |v*| < v_u1, and c+ = c implies v* = v
    , with either barrier.

    Nothing inside the limit is carried out of it; a target that is held carries nothing.

    Given: {ANY_TARGETS}.
    """
    g = Carried(smooth)
    t = g.inputs
    u1, size = t.u1, abs(g.end)
    less = if_else(abs(t.v) < u1, u1, 1 + size) > size
    goals = mutation(u1, t.u2) >= size, less, when(eq(t.c, t.c_next), g.end == t.v)
    return g.states(goals, (u1 >= abs(t.v),))


@claim(
    "transport.plain",
    premises=f"{COMPILED} prox.optimal",
    each=EITHER_BARRIER,
)
def plain(mutation: Mutation, smooth: bool) -> Statement:
    """|v|, |c|, |c+|, |v + c+ - c| <= v_u2 imply v* = v + c+ - c, with either barrier.

    Away from the limits the velocity is carried all the way.

    Given: 0 < v_u2 < v_u1; v_c1 = c, v_c1+ = c+, V0 = w^2/2, D1 = 0 there.
    """
    g = Carried(smooth)
    t = g.inputs
    free = Symbols({name: g.free[name] for name in ("x", "x_next", "level", "excess")})
    v, c, c_next, u1, u2 = t.values()
    ahead = v + c_next - c
    inside = u2 > 0, u1 > u2, [u2 >= abs(y) for y in (v, c, c_next, ahead)]
    values = free.level == 0.5 * (v - c) ** 2, free.excess == 0
    given = inside, free.x == c, free.x_next == c_next, values
    cuts = {name: g.cuts[name] for name in free}
    return Statement(t | free, g.end == mutation * ahead, given, cuts)


@claim(
    "transport.root",
    premises="transport.moves eq81",
)
def root(mutation: Mutation) -> Statement:
    """S(v; c+) <= S(v; c) + |c+ - c|, S = sqrt(2 V1i).

    In units of velocity, V1 rises by no more than the way of its target.

    Given: S, S+ >= 0, w^2 <= 2 V1i.
    """
    t = symbols("before after S S_next w step")
    before, after, S, S_next, w, step = t.values()
    roots = equal(S**2, 2 * before), S_next**2 == 2 * after
    moves = before - w * step + 0.5 * step**2 >= after
    given = nonnegative(S, S_next), roots, 2 * before >= w**2, moves
    most = S + mutation(1, 0.9) * abs(step)
    return Statement(t, most >= S_next, given)
