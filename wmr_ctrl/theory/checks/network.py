"""Stability of the network's learning: a wide network learns faster than its loop can follow."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache

import casadi as ca
import numpy as np

from wmr_ctrl.control.laws.nn import NetworkGains, corner_basis
from wmr_ctrl.results.verdicts import Warning

from .loop import PERIOD, Loop
from .radius import operating_points
from .warning import SPEEDS

NARROW = 1e-3
"""Share of a network's width at which it hardly answers: |S|^2 grows with the width."""


def network(loop: Loop) -> Iterator[Warning]:
    """Yield instabilities of learning, by the network's width and by the control period."""
    if isinstance(loop.setup.gains, NetworkGains):
        yield from unstable_width(loop)
        yield from learning_too_fast(loop)


def unstable_width(loop: Loop) -> Iterator[Warning]:
    """Yield the axes on which learning is unstable for a frozen regressor, as one warning.

    Per axis the linear loop is s^3 + a s^2 + (b + a K) s + b K with a = rho1/(2 M1), K the gain of
    Eq. (7), b = Gamma |S|^2/M1.  Its phase is too small because Eq. (57) lacks the feed-forward.
    """
    from scipy.optimize import brentq  # slow to import, and only for this law

    gains = loop.setup.own(NetworkGains)
    size = largest_square(loop, gains.eta)
    for axis in (1, 0):
        bound = square_bound(loop, axis)
        if size > bound:
            ends = NARROW * gains.eta, gains.eta
            widest = brentq(lambda eta: largest_square(loop, eta) - bound, *ends)  # noqa: B023
            learning = axis_learning(loop, axis)
            needed = 2 * learning.mass * learning.kinematic
            yield Warning(
                "gains.nn.eta",
                f"gains.nn.eta = {gains.eta:.4g} makes the network's |S|^2 = {size:.3g} on the "
                f"reference, above {bound:.3g}: learning of {SPEEDS[axis]} is then unstable, in "
                f"small bursts. Choose eta below {widest:.4g} (eta^2 below {widest**2:.4g}), or "
                f"gains.nn.rho1[{axis + 1}] above {needed:.3g}.",
                "Eqs. (57), (58), linearised",
            )
            return


def learning_too_fast(loop: Loop) -> Iterator[Warning]:
    """Yield the axis whose weights' Euler steps are unstable at the control period."""
    size = largest_square(loop, loop.setup.own(NetworkGains).eta)
    limits = [learning_limit(loop, axis, size) for axis in (0, 1)]
    axis, period = int(np.argmin(limits)), loop.scenario.clock.control
    if period >= limits[axis]:
        yield Warning(
            PERIOD,
            f"clock.control = {period:g} s is above {limits[axis]:.3g} s, where the steps of the "
            f"weights of {SPEEDS[axis]} are unstable at |S|^2 = {size:.3g}: shorten clock.control, "
            f"or lower gains.nn.Gamma[{axis + 1}] or gains.nn.eta.",
            "Eq. (58), by Euler steps",
        )


@dataclass(frozen=True)
class AxisLearning:
    """Parameters of one axis' velocity loop and weights: Eqs. (57), (58) linearised.

    a = rho1/(2 M1) [1/s], the mass M1, Gamma, the leak Gamma sigma [1/s] and the gain K of Eq. (7).
    """

    a: float
    mass: float
    gamma: float
    leak: float
    kinematic: float


def axis_learning(loop: Loop, axis: int) -> AxisLearning:
    """The learning parameters of axis 0 or 1."""
    gains, robot, k = loop.setup.own(NetworkGains), loop.scenario.robot, loop.setup.kinematics.k
    mass, gamma = (robot.m, robot.I)[axis], gains.Gamma[axis]
    a = gains.rho1[axis] / (2 * mass)
    return AxisLearning(a, mass, gamma, gains.sigma[axis] * gamma, k[2 * axis])


def learning_limit(loop: Loop, axis: int, size: float) -> float:
    """Longest period [s] that is stable for velocity and weights of axis 0 or 1.

    ``size`` is |S|^2.

    v' = -a v + W'S/M1 over a held torque, then W'S falls by T (Gamma |S|^2 v + leak W'S).  The
    product of both eigenvalues exceeds 1 beyond this T. The kinematic loop is neglected.
    """
    n = axis_learning(loop, axis)
    b = n.gamma * size / n.mass
    if loop.setup.own(NetworkGains).integrator == "explicit":
        b += n.a * n.leak
    return (n.a + n.leak) / b if b > 0 else math.inf


def largest_square(loop: Loop, eta: float) -> float:
    """Largest |S|^2 over the reference, at Z = (0, 0, 1, 1, v_d), where A/(v - v_c1) is 1."""
    points = operating_points(loop.scenario)
    each = (np.concatenate(((0.0, 0.0, 1.0, 1.0), v_d)) for v_d in points)
    return max(float(_square_of()(z, eta, loop.setup.own(NetworkGains).node)) for z in each)


def square_bound(loop: Loop, axis: int) -> float:
    """|S|^2 above which axis 0 or 1 is unstable; inf if rho1 is large enough for any network."""
    n = axis_learning(loop, axis)
    if n.a >= n.kinematic or n.gamma == 0:
        return math.inf
    return n.a * n.a * n.kinematic / (n.kinematic - n.a) * n.mass / n.gamma


@cache
def _square_of() -> ca.Function:
    z, eta, node = ca.SX.sym("z", 6), ca.SX.sym("eta"), ca.SX.sym("node")
    return ca.Function("square", [z, eta, node], [ca.sumsqr(corner_basis(z, eta, node))])
