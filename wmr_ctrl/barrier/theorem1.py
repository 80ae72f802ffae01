"""Bounds from the proof of Theorem 1, Eqs. (39)-(56), as graphs in the paper's letters.

Whole-number coefficients (10 x < 2 for x < 0.2) keep every constant exact.  E stands for |e2| at
the start t0 of the window of length T; v1dmin <= v1d <= v1dmax; l > 5 is the proof's large number.
"""

from __future__ import annotations

import casadi as ca

from wmr_ctrl.barrier.lyapunov import square_rest


def window(l: ca.SX, k2: ca.SX, v1dmin: ca.SX) -> ca.SX:
    """T = 10/(l k2 v1dmin) [s], before Eq. (40)."""
    return 10 / (l * k2 * v1dmin)


def threshold(eps0: ca.SX, k: ca.SX) -> ca.SX:
    """sqrt(k2 eps1/k3) + eps0/(2 k3): |sin e3| beyond it makes V2' < 0, after Eq. (39)."""
    return ca.sqrt(k[1] * square_rest(eps0**2, eps0**2, k) / k[2]) + eps0 / (2 * k[2])


def start_bound(l: ca.SX, k2: ca.SX, e2: ca.SX) -> ca.SX:
    """((k2 + 1)/(2 k2 l^2) + 1/2) e2^2, Eq. (40)."""
    return ((k2 + 1) / (2 * k2 * l**2) + 0.5) * e2**2


def angle_bound(l: ca.SX, k3: ca.SX, v1dmin: ca.SX, v1dmax: ca.SX, E: ca.SX) -> ca.SX:
    """E (1/l + 11 v1dmax/(l v1dmin) + k3/(5 l)): what |e3| stays below, Eq. (47)."""
    return E * (1 / l + 11 * v1dmax / (l * v1dmin) + k3 / (5 * l))


def angle_share(k2: ca.SX, k3: ca.SX, v1dmin: ca.SX, v1dmax: ca.SX, printed: bool = False) -> ca.SX:
    """1 + 11 v1dmax/v1dmin + k3/5 of Eq. (51); as printed the middle term has a further k2."""
    return 1 + 11 * v1dmax / v1dmin * (k2 if printed else 1) + k3 / 5


def conditions(
    l: ca.SX, k: ca.SX, v1dmin: ca.SX, v1dmax: ca.SX, v2max: ca.SX, printed: bool = False
) -> ca.SX:
    """The six conditions on l before Eq. (40), each as a number that must be positive."""
    T, k2, k3 = window(l, k[1], v1dmin), k[1], k[2]
    drift = (11 * v2max + 10 * v1dmax * angle_bound(l, k3, v1dmin, v1dmax, ca.SX(1))) * T
    turn = k3 / (l * k2 * v1dmin)
    share = angle_share(k2, k3, v1dmin, v1dmax, printed)
    return ca.vertcat(
        l - 5, 1 - 5 * T, 1 - k3 / (k2 * l**2), 1 - 10 * turn, 2 - drift, 1 - 5 * turn * share
    )


def angle_rate_bound(l: ca.SX, k: ca.SX, v1d: ca.SX, sine: ca.SX, E: ca.SX) -> ca.SX:
    """-0.8 k2 v1d E + k3 (|sin e3| + E/l), times 5: Eq. (50) with e2 > 0.8 E."""
    return -4 * k[1] * v1d * E + 5 * k[2] * (sine + E / l)


def angle_after(l: ca.SX, e3: ca.SX, E: ca.SX) -> ca.SX:
    """e3(t0) - (3/l) E: bound of e3 from 3 T/5 on, Eq. (53); mirrored for e2 < 0, Eq. (54)."""
    return e3 - 3 * E / l


def mean_rise(T: ca.SX, eps1: ca.SX) -> ca.SX:
    """(3/5) T eps1 - (2/5) T 3 eps1: bound of V2's change over the window, Eq. (56), times 5."""
    return 3 * T * eps1 - 2 * T * 3 * eps1


def ball_radius(eps0: ca.SX, l: ca.SX, k: ca.SX) -> ca.SX:
    """Radius of Omega_1, and with eps3, eps4 of Omega_3, Eq. (61)."""
    rest = square_rest(eps0**2, eps0**2, k)
    ahead = ca.sqrt(rest / k[0]) + eps0 / (2 * k[0])
    return (1 + l) * (ahead + 2 * threshold(eps0, k))
