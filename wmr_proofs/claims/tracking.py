"""Position errors: Eqs. (31)-(39), on V2 and the error dynamics of the product."""

from casadi import cos, sin, sumsqr, vertcat, vertsplit

from wmr_ctrl.world.model.kinematics import auxiliary_velocity, error_rate
from wmr_proofs import paper_functions as analysis
from wmr_proofs.claim import CORRECTED, PRINTED, Claims, Mutation
from wmr_proofs.methods.spec import Z3, Refute, Ring
from wmr_proofs.regions import FREE, POSITIVE, Case, at
from wmr_proofs.statement import Named, Statement, column, positive, stacked, symbols


class Tracking(Named):
    """e, z = v - v_c0, a free velocity v, the desired one and gains; ``more``: further symbols.

    Of v = v_c0 + z with Eq. (7), which is ``followed``: ``rate`` is e' of Eqs. (33)-(35), ``fall``
    is V2'.
    """

    def __init__(self, more: str = "") -> None:
        free = column("e", 3) | column("z", 2) | symbols("v1d v2d")
        self.symbols = free | column("k", 3, fixed=True) | column("v", 2) | symbols(more)
        self.e, self.k = (stacked(self, name, 3) for name in "ek")
        self.z, self.v = (stacked(self, name, 2) for name in "zv")
        self.v_d = vertcat(self.v1d, self.v2d)
        self.followed = auxiliary_velocity(self.e, self.v_d, self.k) + self.z
        self.rate = error_rate(self.e, self.followed, self.v_d)
        self.fall = analysis.position_rate(self.e, self.followed, self.v_d, self.k[1])


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

PAPER: dict[str, str | int] = {"v1d": "1/5", "v2d": "1/10", "k1": 10, "k2": 5, "k3": 4}
QUARTER = at(e3="3/2", share="13/20", x="37/50")
SLIGHT = at(e1=0, e2=0, e3="1/100", z1=0, z2="-1/2", **PAPER, eps0="1/2", root="1/2")
claim = Claims(by=Ring(GAINS), form=PRINTED)


@claim("eq32", (31, 32))
def derivative(mutation: Mutation) -> Statement:
    """V2' = e1' e1 + e2' e2 + e3' sin e3/k2.

    How the Lyapunov function of the position errors changes.

    Given: {ANY_ERROR}.
    """
    t = Tracking()
    e, v, v_d, k2 = t.e, t.v, t.v_d, t.k[1]
    rate = error_rate(e, v, v_d)
    chain = rate[0] * e[0] + rate[1] * e[1] + mutation * rate[2] * sin(e[2]) / k2
    return t.states(analysis.position_rate(e, v, v_d, k2) == chain)


@claim("eq36", (33, 34, 35, 36))
def expanded(mutation: Mutation) -> Statement:
    """V2' with (33)-(35) put in.

    The turning terms e1 e2 v2 cancel.

    Given: {ANY_ERROR}.
    """
    t = Tracking()
    e, v, v_d, k2 = t.e, t.v, t.v_d, t.k[1]
    s, c = sin(e[2]), cos(e[2])
    written = (-v[0] + v_d[0] * c) * e[0] + v_d[0] * s * e[1] + mutation * (v_d[1] - v[1]) * s / k2
    return t.states(analysis.position_rate(e, v, v_d, k2) == written)


@claim("eq37", (7, 13, 37))
def with_targets(mutation: Mutation) -> Statement:
    """V2' = -k1 e1^2 - z1 e1 - (k3/k2) sin^2 e3 - z2 sin e3/k2 for v = v_c0 + z.

    The auxiliary velocity damps the error ahead and the angle; the sideways error is only coupled.

    Given: {ANY_ERROR}.
    """
    t = Tracking()
    e, z, k, s = t.e, t.z, t.k, sin(t.e[2])
    written = -k[0] * e[0] ** 2 - z[0] * e[0] - k[2] / k[1] * s**2 - mutation * z[1] * s / k[1]
    return t.states(t.fall == written)


@claim("eq38", (38,))
def squares(mutation: Mutation) -> Statement:
    """the same with completed squares.

    Given: k1, k2, k3 > 0.
    """
    t = Tracking()
    z, k = t.z, t.k
    rest = analysis.square_rest(z[0] ** 2, z[1] ** 2, k)
    written = analysis.position_rate_bound(t.e, mutation * z, k) + rest
    return t.states(t.fall == written)


@claim("eq39", (39,), by=Ring((SIGNED,)))
def bounded(mutation: Mutation) -> Statement:
    """V2' <= the squares + eps1 for |z1|, |z2| < eps0.

    A small velocity error can make the position error grow only a little.

    Given: k1, k2, k3, eps0 > 0.
    """
    t = Tracking("eps0")
    rest = analysis.square_rest(t.eps0**2, t.eps0**2, t.k)
    written = analysis.position_rate_bound(t.e, t.z, t.k) + mutation * rest
    return Statement(t, written >= t.fall)


@claim(
    "eq39.threshold",
    (39,),
    by=Z3(points=(SLIGHT,)),
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


@claim(
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


@claim(
    "eq39.corrected",
    (39,),
    form=CORRECTED,
    by=Z3(points=(QUARTER,)),
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
