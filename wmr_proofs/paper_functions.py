"""The paper's functions that no run evaluates, as graphs: Lyapunov functions, bounds, matrices.

They are Eqs. (1), (2), (4), (31), (62) and similar ones, and the proof of Theorem 1's, Eqs.
(39)-(56).  None is compiled to C: there is one function for each equation that only proofs about
the laws use, in the paper's letters, on the same symbols as the laws' own graphs.

For Theorem 1: whole-number coefficients (10 x < 2 for x < 0.2) keep every constant exact.  E is
|e2| at the start t0 of the window of length T; v1dmin <= v1d <= v1dmax; l > 5 is the proof's large
number.
"""

import itertools

from casadi import (
    DM,
    SX,
    cos,
    diag,
    eq,
    exp,
    fmax,
    fmin,
    horzcat,
    if_else,
    jtimes,
    log,
    sin,
    sqrt,
    substitute,
    sumsqr,
    vertcat,
)

from wmr_ctrl.control.barrier.proximal import resolvent
from wmr_ctrl.world.model.kinematics import auxiliary_velocity, error_rate

from .paper_barrier import a_term, f, lyapunov, minimiser


def velocity_map(theta: SX) -> SX:
    """H(q), 3x2, Eq. (5): q' = H v with v = (v1, omega), Eq. (6) (printed transposed)."""
    return vertcat(horzcat(-sin(theta), 0), horzcat(cos(theta), 0), horzcat(0, 1))


def constraint(theta: SX) -> SX:
    """A(q), 3x1, Eq. (3): A' q' = 0, no sideways motion (printed as A q' = 0)."""
    return vertcat(cos(theta), sin(theta), 0)


def total_barrier(v: SX, c: SX, u1: SX, u2: SX) -> SX:
    """V1 of Eq. (19): the sum of V1i over the two axes; all arguments (2,)."""
    return lyapunov(v[0], c[0], u1[0], u2[0]) + lyapunov(v[1], c[1], u1[1], u2[1])


def smooth_f(v: SX, u1: SX, u2: SX) -> SX:
    """f of the smooth barrier: that of Eq. (15) less its tangent at u2 (not in the paper)."""
    return f(v, u1, u2) - fmax(abs(v) - u2, 0) / (u1 - u2)


def smooth_lyapunov(v: SX, c: SX, u1: SX, u2: SX) -> SX:
    """V1i of Eq. (20) with that f."""
    x = resolvent(c, SX(1), u1, u2, smooth=True)
    least = 0.5 * (x - c) ** 2 + smooth_f(x, u1, u2)
    return 0.5 * (v - c) ** 2 + smooth_f(v, u1, u2) - least


def position_lyapunov(e: SX, k2: SX) -> SX:
    """V2 of Eq. (31): (e1^2 + e2^2)/2 + (1 - cos e3)/k2 [m^2]."""
    return 0.5 * (e[0] ** 2 + e[1] ** 2) + (1 - cos(e[2])) / k2


def position_rate(e: SX, v: SX, v_d: SX, k2: SX) -> SX:
    """V2' of Eq. (32), by differentiation along Eqs. (33)-(35) [m^2/s]."""
    symbol = SX.sym("e", 3)
    rate = jtimes(position_lyapunov(symbol, k2), symbol, error_rate(e, v, v_d))
    return substitute(rate, symbol, e)


def position_rate_bound(e: SX, z: SX, k: SX) -> SX:
    """The completed squares of Eq. (38), without their remainder: see `square_rest`."""
    return (
        -k[0] * (e[0] + z[0] / (2 * k[0])) ** 2 - k[2] / k[1] * (sin(e[2]) + z[1] / (2 * k[2])) ** 2
    )


def square_rest(z1_squared: SX, z2_squared: SX, k: SX) -> SX:
    """z1^2/(4 k1) + z2^2/(4 k2 k3): the rest in Eq. (38), and eps1 of Eq. (39) for |z| = eps0."""
    return z1_squared / (4 * k[0]) + z2_squared / (4 * k[1] * k[2])


def target_rate(c: SX, c_dot: SX, u1: SX, u2: SX) -> SX:
    """v_c1' = (dv_c1/dv_c0) v_c0', used in Eqs. (23), (24)."""
    symbol = SX.sym("c")
    return substitute(jtimes(minimiser(symbol, u1, u2), symbol, c_dot), symbol, c)


def printed_command(rho: SX, v: SX, c: SX, c_dot: SX, u1: SX, u2: SX) -> SX:
    """The bracket of Eq. (9) as printed: A^- (-rho V1i + (v - v_c1) v_c0'), A^- = 0 where A = 0."""
    a = a_term(v, c, u1, u2)
    zero = eq(a, 0)
    inverse = if_else(zero, 0, 1 / if_else(zero, 1, a))
    return inverse * (-rho * lyapunov(v, c, u1, u2) + (v - minimiser(c, u1, u2)) * c_dot)


def network_lyapunov(v1i: SX, mass: SX, gamma: SX, weight_error: SX) -> SX:
    """V3i of Eqs. (62), (64): V1i + W~' W~/(2 M1ii Gamma_i), one axis."""
    return v1i + 0.5 * sumsqr(weight_error) / (mass * gamma)


def network_target(mass: SX, c_dot: SX, ratio: SX, friction: SX) -> SX:
    """Target of the network, Eq. (59): M1 v_c0' + (A/(v - v_c1)) F1, one axis [N or N m]."""
    return mass * c_dot + ratio * friction


def decay_rate(rho1: SX, mass: SX, sigma: SX, gamma: SX) -> SX:
    """rho2 of Eq. (86) [1/s], two axes; (rho1_i - 1)/M1ii where rho1 is a vector."""
    first = fmin((rho1[0] - 1) / mass[0], (rho1[1] - 1) / mass[1])
    return fmin(first, fmin(sigma[0] * gamma[0], sigma[1] * gamma[1]))


def leftover(eps2: SX, sigma: SX, weight: SX, mass: SX) -> SX:
    """C_i of Eq. (87): (eps2^2 + sigma_i |W*_i|^2)/(2 M1ii); C3 of Eq. (88) is their sum."""
    return 0.5 * eps2**2 / mass + 0.5 * sigma * sumsqr(weight) / mass


def strict_lyapunov(e: SX, k2: SX, eps: SX) -> SX:
    """V2 + eps e2 sin e3: decreases wherever e is not 0, near e = 0 (not in the paper)."""
    return position_lyapunov(e, k2) + eps * e[1] * sin(e[2])


def strict_rate(e: SX, v_d: SX, k: SX, eps: SX) -> SX:
    """Rate of `strict_lyapunov` along Eqs. (33)-(35), v = v_c0 of Eq. (7) (not in the paper)."""
    symbol = SX.sym("e", 3)
    direction = error_rate(e, auxiliary_velocity(e, v_d, k), v_d)
    return substitute(jtimes(strict_lyapunov(symbol, k[1], eps), symbol, direction), symbol, e)


def authority_limit(s: SX) -> SX:
    """s (s - 1 - ln s)/(1 - s), s = (u1 - |v|)/(u1 - |v_c1|): (|v_c0| - u1) V1i/A_i far away.

    Its maximum over 0 < s < 1, about 0.2162, times rho is the disturbance that the barrier
    withstands there (not in the paper).
    """
    return s * (s - 1 - log(s)) / (1 - s)


def window(l: SX, k2: SX, v1dmin: SX) -> SX:
    """T = 10/(l k2 v1dmin) [s], before Eq. (40)."""
    return 10 / (l * k2 * v1dmin)


def threshold(eps0: SX, k: SX) -> SX:
    """sqrt(k2 eps1/k3) + eps0/(2 k3): |sin e3| beyond it makes V2' < 0, after Eq. (39)."""
    return sqrt(k[1] * square_rest(eps0**2, eps0**2, k) / k[2]) + eps0 / (2 * k[2])


def start_bound(l: SX, k2: SX, e2: SX) -> SX:
    """((k2 + 1)/(2 k2 l^2) + 1/2) e2^2, Eq. (40)."""
    return ((k2 + 1) / (2 * k2 * l**2) + 0.5) * e2**2


def angle_bound(l: SX, k3: SX, v1dmin: SX, v1dmax: SX, E: SX) -> SX:
    """E (1/l + 11 v1dmax/(l v1dmin) + k3/(5 l)): upper bound of |e3|, Eq. (47)."""
    return E * (1 / l + 11 * v1dmax / (l * v1dmin) + k3 / (5 * l))


def angle_share(k2: SX, k3: SX, v1dmin: SX, v1dmax: SX, printed: bool = False) -> SX:
    """1 + 11 v1dmax/v1dmin + k3/5 of Eq. (51); as printed the middle term has a further k2."""
    return 1 + 11 * v1dmax / v1dmin * (k2 if printed else 1) + k3 / 5


def conditions(l: SX, k: SX, v1dmin: SX, v1dmax: SX, v2max: SX, printed: bool = False) -> SX:
    """The six conditions on l before Eq. (40), each as a number that must be positive."""
    T, k2, k3 = window(l, k[1], v1dmin), k[1], k[2]
    drift = (11 * v2max + 10 * v1dmax * angle_bound(l, k3, v1dmin, v1dmax, SX(1))) * T
    turn = k3 / (l * k2 * v1dmin)
    share = angle_share(k2, k3, v1dmin, v1dmax, printed)
    return vertcat(
        l - 5, 1 - 5 * T, 1 - k3 / (k2 * l**2), 1 - 10 * turn, 2 - drift, 1 - 5 * turn * share
    )


def angle_rate_bound(l: SX, k: SX, v1d: SX, sine: SX, E: SX) -> SX:
    """-0.8 k2 v1d E + k3 (|sin e3| + E/l), times 5: Eq. (50) with e2 > 0.8 E."""
    return -4 * k[1] * v1d * E + 5 * k[2] * (sine + E / l)


def angle_after(l: SX, e3: SX, E: SX) -> SX:
    """e3(t0) - (3/l) E: bound of e3 from 3 T/5 on, Eq. (53); mirrored for e2 < 0, Eq. (54)."""
    return e3 - 3 * E / l


def mean_rise(T: SX, eps1: SX) -> SX:
    """(3/5) T eps1 - (2/5) T 3 eps1: bound of V2's change over the window, Eq. (56), times 5."""
    return 3 * T * eps1 - 2 * T * 3 * eps1


def ball_radius(eps0: SX, l: SX, k: SX) -> SX:
    """Radius of Omega_1, and with eps3, eps4 of Omega_3, Eq. (61)."""
    ahead = sqrt(square_rest(eps0**2, eps0**2, k) / k[0]) + eps0 / (2 * k[0])
    return (1 + l) * (ahead + 2 * threshold(eps0, k))


def mass_matrix(m: SX, inertia: SX) -> SX:
    """M = diag(m, m, I), Eq. (2)."""
    return diag(vertcat(m, m, inertia))


def input_matrix(theta: SX, r: SX, half_track: SX) -> SX:
    """B(q), 3x2, Eq. (1): wheel torques (right, left) to forces along x, y and the moment."""
    s, c = sin(theta), cos(theta)
    return vertcat(horzcat(-s, -s), horzcat(c, c), horzcat(half_track, -half_track)) / r


def projected(theta: SX, m: SX, inertia: SX, r: SX, half_track: SX) -> tuple[SX, SX]:
    """(H' M H, H' B), Eq. (4): from which `dynamics.reduced_mass` and `wheel_to_force` result."""
    h = velocity_map(theta)
    return h.T @ mass_matrix(m, inertia) @ h, h.T @ input_matrix(theta, r, half_track)


def corner_centres(dimensions: int, node: float) -> list[tuple[float, ...]]:
    """Centres in the order of `corner_basis`: the first dimension varies slowest, -node first."""
    return list(itertools.product((-node, node), repeat=dimensions))


def gaussian_basis(z: SX, eta: SX, centres: list[tuple[float, ...]]) -> SX:
    """S(Z) by its definition, one exponential per node, which `corner_basis` must equal."""
    return vertcat(*(exp(-sumsqr(z - DM(centre)) / (eta * eta)) for centre in centres))
