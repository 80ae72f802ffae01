"""The network's own loop: one axis, velocity only, with the regressor S held still.

With w = v - v_c1 and y = W'S, Eqs. (57), (58) give

    w' = -a w + y/M1,    y' = -Gamma |S|^2 w - Gamma sigma y,    a = rho1/(2 M1).

In continuous time that is always stable.  Sampled, it is not; and closed around the kinematics
(v_c0' = -K w - ..., which Eq. (57) does not feed forward) it is unstable even in continuous time
where a < K and |S|^2 is large enough: see `largest_stable_square`.
"""

from __future__ import annotations

from collections.abc import Callable

import control as ct
import numpy as np

from wmr_ctrl.control.laws.nn import NetworkGains
from wmr_ctrl.theory.checks.network import axis_learning, largest_square, square_bound
from wmr_ctrl.theory.checks.radius import radius, supremum
from wmr_ctrl.theory.linear.linearise import Floats, law_loop
from wmr_ctrl.world.scenario import Scenario

LAW = "nn"


def regressor_square(scenario: Scenario) -> float:
    """|S|^2 on the reference, where the ratio A/(v - v_c1) is 1."""
    loop = law_loop(scenario, LAW)
    return largest_square(loop, loop.setup.own(NetworkGains).eta)


def learning_periods(scenario: Scenario, square: float | None = None) -> Floats:
    """Largest stable period (2) [s] of the velocity loop with explicit-Euler weights, |S|^2 held.

    ``square`` is |S|^2; by default that of the reference.
    """
    size = regressor_square(scenario) if square is None else square

    def of(axis: int) -> Callable[[float], float]:
        return lambda period: radius(learning_step(scenario, axis, size, period))

    return np.array([supremum(of(axis)) for axis in (0, 1)])


def learning_step(scenario: Scenario, axis: int, square: float, period: float) -> Floats:
    """Matrix of (w, y) over one sample: the held force, then the weights' explicit Euler step."""
    n = axis_learning(law_loop(scenario, LAW), axis)
    return np.array(
        [[1 - n.a * period, period / n.mass],
         [-period * n.gamma * square, 1 - period * n.leak]]
    )  # fmt: skip


def frozen_regressor(scenario: Scenario, axis: int, square: float) -> ct.StateSpace:
    """Velocity loop, weights and kinematics of one axis, continuous, with |S|^2 held and v_d = 0.

    States: the kinematic error (e1 or e3), w, y.  v_c0 = K e and e' = -v = -(w + K e).
    """
    n = axis_learning(law_loop(scenario, LAW), axis)
    k = n.kinematic
    matrix = np.array(
        [[-k, -1.0, 0.0], [k * k, k - n.a, 1 / n.mass], [0.0, -n.gamma * square, -n.leak]]
    )
    push = np.array([[0.0], [1 / n.mass], [0.0]])
    return ct.ss(
        matrix, push, np.eye(3), np.zeros((3, 1)), name="frozen regressor",
        states=["error", "w", "y"], inputs=["disturbance"], outputs=["error", "w", "y"],
    )  # fmt: skip


def largest_stable_square(scenario: Scenario, axis: int) -> float:
    """|S|^2 above which learning is unstable in continuous time, leak left out; inf if never."""
    return square_bound(law_loop(scenario, LAW), axis)
