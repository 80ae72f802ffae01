"""Statements of the window argument of Theorem 1, Eqs. (40)-(56)."""

from __future__ import annotations

from collections.abc import Sequence

import casadi as ca

from wmr_ctrl.barrier import lyapunov as analysis
from wmr_ctrl.barrier import theorem1
from wmr_ctrl.proofs.case import at
from wmr_ctrl.proofs.claims.tracking import Tracking
from wmr_ctrl.proofs.statement import Relation, Statement, above, at_least, equal, symbols


def positive(*items: ca.SX) -> tuple[Relation, ...]:
    """Every item > 0."""
    return tuple(above(item) for item in items)


def start(flip: float) -> Statement:
    """Eq. (40), with 1 - cos e3 <= e3^2/2 as the only fact about the cosine."""
    t = Tracking()
    names = {**t.names, **symbols("l")}
    e, k2, l = t.e, t.k[1], names["l"]
    sides = (above(ca.fabs(e[1]), l * ca.fabs(e[0])), above(ca.fabs(e[1]), l * ca.fabs(e[2])))
    if flip < 0:
        sides = (above(l * ca.fabs(e[0]), ca.fabs(e[1])), sides[1])
    lemma = at_least(e[2] ** 2, 2 * (1 - ca.cos(e[2])))
    goal = above(theorem1.start_bound(l, k2, e[1]), analysis.position_lyapunov(e, k2))
    return Statement(names, (goal,), (above(l, 5), above(k2), *sides, lemma))


def growth(flip: float) -> Statement:
    """Before (42): eps1 < k3 E^2/(4 l^2 k2) < k3 V20/(2 l^2 k2)."""
    t = symbols("l k2 k3 E V0 eps1 root")
    l, k2, k3, E, V0, eps1, root = t.values()
    given = (
        *positive(l, k2, k3, E, root),
        equal(root**2 * k3, k2 * eps1),
        above(E, 2 * l * root),
        above(2 * V0, E**2),
    )
    return Statement(t, (above(k3 * V0, (1 if flip > 0 else 4) * 2 * l**2 * k2 * eps1),), given)


def window_value(flip: float) -> Statement:
    """Eq. (42): V0 (1 + k3 T/(2 l^2 k2)) < 1.1 V0 < 0.594 E^2."""
    t = symbols("l k2 k3 T V0 E")
    l, k2, k3, T, V0, E = t.values()
    grown = V0 * (1 + k3 * T / (2 * l**2 * k2))
    given = (
        above(l, 5),
        at_least(k2, 1),
        *positive(k3, T, V0, E),
        above(1, 5 * T),
        above(1, k3 / (k2 * l**2)),
        above(theorem1.start_bound(l, k2, E), V0),
    )
    limit = 594 if flip > 0 else 500
    return Statement(t, (above(11 * V0, 10 * grown), above(limit * 10 * E**2, 11000 * V0)), given)


def side_bound(flip: float, index: int = 1) -> Statement:
    """Eqs. (43), (44): e_i^2 <= 2 V2 < 1.188 E^2 < 1.21 E^2."""
    t = Tracking()
    names = {**t.names, **symbols("E")}
    value = analysis.position_lyapunov(t.e, t.k[1])
    given = (*positive(t.k[1], names["E"]), above(594 * names["E"] ** 2, 1000 * value))
    limit = 1.21 if flip > 0 else 1.0
    return Statement(names, (above(121 * names["E"] ** 2 * limit, 121 * t.e[index] ** 2),), given)


def angle_rate(flip: float) -> Statement:
    """The integrand of Eq. (45)."""
    t = Tracking()
    k, e = t.k, t.e
    written = -k[1] * t.v_d[0] * e[1] - k[2] * ca.sin(e[2]) - flip * t.z[1]
    return Statement(t.names, (equal(t.rate[2], written),))


def angle_grows(flip: float) -> Statement:
    """Eq. (46) pointwise: sgn(e3) e3' <= |-k2 v1d e2 - z2| while e3 sin e3 >= 0."""
    t = Tracking()
    k, e = t.k, t.e
    push = ca.fabs(-k[1] * t.v_d[0] * e[1] - flip * t.z[1])
    given = (above(k[2]), at_least(e[2] * ca.sin(e[2])))
    return Statement(t.names, (at_least(push * ca.fabs(e[2]), e[2] * t.rate[2]),), given)


def angle_bound(flip: float) -> Statement:
    """Eq. (47): |e3(t0)| + (k2 v1dmax 1.1 E + |z2|) T, T of the window."""
    t = symbols("l k2 k3 v1dmin v1dmax E e3 z2")
    l, k2, k3, low, high, E, e3, z2 = t.values()
    T = theorem1.window(l, k2, low)
    start = 10 * ca.fabs(e3) + (11 * k2 * high * E + 10 * ca.fabs(z2)) * T
    given = (
        above(l, 5),
        *positive(k2, k3, low, E),
        at_least(high, low),
        above(1, 5 * T),
        at_least(E, l * ca.fabs(e3)),
        at_least(k3 * E, l * ca.fabs(z2)),
    )
    share = 10 if flip > 0 else 5
    return Statement(
        t, (at_least(share * theorem1.angle_bound(l, k3, low, high, E), start),), given
    )


def side_rate(flip: float) -> Statement:
    """Eq. (48) pointwise: |e2'| <= |e1| |v2| + v1d |e3|, with |sin e3| <= |e3|."""
    t = Tracking()
    e, v2 = t.e, t.followed[1]
    given = (above(t.v_d[0]), at_least(ca.fabs(e[2]), ca.fabs(ca.sin(e[2]))))
    bound = ca.fabs(e[0]) * ca.fabs(v2) + flip * t.v_d[0] * ca.fabs(e[2])
    return Statement(t.names, (at_least(bound, ca.fabs(t.rate[1])),), given)


def conditions(names: dict[str, ca.SX], printed: bool = False) -> ca.SX:
    """The six conditions on l, in the symbols of a table."""
    gains = ca.vertcat(1, names["k2"], names["k3"])
    return theorem1.conditions(
        names["l"], gains, names["v1dmin"], names["v1dmax"], names["v2max"], printed
    )


def side_stays(flip: float) -> Statement:
    """Eq. (49): E - (1.1 E v2max + v1dmax angle bound) T > 0.8 E by the fifth condition."""
    t = symbols("l k2 k3 v1dmin v1dmax v2max E")
    l, k2, k3, low, high, v2, E = t.values()
    T = theorem1.window(l, k2, low)
    lost = (11 * v2 * E + 10 * high * theorem1.angle_bound(l, k3, low, high, E)) * T
    given = (*positive(l, k2, k3, low, high, v2, E), above(conditions(t)[4]))
    kept = 8 if flip > 0 else 9.5
    return Statement(t, (above(10 * E - lost, kept * E),), given)


def angle_falls(flip: float) -> Statement:
    """Eq. (50): e3' < -0.8 k2 v1d E + k3 (|sin e3| + E/l), e2 > 0.8 E."""
    t = Tracking()
    names = {**t.names, **symbols("l E")}
    l, E = names["l"], names["E"]
    given = (
        *positive(l, E, t.k[1], t.k[2], t.v_d[0]),
        above(5 * t.e[1], 4 * E),
        above(t.k[2] * E, l * ca.fabs(t.z[1])),
    )
    bound = theorem1.angle_rate_bound(l, t.k, t.v_d[0], flip * ca.fabs(ca.sin(t.e[2])), E)
    return Statement(names, (above(bound, 5 * t.rate[2]),), given)


def angle_speed(flip: float) -> Statement:
    """Eq. (51): the bound of (50) is below -0.5 k2 v1dmin E, by the fourth and sixth condition."""
    t = symbols("l k2 k3 v1dmin v1dmax v2max E v1d sine")
    l, k2, k3, low, high, _, E, v1d, sine = t.values()
    six = conditions(t)
    given = (
        *positive(l, k2, k3, low, E, six[3], six[5]),
        at_least(v1d, low),
        at_least(high, v1d),
        at_least(theorem1.angle_bound(l, k3, low, high, E), sine),
        at_least(sine),
    )
    gains = ca.vertcat(1, k2, k3)
    bound = theorem1.angle_rate_bound(l, gains, v1d, sine, E)
    speed = 2.5 if flip > 0 else 3.5
    return Statement(t, (above(-speed * k2 * low * E, bound),), given)


def printed_share(_: float) -> Statement:
    """Eq. (51) as printed against what (47) gives."""
    t = symbols("k2 k3 v1dmin v1dmax")
    k2, k3, low, high = t.values()
    pair = [theorem1.angle_share(k2, k3, low, high, printed) for printed in (False, True)]
    return Statement(t, (equal(*pair),), positive(k2, k3, low, high))


def share(flip: float) -> Statement:
    """k3 (|sin e3| + E/l) with (47) is k2 v1dmin E times the share of (51) without a further k2."""
    t = symbols("l k2 k3 v1dmin v1dmax E")
    l, k2, k3, low, high, E = t.values()
    share = theorem1.angle_share(k2, k3, low, high, printed=flip < 0)
    left = k3 * theorem1.angle_bound(l, k3, low, high, E)
    return Statement(t, (equal(left, k2 * low * E * (k3 / (l * k2 * low) * share)),))


def rise(flip: float) -> Statement:
    """Eq. (52): V2' < eps1 wherever (39) holds."""
    t = Tracking()
    names = {**t.names, **symbols("eps1")}
    given = positive(*(t.k[i] for i in range(3)))
    bound = analysis.position_rate_bound(t.e, t.z, flip * t.k)
    return Statement(names, (at_least(names["eps1"], bound + names["eps1"]),), given)


def angle_end(flip: float) -> Statement:
    """Eq. (53), and (54) mirrored: from 3 T/5 on, |e3| has passed 4 (root + |z2|/(2 k3))."""
    t = symbols("l k2 k3 v1dmin E e3 z2 root eps0 s")
    l, k2, k3, low, E, e3, z2, root, eps0, side = t.values()
    T = theorem1.window(l, k2, low)
    given = (
        *positive(l, k2, k3, low, E, eps0),
        at_least(root),
        equal(side**2, 1),
        at_least(eps0, ca.fabs(z2)),
        at_least(E, l * ca.fabs(e3)),
        above(E, 2 * l * (root + eps0 / (2 * k3)) * (1 if flip > 0 else 0.25)),
    )
    moved = side * e3 - 3 * T * k2 * low * E / 10
    end = theorem1.angle_after(l, side * e3, E)
    passed = above(-4 * (root + ca.fabs(z2) / (2 * k3)), end)
    return Statement(t, (equal(moved, end), at_least(-2 * E, l * end), passed), given)


def fast_fall(flip: float, repaired: bool) -> Statement:
    """Eq. (55): |e3| >= 4 x gives -(k3/k2)(sin e3 + z2/(2 k3))^2 + eps1 < -3 eps1."""
    t = Tracking()
    names = {**t.names, **symbols("root eps1 x")}
    e3, z2, k2, k3 = t.e[2], t.z[1], t.k[1], t.k[2]
    root, eps1, x = (names[n] for n in ("root", "eps1", "x"))
    given: Sequence[Relation] = (
        *positive(t.k[0], k2, k3, eps1, root),
        equal(root**2 * k3, k2 * eps1),
        equal(x, root + ca.fabs(z2) / (2 * k3)),
        above(-4 * x, flip * e3),
        above(11, 14 * x),
        above(22, -7 * e3),
        above(22, 7 * e3),
    )
    if repaired:
        given = (
            *given,
            at_least(11 * ca.fabs(ca.sin(e3)), 7 * ca.fabs(e3)),
            at_least(e3 * ca.sin(e3)),
        )
    bound = analysis.position_rate_bound(ca.vertcat(-t.z[0] / (2 * t.k[0]), 0, e3), t.z, t.k)
    share = 3 if flip > 0 else 40
    return Statement(names, (above(-share * eps1, bound + eps1),), tuple(given))


BARELY_PAST = tuple(
    at(e3=angle, z1=0, z2=0, k1=1, k2=1, k3=1, root="0.1", eps1="0.01", x="0.1")
    for angle in ("-0.42", "0.42")
)
"""Angles just beyond 4 x: V2 falls there by 14.6 eps1, less than the altered claim says."""


def mean(flip: float) -> Statement:
    """Eq. (56)."""
    t = symbols("T eps1")
    return Statement(
        t, (equal(theorem1.mean_rise(t["T"], t["eps1"]), -3 * flip * t["T"] * t["eps1"]),)
    )


def condition_set(printed: bool, least: int, flip: float) -> Statement:
    """All six hold for every l > least with the paper's gains."""
    t = symbols("l k2 k3 v1dmin v1dmax v2max")
    six = conditions(t, printed)
    start = above(t["l"], least if flip > 0 else least - 1)
    return Statement(t, tuple(above(six[i]) for i in range(6)), (*paper_gains(t), start))


def at_256(_: float) -> Statement:
    """All six conditions at l = 256."""
    t = symbols("l k2 k3 v1dmin v1dmax v2max")
    six = conditions(t)
    return Statement(
        t, tuple(above(six[i]) for i in range(6)), (*paper_gains(t), equal(t["l"], 256))
    )


def paper_gains(t: dict[str, ca.SX]) -> tuple[Relation, ...]:
    """k2 = 5, k3 = 4, v1d = 0.2, v2max = 1.5, as exact hypotheses."""
    exact = (("k2", 1, 5), ("k3", 1, 4), ("v1dmin", 5, 1), ("v1dmax", 5, 1), ("v2max", 2, 3))
    return tuple(equal(a * t[name], b) for name, a, b in exact)
