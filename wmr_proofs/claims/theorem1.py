"""The window argument of Theorem 1: the algebraic steps of Eqs. (40)-(56) on the bounds' graphs.

First position errors, Eqs. (31)-(39), with V2 and the product's error dynamics; then the window up
to Eq. (49); from Eq. (50) on the robot turns; at last the conditions on l.
"""

from casadi import SX, cos, sin, sumsqr, vertcat, vertsplit

from wmr_ctrl.world.model.kinematics import auxiliary_velocity, error_rate
from wmr_proofs import paper_functions as analysis
from wmr_proofs.claim import CORRECTED, OURS, PRINTED, Claims, Mutation
from wmr_proofs.methods.spec import Z3, Refute, Ring
from wmr_proofs.regions import FREE, POSITIVE, Case, at
from wmr_proofs.statement import (
    Named,
    Relations,
    Statement,
    Symbols,
    between,
    column,
    equal,
    positive,
    stacked,
    symbols,
)


class Tracking(Named):
    """e, z = v - v_c0, a free velocity v, the desired one and gains; ``more``: further symbols.

    ``target`` is v_c0 of Eq. (7). Of v = v_c0 + z, which is ``followed``: ``rate`` is e' of Eqs.
    (33)-(35), ``fall`` is V2'.
    """

    def __init__(self, more: str = "") -> None:
        free = column("e", 3) | column("z", 2) | symbols("v1d v2d")
        self.symbols = free | column("k", 3, fixed=True) | column("v", 2) | symbols(more)
        self.e, self.k = (stacked(self, name, 3) for name in "ek")
        self.z, self.v = (stacked(self, name, 2) for name in "zv")
        self.v_d = vertcat(self.v1d, self.v2d)
        self.target = auxiliary_velocity(self.e, self.v_d, self.k)
        self.followed = self.target + self.z
        self.rate = error_rate(self.e, self.followed, self.v_d)
        self.fall = self.falls(self.followed)

    @property
    def V2(self) -> SX:
        """The Lyapunov function of the position errors."""
        return analysis.position_lyapunov(self.e, self.k[1])

    def falls(self, v: SX) -> SX:
        """V2' with a velocity."""
        return analysis.position_rate(self.e, v, self.v_d, self.k[1])


ABOVE_0 = dict.fromkeys(("k1", "k2", "k3"), POSITIVE)
GAINS = (Case("any", declared=ABOVE_0),)
SIGNED = Case(
    "|z| < eps0",
    dict.fromkeys(("eps0", "s1", "s2"), POSITIVE),
    lambda n: (
        {"eps0": n["eps0"]}
        | {f"z{i}": n["eps0"] * (1 - n[f"s{i}"]) / (1 + n[f"s{i}"]) for i in (1, 2)}
    ),
    ABOVE_0 | {"e3": FREE},
)

PAPER = at(v1d="1/5", v2d="1/10", k1=10, k2=5, k3=4)
tracking_claim = Claims(by=Ring(GAINS), form=PRINTED)


@tracking_claim("eq32", (31, 32))
def derivative(mutation: Mutation) -> Statement:
    """V2' = e1' e1 + e2' e2 + e3' sin e3/k2.

    How the Lyapunov function of the position errors changes.

    Given: {ANY_ERROR}.
    """
    t = Tracking()
    e, v = t.e, t.v
    rate = error_rate(e, v, t.v_d)
    chain = rate[0] * e[0] + rate[1] * e[1] + mutation * rate[2] * sin(e[2]) / t.k[1]
    return t.states(t.falls(v) == chain)


@tracking_claim("eq36", (33, 34, 35, 36))
def expanded(mutation: Mutation) -> Statement:
    """V2' with (33)-(35) put in.

    The turning terms e1 e2 v2 cancel.

    Given: {ANY_ERROR}.
    """
    t = Tracking()
    e, v, v_d, k2 = t.e, t.v, t.v_d, t.k[1]
    s, c = sin(e[2]), cos(e[2])
    written = (-v[0] + v_d[0] * c) * e[0] + v_d[0] * s * e[1] + mutation * (v_d[1] - v[1]) * s / k2
    return t.states(t.falls(v) == written)


@tracking_claim("eq37", (7, 13, 37))
def with_targets(mutation: Mutation) -> Statement:
    """V2' = -k1 e1^2 - z1 e1 - (k3/k2) sin^2 e3 - z2 sin e3/k2 for v = v_c0 + z.

    The auxiliary velocity damps the error ahead and the angle; the sideways error is only coupled.

    Given: {ANY_ERROR}.
    """
    t = Tracking()
    e, z, k, s = t.e, t.z, t.k, sin(t.e[2])
    written = -k[0] * e[0] ** 2 - z[0] * e[0] - k[2] / k[1] * s**2 - mutation * z[1] * s / k[1]
    return t.states(t.fall == written)


@tracking_claim("eq38", (38,))
def squares(mutation: Mutation) -> Statement:
    """the same with completed squares.

    Given: k1, k2, k3 > 0.
    """
    t = Tracking()
    z, k = t.z, t.k
    rest = analysis.square_rest(z[0] ** 2, z[1] ** 2, k)
    written = analysis.position_rate_bound(t.e, mutation * z, k) + rest
    return t.states(t.fall == written)


@tracking_claim("eq39", (39,), by=Ring((SIGNED,)))
def bounded(mutation: Mutation) -> Statement:
    """V2' <= the squares + eps1 for |z1|, |z2| < eps0.

    A small velocity error can make the position error grow only a little.

    Given: k1, k2, k3, eps0 > 0.
    """
    t = Tracking("eps0")
    rest = analysis.square_rest(t.eps0**2, t.eps0**2, t.k)
    written = analysis.position_rate_bound(t.e, t.z, t.k) + mutation * rest
    return Statement(t, written >= t.fall)


@tracking_claim(
    "eq39.threshold",
    (39,),
    by=Z3(points=(at(e1=0, e2=0, e3="1/100", z1=0, z2="-1/2", **PAPER, eps0="1/2", root="1/2"),)),
)
def beyond(mutation: Mutation) -> Statement:
    """|sin e3| > sqrt(k2 eps1/k3) + eps0/(2 k3) makes V2' < 0.

    If the angle is clearly wrong, the error falls.

    Given: |z2| <= eps0; root stands for the square root.
    """
    t = Tracking("eps0 root")
    e, z, k, eps0, root = t.e, t.z, t.k, t.eps0, t.root
    rest = analysis.square_rest(eps0**2, eps0**2, k)
    root_of = root > 0, root**2 * k[2] == k[1] * rest
    turned = abs(sin(e[2])) > (root + eps0 / (2 * k[2])) * mutation
    sizes = positive(eps0, *vertsplit(k)), eps0 >= abs(z[1])
    only_angle = analysis.position_rate_bound(vertcat(-z[0] / (2 * k[0]), e[1], e[2]), z, k)
    return t.states(only_angle + rest < 0, given=(sizes, root_of, turned))


@tracking_claim(
    "eq39.printed",
    (39,),
    by=Refute((at(e1=0, e2=0, e3="31/10", z1=0, z2="-1/2", eps0="1/2", **PAPER),)),
)
def twice_threshold(_: Mutation) -> Statement:
    """|e3| > 2 (sqrt(k2 eps1/k3) + eps0/(2 k3)) makes V2' < 0.

    Near pi the sine is small again: a robot that faces backwards is not brought back by this
    argument.

    Given: |z| <= eps0, the bracket below 7/9 < pi/4, |e3| < 22/7.
    """
    t = Tracking("eps0")
    x = analysis.threshold(t.eps0, t.k)
    turned = abs(t.e[2]) > 2 * x, 9 * x < 7, 7 * abs(t.e[2]) < 22
    return t.states(t.fall < 0, given=(turned, t.eps0**2 >= sumsqr(t.z)))


@tracking_claim(
    "eq39.corrected",
    (39,),
    form=CORRECTED,
    by=Z3(points=(at(e3="3/2", share="13/20", x="37/50"),)),
    premises="eq39.threshold lemma.sine",
)
def quarter_turn(mutation: Mutation) -> Statement:
    """|e3| > 2 x and |e3| <= pi/2 make |sin e3| > x, x the bracket.

    Within a quarter turn the argument is right.

    Given: x >= 0; |sin e3| >= share |e3| for |e3| <= pi/2, share = 2/pi > 7/11.
    """
    t = symbols("e3 share x")
    angle, share, x = t.values()
    sine, size = abs(sin(angle)), abs(angle)
    given = x >= 0, size > 2 * x, 11 * share > 7, sine >= share * size
    return Statement(t, sine > mutation(1, 2) * x, given)


def conditions(names: Symbols, printed: bool = False) -> SX:
    """The six conditions on l, in the symbols of a table."""
    gains = vertcat(1, names.k2, names.k3)
    return analysis.conditions(names.l, gains, names.v1dmin, names.v1dmax, names.v2max, printed)


PUSHED = at(e1=0, e2=1, e3=-1, z1=0, z2=1, v1d=1, v2d=0, k1=1, k2=1, k3="1/100")
SIDE_POINT = at(l=10, e1=1, e2=1, e3=0, k2=1)

claim = Claims(form=PRINTED)


@claim("eq40", (40,), form=CORRECTED, by=Z3(points=(SIDE_POINT,)), premises="lemma.sine")
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
    goal = analysis.start_bound(l, k2, e[1]) > t.V2
    return Statement(t, goal, (l > 5, k2 > 0, sides, e[2] ** 2 >= 2 * (1 - cos(e[2]))))


@claim("eq40.printed", (40,), by=Refute((SIDE_POINT,)))
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
    given = positive(l, k2, k3, E, root), root**2 * k3 == k2 * eps1, 2 * l * root < E, E**2 < 2 * V0
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
    return Statement(t, (10 * grown < 11 * V0, mutation(594, 500) * 10 * E**2 > 11000 * V0), given)


@claim(
    "eq4{k}",
    over=({"k": 3, "equations": (43,), "side": 2}, {"k": 4, "equations": (44,), "side": 1}),
)
def side_bound(mutation: Mutation, side: int) -> Statement:
    """|e{side}| < 1.1 |e2(t0)|.

    Given: V2 < 0.594 e2(t0)^2.
    """
    t = Tracking("E")
    given = positive(t.k[1], t.E), 1000 * t.V2 < 594 * t.E**2
    return Statement(t, 121 * t.E**2 * mutation(1.21, 1.0) > 121 * t.e[side - 1] ** 2, given)


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
    written = -k[1] * t.v_d[0] * e[1] - k[2] * sin(e[2]) - mutation * t.z[1]
    return t.states(t.rate[2] == written)


@claim("eq46", (46,), by=Z3(points=(PUSHED,)), premises="lemma.integration")
def angle_grows(mutation: Mutation) -> Statement:
    """sgn(e3) e3' <= |k2 v1d e2 + z2| at every instant.

    The sine term only helps, as long as the robot does not face backwards.

    Given: |e3| <= pi, so that e3 sin e3 >= 0 (not said in the paper).
    """
    t = Tracking()
    k, e = t.k, t.e
    push = abs(-k[1] * t.v_d[0] * e[1] - mutation * t.z[1])
    given = k[2] > 0, e[2] * sin(e[2]) >= 0
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
    e = t.e
    given = t.v_d[0] > 0, abs(e[2]) >= abs(sin(e[2]))
    bound = abs(e[0]) * abs(t.followed[1]) + mutation * t.v_d[0] * abs(e[2])
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


BARELY_PAST = tuple(
    at(e3=angle, z1=0, z2=0, k1=1, k2=1, k3=1, root="0.1", eps1="0.01", x="0.1")
    for angle in ("-0.42", "0.42")
)
"""Angles just beyond 4 x: V2 falls there by 14.6 eps1, less than the altered claim says."""
NUMBERS = "l k2 k3 v1dmin v1dmax E"
LATE = at(e1=0, e2=0, z1=0, z2=0, k1=1, k2=1, k3=1)


def paper_gains(t: Symbols) -> Relations:
    """k2 = 5, k3 = 4, v1d = 0.2, v2max = 1.5, as exact hypotheses."""
    exact = (("k2", 1, 5), ("k3", 1, 4), ("v1dmin", 5, 1), ("v1dmax", 5, 1), ("v2max", 2, 3))
    return tuple(a * t[name] == b for name, a, b in exact)


@claim("eq50", (50,), form=CORRECTED, premises="eq49")
def angle_falls(mutation: Mutation) -> Statement:
    """e3' < -0.8 k2 v1d |e2(t0)| + k3 (|sin e3| + |e2(t0)|/l).

    Given: e2 > 0.8 |e2(t0)|, |z2| < k3 |e2(t0)|/l.
    """
    t = Tracking("l E")
    l, E = t.l, t.E
    stays = 5 * t.e[1] > 4 * E, t.k[2] * E > l * abs(t.z[1])
    given = positive(l, E, t.k[1], t.k[2], t.v_d[0]), stays
    bound = analysis.angle_rate_bound(l, t.k, t.v_d[0], mutation * abs(sin(t.e[2])), E)
    return Statement(t, bound > 5 * t.rate[2], given)


@claim("eq51.printed", (51,), by=Refute((at(k2=5, k3=4, v1dmin="1/5", v1dmax="1/5"),)))
def printed_share(_: Mutation) -> Statement:
    """the share in (51) is 1 + 1.1 k2 v1dmax 10/v1dmin + k3/5.

    One k2 too many: the condition on l is k2 times too strict (l above 1136 instead of above 256
    with the paper's gains). The text at hand may have lost a fraction bar.

    Given: k2, k3, v1dmin, v1dmax > 0.
    """
    t = symbols("k2 k3 v1dmin v1dmax")
    k2, k3, low, high = t.values()
    pair = [analysis.angle_share(k2, k3, low, high, printed) for printed in (False, True)]
    return Statement(t, equal(*pair), positive(k2, k3, low, high))


@claim(
    "eq51.share",
    (51,),
    form=CORRECTED,
    by=Ring((Case("any", declared=dict.fromkeys(NUMBERS.split(), POSITIVE)),)),
)
def share(mutation: Mutation) -> Statement:
    """the share in (51) is 1 + 11 v1dmax/v1dmin + k3/5.

    What (47) gives.

    Given: l, k2, k3, v1dmin, v1dmax, E > 0.
    """
    t = symbols(NUMBERS)
    l, k2, k3, low, high, E = t.values()
    share = analysis.angle_share(k2, k3, low, high, printed=mutation < 0)
    left = k3 * analysis.angle_bound(l, k3, low, high, E)
    return Statement(t, left == k2 * low * E * (k3 / (l * k2 * low) * share))


@claim("eq51", (51,), form=CORRECTED, premises="eq47 eq50")
def angle_speed(mutation: Mutation) -> Statement:
    """e3' < -0.5 k2 v1dmin |e2(t0)|.

    The robot turns towards the path at a guaranteed speed.

    Given: fourth and sixth condition on l, the latter corrected.
    """
    t = symbols("l k2 k3 v1dmin v1dmax v2max E v1d sine")
    l, k2, k3, low, high, _, E, v1d, sine = t.values()
    six = conditions(t)
    turned = analysis.angle_bound(l, k3, low, high, E) >= sine, sine >= 0
    given = positive(l, k2, k3, low, E, six[3], six[5]), between(low, v1d, high), turned
    bound = analysis.angle_rate_bound(l, vertcat(1, k2, k3), v1d, sine, E)
    return Statement(t, -mutation(2.5, 3.5) * k2 * low * E > bound, given)


@claim(
    "eq52",
    (52,),
    by=Z3(points=(at(e1=1, e2=0, e3=1, z1=0, z2=0, k1=1, k2=1, k3=1, eps1=1),)),
    premises="eq39",
)
def rise(mutation: Mutation) -> Statement:
    """V2' < eps1.

    Given: (39).
    """
    t = Tracking("eps1")
    bound = analysis.position_rate_bound(t.e, t.z, mutation * t.k)
    return Statement(t, t.eps1 >= bound + t.eps1, positive(*(t.k[i] for i in range(3))))


@claim("eq53-54", (53, 54), premises="eq51")
def angle_end(mutation: Mutation) -> Statement:
    """from 3 T/5 on, e3 < -(2/l)|e2(t0)| < -4 (sqrt(k2 eps1/k3) + |z2|/(2 k3)), and mirrored for e2
    < 0 (s = -1).

    By then the robot points clearly towards the path.

    Given: |e2(t0)| > 2 l (sqrt(k2 eps1/k3) + eps0/(2 k3)), |z2| <= eps0.
    """
    t = symbols("l k2 k3 v1dmin E e3 z2 root eps0 s")
    l, k2, k3, low, E, e3, z2, root, eps0, side = t.values()
    least = 2 * l * (root + eps0 / (2 * k3))
    large = l * abs(e3) <= E, least * mutation(1, 0.25) < E
    given = positive(l, k2, k3, low, E, eps0), root >= 0, side**2 == 1, eps0 >= abs(z2), large
    moved = side * e3 - 3 * analysis.window(l, k2, low) * k2 * low * E / 10
    end = analysis.angle_after(l, side * e3, E)
    passed = -4 * (root + abs(z2) / (2 * k3)) > end
    return Statement(t, (moved == end, l * end <= -2 * E, passed), given)


@claim(
    "eq55.printed",
    (55,),
    by=Refute((at(e3="-78001/25000", x="39/50", root="39/50", eps1="1521/2500", **LATE),)),
)
def eq55_printed(mutation: Mutation, repaired: bool = False) -> Statement:
    """|e3| > 4 x gives V2' < -3 eps1, with x < pi/4 as the only condition.

    With x = 0.78 the angle may be 3.12, almost backwards, where the sine is 0.02.

    Given: x = sqrt(k2 eps1/k3) + |z2|/(2 k3) < 11/14 (just above pi/4), |e3| < 22/7.
    """
    t = Tracking("root eps1 x")
    e3, z2, k2, k3 = t.e[2], t.z[1], t.k[1], t.k[2]
    root, eps1, x = t.root, t.eps1, t.x
    given: list[Relations] = [
        positive(t.k[0], k2, k3, eps1, root), root**2 * k3 == k2 * eps1,
        x == root + abs(z2) / (2 * k3), -4 * x > mutation * e3, 14 * x < 11,
        -7 * e3 < 22, 7 * e3 < 22,
    ]  # fmt: skip
    if repaired:
        given += [11 * abs(sin(e3)) >= 7 * abs(e3), e3 * sin(e3) >= 0]
    bound = analysis.position_rate_bound(vertcat(-t.z[0] / (2 * t.k[0]), 0, e3), t.z, t.k)
    return t.states(-mutation(3, 40) * eps1 > bound + eps1, given=given)


@claim("eq55", (55,), form=CORRECTED, by=Z3(points=BARELY_PAST), premises="lemma.sine")
def eq55(mutation: Mutation) -> Statement:
    """the same where |sin e3| >= (7/11)|e3|, which holds for |e3| <= pi/2; that needs 4 x < pi/2.

    The step needs an angle below a quarter turn and a velocity error half as large.

    Given: |e3| <= pi/2, x < pi/8, k1 > 0; |sin t| >= (2/pi)|t| > (7/11)|t|.
    """
    return eq55_printed(mutation, True)


@claim("eq56", (56,), by=Ring())
def mean(mutation: Mutation) -> Statement:
    """(3/5) T eps1 - (2/5) T 3 eps1 = -(3/5) T eps1.

    On average over the window the error falls.

    Given: any.
    """
    t = symbols("T eps1")
    return Statement(t, analysis.mean_rise(t.T, t.eps1) == -3 * mutation * t.T * t.eps1)


@claim("conditions.least", (40,), form=OURS)
def conditions_least(mutation: Mutation, printed: bool = False, least: int = 256) -> Statement:
    """with the paper's gains all six conditions on l (the sixth corrected) hold for every l > 256.

    The theorem applies only if the sideways error is more than 256 times the others.

    Given: k = (10, 5, 4), v1d = 0.2, v2max = 1.5.
    """
    t = symbols("l k2 k3 v1dmin v1dmax v2max")
    start = t.l > mutation(least, least - 1)
    return Statement(t, positive(*vertsplit(conditions(t, printed))), (paper_gains(t), start))


@claim("conditions.256", (40,), form=OURS)
def at_256(_: Mutation) -> Statement:
    """l = 256 itself satisfies them.

    The sixth condition holds there with equality, and it is strict: the least whole number is 257.
    Floating-point arithmetic hides this. A least real l, which the paper takes, does not exist.

    Given: k = (10, 5, 4), v1d = 0.2, v2max = 1.5.
    """
    t = symbols("l k2 k3 v1dmin v1dmax v2max")
    given = paper_gains(t), t.l == 256
    return Statement(t, positive(*vertsplit(conditions(t))), given)


@claim("conditions.printed", (40, 51), form=OURS)
def conditions_printed(mutation: Mutation) -> Statement:
    """with the sixth condition as printed they hold for every l > 1136.

    The additional k2 makes the theorem more than four times weaker.

    Given: k = (10, 5, 4), v1d = 0.2, v2max = 1.5.
    """
    return conditions_least(mutation, True, 1136)
