"""Lyapunov functions and rates of the paper that no law evaluates, as graphs: Eqs. (31), (62).

Nothing here becomes C.  These are the homes of equations that exist to prove something about the
laws: one function each, in the paper's letters, on the same symbols as the laws' own graphs.
"""

from __future__ import annotations

import casadi as ca

from wmr_ctrl.barrier.paper import a_term, f, lyapunov, minimiser
from wmr_ctrl.barrier.resolvent import resolvent
from wmr_ctrl.model.auxiliary import auxiliary_velocity
from wmr_ctrl.model.tracking import error_rate


def total_barrier(v: ca.SX, c: ca.SX, u1: ca.SX, u2: ca.SX) -> ca.SX:
    """V1 of Eq. (19): the sum of V1i over the two axes; all arguments (2,)."""
    return lyapunov(v[0], c[0], u1[0], u2[0]) + lyapunov(v[1], c[1], u1[1], u2[1])


def smooth_f(v: ca.SX, u1: ca.SX, u2: ca.SX) -> ca.SX:
    """f of the smooth barrier: that of Eq. (15) less its tangent at u2 (not in the paper)."""
    return f(v, u1, u2) - ca.fmax(ca.fabs(v) - u2, 0) / (u1 - u2)


def smooth_lyapunov(v: ca.SX, c: ca.SX, u1: ca.SX, u2: ca.SX) -> ca.SX:
    """V1i of Eq. (20) with that f."""
    x = resolvent(c, ca.SX(1), u1, u2, smooth=True)
    least = 0.5 * (x - c) ** 2 + smooth_f(x, u1, u2)
    return 0.5 * (v - c) ** 2 + smooth_f(v, u1, u2) - least


def position_lyapunov(e: ca.SX, k2: ca.SX) -> ca.SX:
    """V2 of Eq. (31): (e1^2 + e2^2)/2 + (1 - cos e3)/k2 [m^2]."""
    return 0.5 * (e[0] ** 2 + e[1] ** 2) + (1 - ca.cos(e[2])) / k2


def position_rate(e: ca.SX, v: ca.SX, v_d: ca.SX, k2: ca.SX) -> ca.SX:
    """V2' of Eq. (32), by differentiation along Eqs. (33)-(35) [m^2/s]."""
    symbol = ca.SX.sym("e", 3)
    rate = ca.jtimes(position_lyapunov(symbol, k2), symbol, error_rate(e, v, v_d))
    return ca.substitute(rate, symbol, e)


def position_rate_bound(e: ca.SX, z: ca.SX, k: ca.SX) -> ca.SX:
    """The completed squares of Eq. (38), without what they leave over: see `square_rest`."""
    return (
        -k[0] * (e[0] + z[0] / (2 * k[0])) ** 2
        - k[2] / k[1] * (ca.sin(e[2]) + z[1] / (2 * k[2])) ** 2
    )


def square_rest(z1_squared: ca.SX, z2_squared: ca.SX, k: ca.SX) -> ca.SX:
    """z1^2/(4 k1) + z2^2/(4 k2 k3): the rest in Eq. (38), and eps1 of Eq. (39) for |z| = eps0."""
    return z1_squared / (4 * k[0]) + z2_squared / (4 * k[1] * k[2])


def target_rate(c: ca.SX, c_dot: ca.SX, u1: ca.SX, u2: ca.SX) -> ca.SX:
    """v_c1' = (dv_c1/dv_c0) v_c0', used in Eqs. (23), (24)."""
    symbol = ca.SX.sym("c")
    return ca.substitute(ca.jtimes(minimiser(symbol, u1, u2), symbol, c_dot), symbol, c)


def printed_command(rho: ca.SX, v: ca.SX, c: ca.SX, c_dot: ca.SX, u1: ca.SX, u2: ca.SX) -> ca.SX:
    """The bracket of Eq. (9) as printed: A^- (-rho V1i + (v - v_c1) v_c0'), A^- = 0 where A = 0."""
    a = a_term(v, c, u1, u2)
    zero = ca.eq(a, 0)
    inverse = ca.if_else(zero, 0, 1 / ca.if_else(zero, 1, a))
    return inverse * (-rho * lyapunov(v, c, u1, u2) + (v - minimiser(c, u1, u2)) * c_dot)


def network_lyapunov(v1i: ca.SX, mass: ca.SX, gamma: ca.SX, weight_error: ca.SX) -> ca.SX:
    """V3i of Eqs. (62), (64): V1i + W~' W~/(2 M1ii Gamma_i), one axis."""
    return v1i + 0.5 * ca.sumsqr(weight_error) / (mass * gamma)


def network_target(mass: ca.SX, c_dot: ca.SX, ratio: ca.SX, friction: ca.SX) -> ca.SX:
    """What the network is to give, Eq. (59): M1 v_c0' + (A/(v - v_c1)) F1, one axis [N or N m]."""
    return mass * c_dot + ratio * friction


def decay_rate(rho1: ca.SX, mass: ca.SX, sigma: ca.SX, gamma: ca.SX) -> ca.SX:
    """rho2 of Eq. (86) [1/s], two axes; (rho1_i - 1)/M1ii where rho1 is a vector."""
    first = ca.fmin((rho1[0] - 1) / mass[0], (rho1[1] - 1) / mass[1])
    return ca.fmin(first, ca.fmin(sigma[0] * gamma[0], sigma[1] * gamma[1]))


def leftover(eps2: ca.SX, sigma: ca.SX, weight: ca.SX, mass: ca.SX) -> ca.SX:
    """C_i of Eq. (87): (eps2^2 + sigma_i |W*_i|^2)/(2 M1ii); C3 of Eq. (88) is their sum."""
    return 0.5 * eps2**2 / mass + 0.5 * sigma * ca.sumsqr(weight) / mass


def strict_lyapunov(e: ca.SX, k2: ca.SX, eps: ca.SX) -> ca.SX:
    """V2 + eps e2 sin e3: decreases wherever e is not 0, near e = 0 (not in the paper)."""
    return position_lyapunov(e, k2) + eps * e[1] * ca.sin(e[2])


def strict_rate(e: ca.SX, v_d: ca.SX, k: ca.SX, eps: ca.SX) -> ca.SX:
    """Its rate along Eqs. (33)-(35) with v = v_c0 of Eq. (7) (not in the paper)."""
    symbol = ca.SX.sym("e", 3)
    direction = error_rate(e, auxiliary_velocity(e, v_d, k), v_d)
    rate = ca.jtimes(strict_lyapunov(symbol, k[1], eps), symbol, direction)
    return ca.substitute(rate, symbol, e)


def authority_limit(s: ca.SX) -> ca.SX:
    """s (s - 1 - ln s)/(1 - s), s = (u1 - |v|)/(u1 - |v_c1|): (|v_c0| - u1) V1i/A_i far away.

    Its maximum over 0 < s < 1, about 0.2162, times rho is what the barrier withstands there (not in
    the paper).
    """
    return s * (s - 1 - ca.log(s)) / (1 - s)
