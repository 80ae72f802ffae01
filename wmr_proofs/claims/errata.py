"""Errata of the paper beyond single equations, each with an exact point.  Results of ours: a strict
Lyapunov function near the path, and a set that the saturated robot never leaves.
"""

from fractions import Fraction

from casadi import SX, cos, fmax, fmin, if_else, sin, sumsqr, vertcat, vertsplit

from wmr_ctrl.world.model.kinematics import error_rate
from wmr_proofs import paper_barrier as barrier
from wmr_proofs import paper_functions as analysis
from wmr_proofs.claim import CORRECTED, OURS, PRINTED, Claims, Mutation
from wmr_proofs.methods.spec import Z3, Ball, Refute, Ring
from wmr_proofs.regions import POSITIVE, Case, at
from wmr_proofs.statement import (
    Relations,
    Statement,
    column,
    nonnegative,
    positive,
    stacked,
    symbols,
)

from .common import barrier_axis
from .theorem1 import PAPER, Tracking

BACKWARDS = ({**at(e1=0, e2=0, **PAPER), "e3": "1 pi"},)
TURNED = (at(e1=0, e2=0, e3="11/10", k2=5, r="1/2"),)
EDGE = ({**at(e1=1, e2=0, e3=0, l=257, eps0="1/2", k1=10, k2=5, k3=4)},)
claim = Claims(form=PRINTED)


@claim("thm1.global", (7, 39), by=Refute(BACKWARDS))
def only_rest(_: Mutation) -> Statement:
    """(Theorem 1) e converges to 0 from everywhere: e = 0 is the only equilibrium of the error
    under v = v_c0.

    A robot exactly on the path but facing backwards, e = (0, 0, pi), has e' = 0: it drives
    backwards along the path, and no term of the law turns it. Convergence is almost global at best.

    Given: v1d > 0.
    """
    t = Tracking()
    rate = error_rate(t.e, t.target, t.v_d)
    return t.states(sumsqr(rate) > 0, given=positive(sumsqr(t.e), t.v_d[0]))


@claim("eq61.ball", (39, 61), by=Refute(TURNED))
def ball(_: Mutation) -> Statement:
    """a small V2 means a small ball: V2 <= r^2/2 implies |e| <= r, as the definition of Omega_1 and
    Omega_3 by a radius needs.

    V2 counts the angle less than the distance (by 1/k2), so a set where V2 stops growing is no
    ball: with r = 0.5 the angle may still be 1.1 rad.

    Given: r > 0, k2 = 5.
    """
    t = Tracking("r")
    given = 0.5 * t.r**2 >= t.V2, t.r > 0
    return Statement(t, t.r**2 >= sumsqr(t.e), given)


@claim("eq61.omega", (61,), by=Refute(EDGE))
def omega(_: Mutation) -> Statement:
    """inside the ball Omega_1 V2 is at most its value on the ball's edge, so that no motion that
    lowers V2 leaves the ball.

    An error can leave the ball while V2 falls: the stated sets are not shown to hold the robot.

    Given: radius of Omega_1, l > 5.
    """
    t = Tracking("eps0 l")
    radius = analysis.ball_radius(t.eps0, t.l, t.k)
    given = radius**2 >= sumsqr(t.e), t.l > 5, t.eps0 > 0
    return t.states(analysis.position_lyapunov(vertcat(0, 0, radius), t.k[1]) >= t.V2, given=given)


@claim(
    "eq09.pseudo-inverse",
    (9,),
    by=Refute((at(v="3/10", c="3/10", u1=1, u2="4/5", rho=15, cdot=1),)),
)
def stays_on_target(_: Mutation) -> Statement:
    """A^-1 := 0 where A = 0 keeps a robot on its target velocity: the command there is v_c0'.

    On target the printed law commands acceleration 0 instead of the target's.  A robot that starts
    with v = v_c0 then falls behind; the code takes the limit v_c0' instead.

    Given: v = v_c0, |v| < v_u2.
    """
    a, v, c, u1, u2 = barrier_axis()
    t = a | symbols("rho cdot")
    given = a.inside, v == c, u2 > abs(v), t.rho > 0
    return Statement(t, analysis.printed_command(t.rho, v, c, t.cdot, u1, u2) == t.cdot, given)


@claim("eq30.vector", (30,), by=Refute((at(V1=0, V2=1, rho1=15, rho2="288/5", rho=15),)))
def one_rate(_: Mutation) -> Statement:
    """V1' = -rho V1 with the two gains of Section V.

    With one gain per axis the sum does not decay at one rate.

    Given: rho_1 = 15, rho_2 = 57.6, rho = rho_1.
    """
    t = column("V", 2) | column("rho", 2) | symbols("rho")
    total = t.V1 + t.V2
    rate = -t.rho1 * t.V1 - t.rho2 * t.V2
    given = t.rho1 == 15, 5 * t.rho2 == 288, nonnegative(t.V1, t.V2)
    return Statement(t, rate == -t.rho * total, (given, t.rho == t.rho1))


@claim("eq30.slower", (30,), form=CORRECTED, premises="eq30.law eq30.law-angular")
def slower_rate(mutation: Mutation) -> Statement:
    """V1' <= -min(rho_1, rho_2) V1.

    The slower axis sets the pace.

    Given: V1i >= 0, rho_i >= 0, V1i' = -rho_i V1i.
    """
    t = column("V", 2) | column("rho", 2)
    least = mutation(fmin(t.rho1, t.rho2), fmax(t.rho1, t.rho2))
    rate = -t.rho1 * t.V1 - t.rho2 * t.V2
    return Statement(t, -least * (t.V1 + t.V2) >= rate, tuple(t[name] >= 0 for name in t))


@claim("eq86.forgetting", (86,), form=OURS)
def forgetting_binds(mutation: Mutation) -> Statement:
    """with sigma Gamma = (2, 0.08) 1/s rho2 stays below 0.081 1/s whatever rho1 is (the text says
    that rho1 raises it).

    The time constant of the paper's guarantee is 12.5 s and no gain of the velocity loop shortens
    it.

    Given: M1ii > 0.
    """
    t = column("rho", 2) | column("M", 2)
    rate = analysis.decay_rate(stacked(t, "rho", 2), stacked(t, "M", 2), SX([1, 1]), SX([2, 0.08]))
    return Statement(t, mutation(0.081, 0.07) >= rate, positive(t.M1, t.M2))


SETTING = (("v1d", 5, 1), ("v2d", 10, 1), ("k1", 1, 10), ("k2", 1, 5), ("k3", 1, 4), ("eps", 50, 1))
"""Numbers b/a of the paper and of eps, by name, as a and b."""


class Strict(Tracking):
    """Tracking with the weight eps of the strict Lyapunov function W = V2 + eps e2 sin e3.

    ``W_rate`` is W' for v = v_c0, ``size`` is e1^2 + e2^2 + sin^2 e3.
    """

    def __init__(self) -> None:
        super().__init__("eps value rate")
        self.W = analysis.strict_lyapunov(self.e, self.k[1], self.eps)
        self.W_rate = analysis.strict_rate(self.e, self.v_d, self.k, self.eps)
        self.size = self.e[0] ** 2 + self.e[1] ** 2 + sin(self.e[2]) ** 2

    @property
    def near(self) -> Relations:
        """Paper gains, v1d = 0.2, v2d = 0.1, eps = 1/50; |e1|, |e2| <= 1, cos e3 >= 1/4."""
        inside = self.e1**2 <= 1, self.e2**2 <= 1
        return [a * self[name] == b for name, a, b in SETTING], inside, 4 * cos(self.e3) >= 1


def _undisturbed(t: Tracking) -> SX:
    """p = (v1d cos e3, v2d + k2 v1d e2): v_c0 without its corrections y = (k1 e1, k3 sin e3)."""
    return vertcat(t.v_d[0] * cos(t.e[2]), t.v_d[1] + t.k[1] * t.v_d[0] * t.e[1])


def _limited(t: Tracking) -> SX:
    """v_c1 of both axes."""
    return vertcat(*(barrier.minimiser(t.target[i], t[f"u1{i + 1}"], t[f"u2{i + 1}"])
                        for i in (0, 1)))  # fmt: skip


LIMITS = at(u11=1, u12="3/2", u21="4/5", u22="13/10")
FAST = (at(e1=1, e2=0, e3=0, v1d="9/10", v2d=0, k1=10, k2=5, k3=4, **LIMITS),)
SIDEWAYS = (at(e1=0, e2=3, e3="1/2", **PAPER, **LIMITS),)
RATES = tuple(at(e1=1, e2=0, e3=0, value=1, rate=rate) for rate in ("-1/2000", "-1/500"))
START = {
    name: (Fraction(low), Fraction(high))
    for name, low, high in (
        ("e1", "0.70452", "0.70454"), ("e2", "-0.06032", "-0.06030"),
        ("e3", "-0.87081", "-0.87079"), ("k2", "5", "5"),
    )
}  # fmt: skip

TOP = at(e1=0, e2="7/10", e3=0, u21="4/5", u22="13/10", level="2/5", **PAPER)
strict_claim = Claims()


@strict_claim("strict.falls", (31,))
def falls(mutation: Mutation) -> Statement:
    """W = V2 + eps e2 sin e3 has W' <= -(e1^2 + e2^2 + sin^2 e3)/1000.

    Unlike V2, this function falls in every direction, so disturbances can be weighed against it.

    Given: {NEAR_PATH}.
    """
    t = Strict()
    return t.states(-mutation(1000, 10) * t.W_rate >= t.size, given=t.near)


@strict_claim("strict.bounds", (31,))
def between(mutation: Mutation) -> Statement:
    """(e1^2 + e2^2 + sin^2 e3)/20 <= W <= e1^2 + e2^2 + sin^2 e3.

    W measures the distance from the path.

    Given: {NEAR_PATH}.
    """
    t = Strict()
    return t.states(mutation(20, 2) * t.W >= t.size, t.size >= t.W, given=t.near)


@strict_claim("strict.rate", (31,), by=Z3(points=RATES), premises="strict.falls strict.bounds")
def exponential(mutation: Mutation) -> Statement:
    """W' <= -W/1000: the error decays exponentially.

    The robot returns to the path exponentially, at a guaranteed (if small) rate; the paper only
    says that it converges.

    Given: {NEAR_PATH}.
    """
    # W' <= -W/1000 from the two claims before it, W and W' being whatever they are.
    t = Strict()
    given = -mutation(1000, 2000) * t.W_rate >= t.size, t.size >= t.W
    return Statement(t, 1000 * t.W_rate <= -t.W, given, {"value": t.W, "rate": t.W_rate})


@strict_claim("strict.region", (31,))
def stays(mutation: Mutation) -> Statement:
    """W < 1/20 implies |e1|, |e2| < 1 and cos e3 > 1/4.

    Inside this set the rate holds.

    Given: k2 = 5, eps = 1/50.
    """
    t = Strict()
    given = t.k2 == 5, 50 * t.eps == 1, mutation > 20 * mutation * t.W
    goals = t.e1**2 < 1, t.e2**2 < 1, 4 * cos(t.e3) > 1
    return t.states(goals, given=given)


@strict_claim("level.pull", (7, 18))
def pull(mutation: Mutation) -> Statement:
    """(sat(p + y) - p) y >= 0 for |p| <= v_u2, where sat maps v_c0 to v_c1.

    The limit weakens a correction but never reverses it.

    Given: every 0 < v_u2 < v_u1.
    """
    a, _, _, u1, u2 = barrier_axis()
    t = a | symbols("p y")
    moved = barrier.minimiser(t.p + t.y, u1, u2) - mutation * t.p
    given = a.inside, u2 >= t.p, t.p >= -u2
    return Statement(t, moved * t.y >= 0, given)


@strict_claim("level.rate", (31, 36), by=Ring((Case("any", declared={"k2": POSITIVE}),)))
def saturated_rate(mutation: Mutation) -> Statement:
    """for any v: V2' = -(v1 - p1) e1 - (v2 - p2) sin e3/k2, p1 = v1d cos e3, p2 = v2d +
    k2 v1d e2.

    Given: k2 > 0.
    """
    t = Tracking("x1 x2")
    e, x, p = t.e, vertcat(t.x1, t.x2), _undisturbed(t)
    written = -(x[0] - p[0]) * e[0] - mutation * (x[1] - p[1]) * sin(e[2]) / t.k[1]
    return t.states(t.falls(x) == written)


@strict_claim("level.argument", (7,), by=Ring())
def argument(mutation: Mutation) -> Statement:
    """v_c0 = p + (k1 e1, k3 sin e3).

    Given: any.
    """
    # The corrections have the signs of e1 and sin e3.
    t = Tracking()
    target, p = t.target, _undisturbed(t)
    turn = p[1] + mutation * t.k[2] * sin(t.e[2])
    return t.states(target[0] == p[0] + t.k[0] * t.e[0], target[1] == turn)


@strict_claim("level.inside", (31,), by=Z3(points=(TOP,)))
def level_set(mutation: Mutation) -> Statement:
    """V2 < min(2/k2, ((v_u22 - |v2d|)/(k2 v1d))^2/2) gives |p1| <= v_u21, |p2| <= v_u22, cos e3 >
    -1.

    Given: 0 < v1d <= v_u21, |v2d| < v_u22, k2 > 0.
    """
    t = Tracking("u21 u22 level")
    k2, v_d, level, p = t.k[1], t.v_d, t.level, _undisturbed(t)
    room = t.u22 - abs(v_d[1])
    low = k2 * level <= 2, room**2 >= 2 * mutation * (k2 * v_d[0]) ** 2 * level
    given = positive(k2, v_d[0]), t.u21 >= v_d[0], room > 0, low, level > t.V2
    kept = (t[f"u2{i + 1}"] >= abs(p[i]) for i in (0, 1))
    return t.states(*kept, cos(t.e[2]) > -1, given=given)


@strict_claim(
    "level.invariant",
    (31,),
    by=Z3(points=(at(e1=1, e2=0, e3=0, k1=1, k2=1, k3=1, v1d=1, v2d=0, x1=2, x2=0),)),
    premises="level.pull level.rate level.argument level.inside lemma.integration",
)
def level_invariant(mutation: Mutation) -> Statement:
    """with v = v_c1 (velocities at their limited targets) V2' <= 0 on the set {V2 < min(2/k2,
    ((v_u22 - |v2d|)/(k2 v1d))^2/2), |e3| < pi}, and V2 >= 2/k2 where |e3| = pi.

    No motion leaves the set (lemma.integration). The paper proves tracking only while no limit is
    touched, and never shows that the robot gets
    there. This set, V2 < 0.4 with the paper's numbers, holds the paper's own start, which is
    saturated.

    Given: k2 > 0; level.pull with y = k1 e1 and y = k3 sin e3, where level.inside has |p1| <=
    v_u21, |p2| <= v_u22; k1, k3 > 0.
    """
    t = Tracking("x1 x2")
    e, k, x, p = t.e, t.k, vertcat(t.x1, t.x2), _undisturbed(t)
    pulls = e[0], sin(e[2])
    given = positive(*vertsplit(k)), [(x[i] - p[i]) * k[2 * i] * pulls[i] >= 0 for i in (0, 1)]
    behind = if_else(cos(e[2]) <= -1, t.V2 - 2 / k[1], 0)
    return t.states(mutation * t.falls(x) <= 0, behind >= 0, given=given)


@strict_claim("level.start", (31,), by=Ball(box=START))
def paper_level(mutation: Mutation) -> Statement:
    """the paper's start has V2 < 0.33 < 0.4.

    The paper's run starts inside.

    Given: e within 1e-5 of (0.70453, -0.06031, -0.8708), k2 = 5.
    """
    t = Tracking()
    return t.states(mutation(0.33, 0.3) > t.V2)


@strict_claim("level.everywhere", (31,), by=Refute(SIDEWAYS))
def saturated_growth(_: Mutation) -> Statement:
    """V2' <= 0 for v = v_c1 everywhere.

    Outside the set a saturated robot may first move away: 3 m to the side V2 grows.

    Given: every e.
    """
    t = Tracking("u11 u12 u21 u22")
    return t.states(t.falls(_limited(t)) <= 0)


@strict_claim("E7", (7,), form=PRINTED, by=Refute(FAST))
def stuck(_: Mutation) -> Statement:
    """v1d < v_u11 suffices: e = 0 is the only equilibrium.

    With v1d = 0.9 m/s between v_u21 = 0.8 and v_u11 = 1 a robot exactly 1 m behind stays
    there (e' = 0): the hypothesis must be v1d < v_u21 (and |v2d| < v_u22, which the paper does
    not state).

    Given: 0 < v1d < v_u11, cos e3 > 0.
    """
    t = Tracking("u11 u12 u21 u22")
    given = positive(cos(t.e[2]), sumsqr(t.e), t.v_d[0]), t.u11 > t.v_d[0]
    return t.states(sumsqr(error_rate(t.e, _limited(t), t.v_d)) > 0, given=given)
