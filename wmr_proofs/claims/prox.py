"""The sampled-data law: the barrier's proximal map, and its step's effect on V1, target, limit.

About the map: the closed form equals it, and it is nonexpansive.  The step is v+ = X_(1-E)(E v* +
(1-E) c+), on the graph of `prox_step`.  Proximal maps, the carried velocity v* and values of V1 are
free numbers with the properties that other entries prove; a statement without any of the graphs is
a LEMMA.

First the level transport: V1 and |w| do not rise when a velocity is transported with its target.
"""

from casadi import SX, eq, fmin, if_else, logic_and, logic_or

from wmr_ctrl.control.barrier.proximal import LARGEST, level_share, resolvent, root, transported
from wmr_ctrl.control.barrier.stable import smooth_barrier, stable_barrier
from wmr_ctrl.control.laws.prox import mixture, prox_step
from wmr_proofs.claim import Claims, Mutation
from wmr_proofs.methods.spec import Z3
from wmr_proofs.paper_barrier import f, lyapunov, minimiser
from wmr_proofs.paper_functions import smooth_f, smooth_lyapunov
from wmr_proofs.statement import (
    AT_LEAST,
    Relation,
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
        excess = form(t.c_next, if_else(abs(ahead) < t.u1, ahead, 0), *limits).D
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
        known = t.u2 > 0, u1 > t.u2, inside, when(eq(t.c, t.c_next), t.x == t.x_next), share >= 0
        return Statement(t, goals, (known, share <= 1, given), self.cuts)


transport_claim = Claims()


@transport_claim("transport.share", premises="eq81")
def transport_share(mutation: Mutation) -> Statement:
    """0 <= theta <= 1 and theta^2 w^2/2 + theta D1 <= V0.

    The transport goes only as far as V1 allows.

    Given: V0 >= w^2/2, D1 >= 0, any w.
    """
    t = symbols("w level excess")
    w, level, excess = t.values()
    theta = level_share(w, level, excess)
    spent = 0.5 * (theta * w) ** 2 + theta * excess
    given = level >= 0.5 * w**2, excess >= 0
    return Statement(t, (between(0, theta, 1), mutation(level, 0.9 * level) >= spent), given)


@transport_claim(
    "transport.moves", premises="convex smooth.convex eq81 prox.optimal", each=EITHER_BARRIER
)
def moves(mutation: Mutation, smooth: bool) -> Statement:
    """with D = c+ - c, d = v_c1+ - v_c1, w = v - v_c1: -w D + d^2/2 <= V1i(v; c+) - V1i(v; c) <= -w
    D + D d - d^2/2, hence <= -w D + D^2/2; and <= 0 where w d > 0, |d| <= |w|, with either barrier.

    Largest change of V1 due to its target's motion; a target that approaches the velocity lowers
    V1.

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
    most = -w * step + 0.5 * mutation(step**2, -(step**2))
    sides = between(-w * step + 0.5 * shift**2, rise, -w * step + step * shift - 0.5 * shift**2)
    goals = sides, most >= rise, when(logic_and(w * shift > 0, abs(shift) <= abs(w)), rise <= 0)
    return Statement(t | symbols("x x_next"), goals, given, {"x": x, "x_next": x_next})


@transport_claim(
    "transport.level",
    premises=f"transport.share transport.moves convex smooth.convex prox.optimal {COMPILED}",
    each=EITHER_BARRIER,
)
def level(mutation: Mutation, smooth: bool) -> Statement:
    """V1i(v*; c+) <= V1i(v; c) where |v| < v_u1, and |v* - v_c1+| <= |v - v_c1| for every v
    , with either barrier.

    Transporting the velocity with its target raises neither V1 nor the distance.

    Given: {ANY_TARGETS}; V1i(.; c+) is 0 at v_c1+ and below its chord from there, D1 >= 0, V0 >=
    w^2/2.
    """
    g = Carried(smooth)
    t = g.inputs | g.free
    v, x, x_next, share, after = (t[n] for n in ("v", "x", "x_next", "share", "after"))
    w, shift, left = v - x, x_next - x, g.end - x_next
    within = abs(v) < t.u1
    reaches = logic_and(within, abs(x_next + w) < t.u1)
    nearer = logic_and(w * shift > 0, abs(shift) <= abs(w))
    held = eq(t.c, t.c_next)
    spent = 0.5 * (share * w) ** 2 + share * t.excess
    given = (
        when(reaches, t.level >= spent),
        when(within, t.level >= 0.5 * w**2),
        when(logic_and(reaches, eq(left, share * w)), spent >= after),
        when(eq(left, 0), after == 0),
        when(logic_and(logic_and(within, eq(g.end, v)), logic_or(nearer, held)), t.level >= after),
    )
    lost = mutation(t.level, 0.9 * t.level) >= after
    return g.states((when(within, lost), w**2 >= left**2), given)


@transport_claim("transport.inside", premises="transport.share prox.optimal", each=EITHER_BARRIER)
def stays_inside(mutation: Mutation, smooth: bool) -> Statement:
    """|v| <= v_u1 implies |v*| <= v_u1, |v| < v_u1 implies |v*| < v_u1, and c+ = c implies v* = v
    , with either barrier.

    No velocity inside the limit is transported out of it; a constant target moves nothing.

    Given: {ANY_TARGETS}.
    """
    g = Carried(smooth)
    t = g.inputs
    u1, size = t.u1, abs(g.end)
    less = if_else(abs(t.v) < u1, u1, 1 + size) > size
    goals = mutation(u1, t.u2) >= size, less, when(eq(t.c, t.c_next), g.end == t.v)
    return g.states(goals, (u1 >= abs(t.v),))


@transport_claim("transport.plain", premises=f"{COMPILED} prox.optimal", each=EITHER_BARRIER)
def plain(mutation: Mutation, smooth: bool) -> Statement:
    """|v|, |c|, |c+|, |v + c+ - c| <= v_u2 imply v* = v + c+ - c, with either barrier.

    Away from the limits the velocity moves by the same amount as the target.

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


@transport_claim("transport.root", premises="transport.moves eq81")
def root_moves(mutation: Mutation) -> Statement:
    """S(v; c+) <= S(v; c) + |c+ - c|, S = sqrt(2 V1i).

    In units of velocity, V1 rises by no more than the distance that its target moves.

    Given: S, S+ >= 0, w^2 <= 2 V1i.
    """
    t = symbols("before after S S_next w step")
    before, after, S, S_next, w, step = t.values()
    roots = equal(S**2, 2 * before), S_next**2 == 2 * after
    moves = before - w * step + 0.5 * step**2 >= after
    given = nonnegative(S, S_next), roots, 2 * before >= w**2, moves
    most = S + mutation(1, 0.9) * abs(step)
    return Statement(t, most >= S_next, given)


def _limits(t: Symbols) -> Relations:
    return t.u2 > 0, t.u1 > t.u2


def _target(t: Symbols) -> Relations:
    return _limits(t), t.k > 0, t.c < 1e100, t.c > -1e100


def _slope(size: SX, t: Symbols, smooth: bool) -> SX:
    """f'(|x|) beyond u2."""
    tangent = 1 / (t.u1 - t.u2) if smooth else 0
    return 1 / (t.u1 - size) - tangent


map_claim = Claims()


@map_claim("prox.optimal", (14, 15, 18), each=EITHER_BARRIER)
def optimal(mutation: Mutation, smooth: bool) -> Statement:
    """c - X_k(c) is in k df(X_k(c)) and |X_k(c)| < v_u1, with either barrier.

    The closed form is the nearest velocity inside the limit.

    Given: {ANY_TARGET}.
    """
    t = symbols("c k u1 u2", "k u1 u2")
    c, k, u1, u2 = t.values()
    x = resolvent(c, k, u1, u2, smooth)
    size, s = abs(x), if_else(c >= 0, 1, -1)
    rest = s * (c - mutation * x)
    beyond = (rest - k * _slope(size, t, smooth)) * (u1 - size)
    jump = SX(0) if smooth else k / (u1 - u2)
    miss = if_else(size > u2, beyond, if_else(size < u2, rest, fmin(jump - rest, 0)))
    return Statement(t, (miss == 0, nonnegative(rest, s * x), u1 > size), _target(t))


@map_claim("prox.monotone", (14, 15), each=EITHER_BARRIER)
def monotone(mutation: Mutation, smooth: bool) -> Statement:
    """(f'(x1) - f'(x2)) (x1 - x2) >= 0, the corner's slopes included, with either barrier.

    The barrier is convex.

    Given: every 0 < v_u2 < v_u1, |x| < v_u1.
    """
    t = symbols("x1 x2 k1 k2 u1 u2", "u1 u2")
    x1, x2, k1, k2, u1, u2 = t.values()
    slopes = []
    for x, kink in ((x1, k1), (x2, k2)):
        size, s = abs(x), if_else(x >= 0, 1, -1)
        jump = SX(0) if smooth else kink
        slopes.append(s * if_else(size > u2, _slope(size, t, smooth), if_else(size < u2, 0, jump)))
    rises = mutation * (slopes[0] - slopes[1]) * (x1 - x2)
    sizes = [u1 > way * t[x] for way in (1, -1) for x in ("x1", "x2")]
    kinks = [part for k in (k1, k2) for part in (k >= 0, k * (u1 - u2) <= 1)]
    return Statement(t, rises >= 0, (_limits(t), sizes, kinks))


@map_claim("prox.not-expansive", premises="prox.optimal prox.monotone")
def not_expansive(mutation: Mutation) -> Statement:
    """|X_k(c1) - X_k(c2)| <= |c1 - c2|.

    Nearby targets have nearby results.

    Given: k > 0; x + k a = c with monotone a.
    """
    t = symbols("x1 x2 a1 a2 k")
    dx, da = t.x1 - t.x2, t.a1 - t.a2
    dc = dx + t.k * da
    return Statement(t, dc * dc >= mutation(1, 1.01) * dx * dx, (t.k > 0, dx * da >= 0))


@map_claim("prox.root")
def prox_root(mutation: Mutation) -> Statement:
    """the compiled d is the positive root of d (d + t) = k.

    Distance of a proximal map's result from the limit.

    Given: k > 0, any t.
    """
    t = symbols("t k")
    d = root(t.t, t.k)
    return Statement(t, (d > 0, d * (d + mutation * t.t) == t.k), t.k > 0)


@map_claim("prox.short", premises="prox.root", each=EITHER_BARRIER)
def short(mutation: Mutation, smooth: bool) -> Statement:
    """|c| <= C implies |X_k(c)| <= v_u1 - m for each 0 < m <= v_u1 - v_u2 with m (m + C -
    v_u1 + b) <= k, b = 0 with the paper's barrier and k/(v_u1 - v_u2) with the smooth one.

    The nearer the target, the farther below the limit its nearest velocity.

    Given: every 0 < v_u2 < v_u1 <= C, k > 0, |c| < 1e100.
    """
    t = symbols("c k u1 u2 C m d", "k u1 u2 C m")
    c, k, u1, u2, most, m, d = t.values()
    x = resolvent(c, k, u1, u2, smooth)
    bent = k / (u1 - u2) if smooth else 0
    beyond = fmin(if_else(c >= 0, 1, -1) * c, LARGEST) - u1 + bent
    margin = mutation(k, 1.5 * k) >= m * (m + most - u1 + bent)
    sizes = most >= abs(c), most >= u1, d > 0, d * (d + beyond) == k
    given = _target(t), m > 0, u1 - u2 >= m, margin, sizes
    return Statement(t, (u1 - m >= x, x >= m - u1), given, {"d": root(beyond, k)})


NONE = Symbols()


class Step:
    """`prox_step` with v*, v+ and the proximal maps at c_m and c+ as free numbers.

    ``start`` is v* and ``end`` v+ as the law computes them, ``argument`` that of the last map.
    """

    def __init__(self, smooth: bool) -> None:
        self.smooth = smooth
        self.inputs = t = symbols("v c followed target E u1 u2", "E u1 u2")
        self.free = symbols("carried end x_followed x_target")
        self.limits, self.shares, way = (t.u1, t.u2), (t.E, 1 - t.E), (t.c, t.followed, t.target)
        self.start = transported(t.v, t.c, t.followed, self.limits, smooth)
        self.argument = mixture(self.start, t.target, self.shares)
        self.end = prox_step(t.v, way, self.shares, self.limits, smooth)

    def states(
        self, goals: Relations, given: Relations, names: tuple[str, ...], more: Symbols = NONE
    ) -> Statement:
        """Statement for 0 < u2 < u1 and 0 < E < 1 on the graph of `prox_step`, cut at ``names``."""
        t, one = self.inputs, SX(1)
        maps = {
            "end": (self.argument, self.shares[1]), "x_followed": (t.followed, one),
            "x_target": (t.target, one),
        }  # fmt: skip
        inner = {name: resolvent(*of, *self.limits, self.smooth) for name, of in maps.items()}
        inner["carried"] = self.start
        cuts = {name: inner[name] for name in names}
        plain = t.u2 > 0, t.u1 > t.u2, t.E > 0, t.E < 1
        return Statement(t | self.free | more, goals, (plain, given), cuts)


claim = Claims(given="0 < v_u2 < v_u1, 0 < E < 1")


@claim("prox.inside", each=EITHER_BARRIER)
def inside(mutation: Mutation, smooth: bool) -> Statement:
    """|v+| < v_u1 for every v, c, c_m, c+, over the real numbers, with either barrier.

    The law never aims beyond the limit, wherever the robot is. In doubles v+ can round to v_u1
    itself (from |c+| of about 1e17 on).
    """
    s = Step(smooth)
    limit = mutation(s.inputs.u1, s.inputs.u2)
    return s.states((limit > s.end, s.end > -limit), (), ("carried",))


@claim(
    "prox.contracts",
    premises="prox.optimal prox.monotone prox.not-expansive transport.level",
    each=EITHER_BARRIER,
)
def contracts(mutation: Mutation, smooth: bool) -> Statement:
    """|w+| <= E (|w| + |c+ - c_m|), w = v - v_c1 before (at c) and after (at c+), with either
    barrier.

    The distance to a target that moves shrinks by E in a sample, however long that is, except for
    the part of the target's motion that is not transported.

    Given: 0 < v_u2 < v_u1, 0 < E < 1; every v, c, c_m, c+ below 1e100 in size, v_u1 as well.
    """
    s, t = Step(smooth), symbols("w")
    x_target, x_followed, carried = (s.free[n] for n in ("x_target", "x_followed", "carried"))
    E, target, followed = (s.inputs[n] for n in ("E", "target", "followed"))
    pull, rest = s.argument - s.free.end, (1 - E) * (target - x_target)
    way, monotone = abs(target - followed), (s.free.end - x_target) * (pull - rest) >= 0
    given = monotone, abs(t.w) >= abs(carried - x_followed), way >= abs(x_target - x_followed)
    most = E * (abs(t.w) + mutation(way, 0.9 * way))
    names = ("carried", "end", "x_followed", "x_target")
    return s.states((most >= abs(s.end - x_target),), given, names, t)


@claim(
    "prox.decay", premises="prox.optimal convex smooth.convex transport.inside", each=EITHER_BARRIER
)
def decay(mutation: Mutation, smooth: bool) -> Statement:
    """V1i(v+; c+) <= E^2 V1i(v*; c+), with either barrier.

    From the transported velocity V1 falls by exp(-rho T) in a sample, for any period and targets.

    Given: 0 < v_u2 < v_u1, 0 < E < 1; v_u1, |c+| < 1e100; |v*| < v_u1; V1i above its tangent at v+,
    at v* and v_c1+.
    """
    s, t = Step(smooth), symbols("mid after A")
    mid, after, A = t.values()
    E = s.inputs.E
    end, carried = s.free.end, s.free.carried
    back = s.free.x_target - end
    # optimality of X_(1-E): (argument - v+)/(1 - E) is a slope of f at v+; A = v+ - c+ + slope
    optimal = (1 - E) * (A - end + s.inputs.target) == s.argument - end
    above_start = mid >= after + A * (carried - end) + 0.5 * (carried - end) ** 2
    given = optimal, above_start, after + A * back + 0.5 * back**2 <= 0, after >= 0
    goals = mutation(E**2, (0.9 * E) ** 2) * mid >= after, s.end == end
    return s.states(goals, given, ("carried", "end", "x_target"), t)


@claim("prox.linear", premises="transport.plain", each=EITHER_BARRIER)
def linear(mutation: Mutation, smooth: bool) -> Statement:
    """v+ = E v* + (1-E) c+ where that is at most v_u2 in size, with either barrier.

    Away from the limits the law reduces the distance to its target by the factor E in a sample.

    Given: 0 < v_u2 < v_u1, v_u2 < 1e100, 0 < E < 1.
    """
    s = Step(smooth)
    E, u2, target = (s.inputs[name] for name in ("E", "u2", "target"))
    plain = E * s.free.carried + (1 - E) * target
    given = u2 >= plain, u2 >= -plain, u2 < 1e100
    return s.states((s.end == mutation * plain,), given, ("carried",))


@claim("prox.margin", premises="transport.inside prox.short", each=EITHER_BARRIER)
def margin(mutation: Mutation, smooth: bool) -> Statement:
    """|v*| <= v_u1 and |c+| <= C imply |v+| <= v_u1 - m for each 0 < m <= v_u1 - v_u2 with m (m +
    (1-E) (C - v_u1 + b)) <= 1 - E, b = 0 with the paper's barrier and 1/(v_u1 - v_u2) with the
    smooth one.

    Distance from the limit that the law aims at, which is available for pushes.

    Given: 0 < v_u2 < v_u1 <= C < 1e99, 0 < E < 1.
    """
    # What X_(1-E) is taken of is bounded here; the rest is `resolvent`'s.
    s, t = Step(smooth), symbols("C m", "C m")
    u1, C = s.limits[0], t.C
    most = s.inputs.E * u1 + s.shares[1] * mutation(C, 0.9 * C)
    short = when(abs(s.argument) <= most, u1 - t.m >= abs(s.free.end))
    given = u1 >= abs(s.free.carried), abs(s.inputs.target) <= C, short
    return s.states((u1 - t.m >= abs(s.end),), given, ("carried", "end"), t)


@claim("prox.rises", by=Z3(), premises="prox.decay transport.level transport.root")
def rises(mutation: Mutation) -> Statement:
    """S(v+; c+) <= E (S(v; c) + |c+ - c_m|), S = sqrt(2 V1i); c_m = c+: V1i(v+; c+) <= E^2 V1i(v;
    c).

    What remains of V1 after a sample, with the model exact, for every period, every motion of the
    target and every |v| < v_u1: level transport keeps the decay of V1; two-part transport adds the
    distance that it does not transport.

    Given: 0 < E < 1; V1i(v*; c_m) <= V1i(v; c), S(v*; c+) <= S(v*; c_m) + |c+ - c_m|, V1i(v+; c+)
    <= E^2 V1i(v*; c+).
    """
    t = symbols("before carried mid after S S_next way E S_mid S_carried")
    E, roots = t.E, (t.S, t.S_next, t.S_mid, t.S_carried)
    values = t.before, t.after, t.mid, t.carried
    squares = [root**2 == 2 * value for root, value in zip(roots, values, strict=True)]
    moved = t.before >= t.carried, t.S_carried + t.way >= t.S_mid
    given = squares, nonnegative(*roots), E > 0, E < 1, t.way >= 0, moved, E**2 * t.mid >= t.after
    most = E * (t.S + mutation(1, 0.9) * t.way)
    level = Relation(if_else(t.way > 0, 0, E**2 * t.before - t.after), AT_LEAST)
    return Statement(t, (most >= t.S_next, level), given)
