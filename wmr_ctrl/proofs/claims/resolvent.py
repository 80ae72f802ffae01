"""The proximal map of the barrier: that the closed form is it, and that it never expands."""

import casadi as ca

from wmr_ctrl.barrier.proximal import LARGEST, resolvent, root
from wmr_ctrl.proofs.claim import Claims, Mutation
from wmr_ctrl.proofs.claims.common import BARRIERS
from wmr_ctrl.proofs.methods.spec import Z3
from wmr_ctrl.proofs.statement import Relation, Statement, above, at_least, equal, symbols

ANY = "every 0 < v_u2 < v_u1, k > 0 and |c| < 1e100"


def _limits(t: dict[str, ca.SX]) -> tuple[Relation, ...]:
    return above(t["u2"]), above(t["u1"], t["u2"])


def _target(t: dict[str, ca.SX]) -> tuple[Relation, ...]:
    return (*_limits(t), above(t["k"]), above(ca.SX(1e100), t["c"]), above(t["c"], -1e100))


def _slope(size: ca.SX, t: dict[str, ca.SX], smooth: bool) -> ca.SX:
    """f'(|x|) beyond u2."""
    tangent = 1 / (t["u1"] - t["u2"]) if smooth else 0
    return 1 / (t["u1"] - size) - tangent


claim = Claims(by=Z3(effort=150))


@claim.also(
    "prox.optimal-smooth",
    "the same for the smooth barrier",
    "Also where the barrier has no corner.",
    equations=(),
    smooth=True,
)
@claim("prox.optimal", (14, 15, 18), given=ANY)
def optimal(mutation: Mutation, smooth: bool = False) -> Statement:
    """c - X_k(c) is in k df(X_k(c)) and |X_k(c)| < v_u1.

    The closed form is the nearest velocity inside the limit.
    """
    t = symbols("c k u1 u2", "k u1 u2")
    x = resolvent(t["c"], t["k"], t["u1"], t["u2"], smooth)
    size, s = ca.fabs(x), ca.if_else(t["c"] >= 0, 1, -1)
    rest = s * (t["c"] - mutation * x)
    beyond = (rest - t["k"] * _slope(size, t, smooth)) * (t["u1"] - size)
    jump = ca.SX(0) if smooth else t["k"] / (t["u1"] - t["u2"])
    at_kink = ca.fmin(jump - rest, 0)
    miss = ca.if_else(size > t["u2"], beyond, ca.if_else(size < t["u2"], rest, at_kink))
    inside = above(t["u1"], size)
    return Statement(t, (equal(miss), at_least(rest), at_least(s * x), inside), _target(t))


@claim.also(
    "prox.monotone-smooth",
    "the same for the smooth barrier",
    "So is the smooth one.",
    equations=(),
    smooth=True,
)
@claim("prox.monotone", (14, 15), given="every 0 < v_u2 < v_u1, |x| < v_u1")
def monotone(mutation: Mutation, smooth: bool = False) -> Statement:
    """(f'(x1) - f'(x2)) (x1 - x2) >= 0, the corner's slopes included.

    The barrier is convex.
    """
    t = symbols("x1 x2 k1 k2 u1 u2", "u1 u2")
    slopes = []
    for x, kink in ((t["x1"], t["k1"]), (t["x2"], t["k2"])):
        size, s = ca.fabs(x), ca.if_else(x >= 0, 1, -1)
        jump = ca.SX(0) if smooth else kink
        steep = ca.if_else(
            size > t["u2"], _slope(size, t, smooth), ca.if_else(size < t["u2"], 0, jump)
        )
        slopes.append(s * steep)
    rises = mutation * (slopes[0] - slopes[1]) * (t["x1"] - t["x2"])
    sizes = [above(t["u1"], way * t[x]) for way in (1, -1) for x in ("x1", "x2")]
    kinks = [
        part
        for name in ("k1", "k2")
        for part in (at_least(t[name]), at_least(ca.SX(1), t[name] * (t["u1"] - t["u2"])))
    ]
    return Statement(t, (at_least(rises),), (*_limits(t), *sizes, *kinks))


@claim(
    "prox.not-expansive", given="x + k a = c with monotone a", premises="prox.optimal prox.monotone"
)
def not_expansive(mutation: Mutation) -> Statement:
    """|X_k(c1) - X_k(c2)| <= |c1 - c2|.

    Targets that are near stay near.
    """
    t = symbols("x1 x2 a1 a2 k")
    dx, da = t["x1"] - t["x2"], t["a1"] - t["a2"]
    dc = dx + t["k"] * da
    goal = at_least(dc * dc, mutation(1, 1.01) * dx * dx)
    return Statement(t, (goal,), (above(t["k"]), at_least(dx * da)))


@claim("prox.root", given="k > 0, any t")
def prox_root(mutation: Mutation) -> Statement:
    """the compiled d is the positive root of d (d + t) = k.

    How far below the limit a proximal map ends.
    """
    t = symbols("t k")
    d = root(t["t"], t["k"])
    return Statement(t, (above(d), equal(d * (d + mutation * t["t"]), t["k"])), (above(t["k"]),))


@claim(
    "prox.short{key}",
    given="every 0 < v_u2 < v_u1 <= C, k > 0, |c| < 1e100",
    premises="prox.root",
    over=BARRIERS,
)
def short(mutation: Mutation, smooth: bool) -> Statement:
    """|c| <= C implies |X_k(c)| <= v_u1 - m for each 0 < m <= v_u1 - v_u2 with {bound} <= k
    ({words}).

    The nearer the target, the farther below the limit its nearest velocity.
    """
    t = symbols("c k u1 u2 C m d", "k u1 u2 C m")
    c, k, u1, u2, most, m, d = t.values()
    x = resolvent(c, k, u1, u2, smooth)
    bent = k / (u1 - u2) if smooth else 0
    beyond = ca.fmin(ca.if_else(c >= 0, 1, -1) * c, LARGEST) - u1 + bent
    given = (
        *_target(t), above(m), at_least(u1 - u2, m),
        at_least(mutation(k, 1.5 * k), m * (m + most - u1 + bent)),
        at_least(most, ca.fabs(c)), at_least(most, u1), above(d), equal(d * (d + beyond), k),
    )  # fmt: skip
    return Statement(t, (at_least(u1 - m, x), at_least(x, m - u1)), given, {"d": root(beyond, k)})
