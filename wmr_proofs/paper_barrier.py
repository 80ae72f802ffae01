"""The barrier Lyapunov function as the paper defines it, Eqs. (10)-(20), one axis at a time.

These are definitions: short, literal, and numerically poor (V1 is a difference of large numbers,
A vanishes at the target).  The laws use `stable_barrier`, whose equality with this page is proved
and tested.  Notation: c = v_c0, v the velocity, u1 = v_u1 the limit, u2 = v_u2 where the barrier
begins.
"""

from casadi import SX, if_else, log, sqrt


def sign(value: SX) -> SX:
    """sgn with sgn(0) = +1, so that no target is lost at 0."""
    return if_else(value >= 0, 1, -1)


def h(v: SX, u2: SX) -> SX:
    """h of Eq. (11): 1 where |v| > u2, else 0."""
    return abs(v) > u2


def a_term(v: SX, c: SX, u1: SX, u2: SX) -> SX:
    """A of Eq. (10), dV1/dv off the kink: v - c + sgn(v) h(v)/(u1 - |v|)."""
    return v - c + if_else(h(v, u2), sign(v) / (u1 - abs(v)), 0)


def f(v: SX, u1: SX, u2: SX) -> SX:
    """f of Eqs. (14), (15): -ln((u1 - |v|)/(u1 - u2)) where |v| > u2, else 0."""
    return -log(if_else(h(v, u2), (u1 - abs(v)) / (u1 - u2), 1))


def minimiser(c: SX, u1: SX, u2: SX) -> SX:
    """v_c1 of Eqs. (17), (18): the unique minimiser of (v - c)^2/2 + f(v)."""
    size, s = abs(c), sign(c)
    far = (size + u1 - sqrt((size - u1) ** 2 + 4)) / 2
    return if_else(size <= u2, c, s * if_else(size <= u2 + 1 / (u1 - u2), u2, far))


def g(c: SX, u1: SX, u2: SX) -> SX:
    """g of Eq. (16): minus the minimum, -((v_c1 - c)^2/2 + f(v_c1))."""
    x = minimiser(c, u1, u2)
    return -(0.5 * (x - c) ** 2 + f(x, u1, u2))


def lyapunov(v: SX, c: SX, u1: SX, u2: SX) -> SX:
    """V1i of Eqs. (12), (13), (19), (20): z^2/2 + f(v) + g(c) with z = v - c."""
    return 0.5 * (v - c) ** 2 + f(v, u1, u2) + g(c, u1, u2)
