"""The twelve panels, in the paper's order; Fig. 3 and Fig. 5 have the same ones."""

from __future__ import annotations

from collections.abc import Callable

from wmr_ctrl.report.panels.base import Panel
from wmr_ctrl.report.panels.logarithmic import Logarithmic, Plain
from wmr_ctrl.report.panels.traces import Trace
from wmr_ctrl.report.panels.trajectory import draw_trajectory
from wmr_ctrl.results import FloatArray, Run, distance


def _column(name: str) -> Callable[[Run], FloatArray]:
    return lambda run: run[name]


def _error(name: str) -> Callable[[Run], FloatArray]:
    """True pose less reference, unlike the body-frame errors of Eq. (8)."""
    return lambda run: run[name] - run[f"{name}_d"]


_V1 = Logarithmic("V₁", _column("V1"), floor=1e-6)
_LINEAR = Trace("v₁ [m/s]", _column("v1"), limit_axis=0, smooth=0.5, late=(-0.05, 1.15))
_ANGULAR = Trace("ω [rad/s]", _column("omega"), limit_axis=1, smooth=0.5, late=(-1.75, 1.75))
_X = Trace("$x - x_d$ [m]", _error("x"), early=5.0)
_Y = Trace("$y - y_d$ [m]", _error("y"), early=5.0)
_THETA = Trace("$θ - θ_d$ [rad]", _error("theta"), early=5.0, smooth=1.0)
_D = Logarithmic("d [m]", distance, floor=5e-4)
_RIGHT = Trace("τ₁, right [N m]", _column("tau_right"), early=2.0, smooth=1.0)
_LEFT = Trace("τ₂, left [N m]", _column("tau_left"), early=2.0, smooth=1.0)
_W1 = Plain("‖W₁‖", _column("W_norm[1]"))
_W2 = Plain("‖W₂‖", _column("W_norm[2]"))

PANELS = (
    Panel("a", "trajectory", "Trajectory", draw_trajectory),
    Panel("b", "lyapunov", "Lyapunov function values V₁", _V1.draw),
    Panel("c", "v1", "Linear velocity and its limit", _LINEAR.draw),
    Panel("d", "omega", "Angular velocity and its limits", _ANGULAR.draw),
    Panel("e", "x_error", "Error along X", _X.draw),
    Panel("f", "y_error", "Error along Y", _Y.draw),
    Panel("g", "theta_error", "Error of the orientation", _THETA.draw),
    Panel("h", "distance", "Distance from the desired position", _D.draw),
    Panel("i", "tau_right", "Torque of the right wheel", _RIGHT.draw),
    Panel("j", "tau_left", "Torque of the left wheel", _LEFT.draw),
    Panel("k", "weights_1", "Norm of the weights, linear axis", _W1.draw, laws=("nn",)),
    Panel("l", "weights_2", "Norm of the weights, angular axis", _W2.draw, laws=("nn",)),
)
"""Panels (a) to (l)."""
