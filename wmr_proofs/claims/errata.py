"""Errata of the paper beyond single equations, each with an exact point."""

from casadi import SX, fmax, fmin, sumsqr, vertcat

from wmr_ctrl.world.model.kinematics import auxiliary_velocity, error_rate
from wmr_proofs import paper_functions as analysis
from wmr_proofs.claim import CORRECTED, OURS, PRINTED, Claims, Mutation
from wmr_proofs.methods.spec import Refute
from wmr_proofs.regions import at
from wmr_proofs.statement import Statement, column, nonnegative, positive, stacked, symbols

from .common import barrier_axis
from .theorem1 import PAPER, Tracking

BACKWARDS = ({**at(e1=0, e2=0, **PAPER), "e3": "1 pi"},)
TURNED = (at(e1=0, e2=0, e3="11/10", k2=5, r="1/2"),)
EDGE = ({**at(e1=1, e2=0, e3=0, l=257, eps0="1/2", k1=10, k2=5, k3=4)},)
ON_TARGET = (at(v="3/10", c="3/10", u1=1, u2="4/5", rho=15, cdot=1),)
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
    rate = error_rate(t.e, auxiliary_velocity(t.e, t.v_d, t.k), t.v_d)
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
    given = 0.5 * t.r**2 >= analysis.position_lyapunov(t.e, t.k[1]), t.r > 0
    return Statement(t, t.r**2 >= sumsqr(t.e), given)


@claim("eq61.omega", (61,), by=Refute(EDGE))
def omega(_: Mutation) -> Statement:
    """inside the ball Omega_1 V2 is at most what it is on the ball's edge, so that no motion which
    lowers V2 leaves the ball.

    An error can leave the ball while V2 falls: the stated sets are not shown to hold the robot.

    Given: radius of Omega_1, l > 5.
    """
    t = Tracking("eps0 l")
    radius = analysis.ball_radius(t.eps0, t.l, t.k)
    given = radius**2 >= sumsqr(t.e), t.l > 5, t.eps0 > 0
    edge = analysis.position_lyapunov(vertcat(0, 0, radius), t.k[1])
    return t.states(edge >= analysis.position_lyapunov(t.e, t.k[1]), given=given)


@claim("eq09.pseudo-inverse", (9,), by=Refute(ON_TARGET))
def stays_on_target(_: Mutation) -> Statement:
    """A^-1 := 0 where A = 0 keeps a robot on its target velocity: the command there is v_c0'.

    On target the printed law commands acceleration 0 instead of the target's. A robot that starts
    with v = v_c0 falls behind at once; the code takes the limit v_c0' instead.

    Given: v = v_c0, |v| < v_u2.
    """
    a, v, c, u1, u2 = barrier_axis()
    t = a | symbols("rho cdot")
    command = analysis.printed_command(t.rho, v, c, t.cdot, u1, u2)
    given = a.inside, v == c, u2 > abs(v), t.rho > 0
    return Statement(t, command == t.cdot, given)


@claim(
    "eq30.vector",
    (30,),
    by=Refute((at(V1=0, V2=1, rho1=15, rho2="288/5", rho=15),)),
)
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


@claim(
    "eq30.slower",
    (30,),
    form=CORRECTED,
    premises="eq30.law eq30.law-angular",
)
def slower_rate(mutation: Mutation) -> Statement:
    """V1' <= -min(rho_1, rho_2) V1.

    The slower axis sets the pace.

    Given: V1i >= 0, rho_i >= 0, V1i' = -rho_i V1i.
    """
    t = column("V", 2) | column("rho", 2)
    least = mutation(fmin(t.rho1, t.rho2), fmax(t.rho1, t.rho2))
    rate = -t.rho1 * t.V1 - t.rho2 * t.V2
    given = tuple(t[name] >= 0 for name in t)
    return Statement(t, -least * (t.V1 + t.V2) >= rate, given)


@claim("eq86.forgetting", (86,), form=OURS)
def forgetting_binds(mutation: Mutation) -> Statement:
    """with sigma Gamma = (2, 0.08) 1/s rho2 stays below 0.081 1/s whatever rho1 is (the text says
    that rho1 raises it).

    The time constant of the paper's guarantee is 12.5 s and no gain of the velocity loop shortens
    it.

    Given: M1ii > 0.
    """
    t = column("rho", 2) | column("M", 2)
    sigma, gamma = SX([1, 1]), SX([2, 0.08])
    rate = analysis.decay_rate(stacked(t, "rho", 2), stacked(t, "M", 2), sigma, gamma)
    return Statement(t, mutation(0.081, 0.07) >= rate, positive(t.M1, t.M2))
