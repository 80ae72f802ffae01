"""The window argument of Theorem 1: the algebraic steps of Eqs. (40)-(56) on the bounds' graphs."""

import casadi as ca

from wmr_proofs import paper_functions as analysis
from wmr_proofs.claim import CORRECTED, PRINTED, Claims, Mutation
from wmr_proofs.methods.spec import Z3, Refute, Ring
from wmr_proofs.regions import at
from wmr_proofs.statement import Statement, Symbols, positive, symbols

from .tracking import GAINS, Tracking


def conditions(names: Symbols, printed: bool = False) -> ca.SX:
    """The six conditions on l, in the symbols of a table."""
    gains = ca.vertcat(1, names.k2, names.k3)
    return analysis.conditions(names.l, gains, names.v1dmin, names.v1dmax, names.v2max, printed)


PUSHED = at(e1=0, e2=1, e3=-1, z1=0, z2=1, v1d=1, v2d=0, k1=1, k2=1, k3="1/100")
SIDE_POINT = at(l=10, e1=1, e2=1, e3=0, k2=1)

claim = Claims(by=Z3(), form=PRINTED)


@claim(
    "eq40",
    (40,),
    form=CORRECTED,
    by=Z3(points=(SIDE_POINT,)),
    premises="lemma.sine",
)
def start(mutation: Mutation) -> Statement:
    """V2(t0) < ((k2 + 1)/(2 k2 l^2) + 1/2) e2^2 for |e2| > l |e1|, |e2| > l |e3| (the text prints
    |e2| < l |e1|).

    When only the sideways error is left, it alone decides.

    Given: l > 5, k2 > 0; 1 - cos t <= t^2/2.
    """
    t = Tracking("l")
    e, k2, l = t.e, t.k[1], t.l
    sides = abs(e[1]) > l * abs(e[0]), abs(e[1]) > l * abs(e[2])
    if mutation < 0:
        sides = l * abs(e[0]) > abs(e[1]), sides[1]
    lemma = e[2] ** 2 >= 2 * (1 - ca.cos(e[2]))
    goal = analysis.start_bound(l, k2, e[1]) > analysis.position_lyapunov(e, k2)
    return Statement(t, goal, (l > 5, k2 > 0, sides, lemma))


@claim(
    "eq40.printed",
    (40,),
    by=Refute((SIDE_POINT,)),
)
def eq40_printed(mutation: Mutation) -> Statement:
    """the same for |e2| < l |e1|.

    With the printed inequality the bound is false: the error ahead may be the larger one.

    Given: l > 5, k2 > 0, |e2| < l |e1|, |e2| > l |e3|.
    """
    return start(-mutation)


@claim("eq42.rate", (42,))
def growth(mutation: Mutation) -> Statement:
    """eps1 < k3 V2(t0)/(2 l^2 k2).

    The unwanted growth is small compared with the value.

    Given: |e2(t0)| > 2 l sqrt(k2 eps1/k3), V2 > e2^2/2.
    """
    t = symbols("l k2 k3 E V0 eps1 root")
    l, k2, k3, E, V0, eps1, root = t.values()
    large = 2 * l * root < E, E**2 < 2 * V0
    given = positive(l, k2, k3, E, root), root**2 * k3 == k2 * eps1, large
    return Statement(t, k3 * V0 > mutation(1, 4) * 2 * l**2 * k2 * eps1, given)


@claim("eq42", (42,))
def window_value(mutation: Mutation) -> Statement:
    """V2 < V2(t0)(1 + k3 T/(2 l^2 k2)) < 1.1 V2(t0) < 0.594 e2(t0)^2.

    Over the window the error hardly grows.

    Given: l > 5, k2 >= 1, T < 0.2, k3/(2 k2 l^2) < 0.5.
    """
    t = symbols("l k2 k3 T V0 E")
    l, k2, k3, T, V0, E = t.values()
    grown = V0 * (1 + k3 * T / (2 * l**2 * k2))
    small = 5 * T < 1, k3 / (k2 * l**2) < 1, analysis.start_bound(l, k2, E) > V0
    given = l > 5, k2 >= 1, positive(k3, T, V0, E), small
    limit = mutation(594, 500)
    return Statement(t, (10 * grown < 11 * V0, limit * 10 * E**2 > 11000 * V0), given)


@claim(
    "eq4{k}",
    over=({"k": 3, "equations": (43,), "side": 2}, {"k": 4, "equations": (44,), "side": 1}),
)
def side_bound(mutation: Mutation, side: int) -> Statement:
    """|e{side}| < 1.1 |e2(t0)|.

    Given: V2 < 0.594 e2(t0)^2.
    """
    t = Tracking("E")
    value = analysis.position_lyapunov(t.e, t.k[1])
    given = positive(t.k[1], t.E), 1000 * value < 594 * t.E**2
    limit = mutation(1.21, 1.0)
    return Statement(t, 121 * t.E**2 * limit > 121 * t.e[side - 1] ** 2, given)


@claim("eq45.printed", (45, 50), by=Ring(GAINS))
def eq45_printed(mutation: Mutation) -> Statement:
    """e3' = -k2 v1d e2 - k3 sin e3 + z2.

    The sign of z2 is wrong; harmless, because only |z2| is used afterwards.

    Given: any.
    """
    return angle_rate(-mutation)


@claim("eq45", (45, 50), form=CORRECTED, by=Ring(GAINS))
def angle_rate(mutation: Mutation) -> Statement:
    """e3' = -k2 v1d e2 - k3 sin e3 - z2.

    A sideways error turns the robot.

    Given: any.
    """
    t = Tracking()
    k, e = t.k, t.e
    written = -k[1] * t.v_d[0] * e[1] - k[2] * ca.sin(e[2]) - mutation * t.z[1]
    return t.states(t.rate[2] == written)


@claim(
    "eq46",
    (46,),
    by=Z3(points=(PUSHED,)),
    premises="lemma.integration",
)
def angle_grows(mutation: Mutation) -> Statement:
    """sgn(e3) e3' <= |k2 v1d e2 + z2| at every instant.

    The sine term only helps, as long as the robot does not face backwards.

    Given: |e3| <= pi, so that e3 sin e3 >= 0 (not said in the paper).
    """
    t = Tracking()
    k, e = t.k, t.e
    push = abs(-k[1] * t.v_d[0] * e[1] - mutation * t.z[1])
    given = k[2] > 0, e[2] * ca.sin(e[2]) >= 0
    return t.states(push * abs(e[2]) >= e[2] * t.rate[2], given=given)


@claim("eq47", (47,), premises="eq43 eq46")
def angle_bound(mutation: Mutation) -> Statement:
    """|e3(t0)| + (1.1 k2 v1dmax |e2(t0)| + |z2|) T < |e2(t0)| (1/l + 11 v1dmax/(l v1dmin) + k3/(5
    l)).

    The angle stays small over the window.

    Given: T = 10/(l k2 v1dmin) < 0.2, |z2| < k3 |e2(t0)|/l.
    """
    t = symbols("l k2 k3 v1dmin v1dmax E e3 z2")
    l, k2, k3, low, high, E, e3, z2 = t.values()
    T = analysis.window(l, k2, low)
    start = 10 * abs(e3) + (11 * k2 * high * E + 10 * abs(z2)) * T
    small = 5 * T < 1, l * abs(e3) <= E, k3 * E >= l * abs(z2)
    given = l > 5, positive(k2, k3, low, E), high >= low, small
    bound = mutation(10, 5) * analysis.angle_bound(l, k3, low, high, E)
    return Statement(t, bound >= start, given)


@claim("eq48", (48,), premises="lemma.sine lemma.integration")
def side_rate(mutation: Mutation) -> Statement:
    """|e2'| <= |e1| |v2| + v1d |e3| at every instant.

    Given: |sin t| <= |t|.
    """
    t = Tracking()
    e, v2 = t.e, t.followed[1]
    given = t.v_d[0] > 0, abs(e[2]) >= abs(ca.sin(e[2]))
    bound = abs(e[0]) * abs(v2) + mutation * t.v_d[0] * abs(e[2])
    return t.states(bound >= abs(t.rate[1]), given=given)


@claim("eq49", (49,), premises="eq44 eq47 eq48")
def side_stays(mutation: Mutation) -> Statement:
    """|e2| > 0.8 |e2(t0)|.

    The sideways error cannot vanish within the window, so it keeps turning the robot.

    Given: {FIVE}.
    """
    t = symbols("l k2 k3 v1dmin v1dmax v2max E")
    l, k2, k3, low, high, v2, E = t.values()
    T = analysis.window(l, k2, low)
    lost = (11 * v2 * E + 10 * high * analysis.angle_bound(l, k3, low, high, E)) * T
    given = positive(l, k2, k3, low, high, v2, E, conditions(t)[4])
    return Statement(t, 10 * E - lost > mutation(8, 9.5) * E, given)
