"""Friction of the ground, Eq. (4): its shape, its force, and the largest force and slope.

Everything that depends on the shape is in this module. `tests/world/model/test_friction.py` scans
the graph for both bounds, so that a new shape with old bounds is noticed.
"""

from __future__ import annotations

from wmr_ctrl.core.symbolic import ca

from .system import Number


def shape(v: ca.SX, v_s: ca.SX) -> ca.SX:
    """Signed share of the full friction at a speed ``v``; ``v_s`` smooths the step at 0."""
    return ca.tanh(v / v_s)


def friction(mu: ca.SX, m: ca.SX, g: ca.SX, v_s: ca.SX, v: ca.SX) -> ca.SX:
    """F1 [N, N m] of Eq. (4), read as Coulomb friction on the linear axis: mu m g tanh(v1/v_s).

    The paper gives only the coefficient mu; none is read into the rotation.
    """
    return ca.vertcat(mu * m * g * shape(v[0], v_s), 0)


def largest_force(mu: Number, m: Number, g: Number) -> Number:
    """Largest size of the force over all speeds [N]."""
    return mu * m * g


def largest_slope(mu: Number, m: Number, g: Number, v_s: Number) -> Number:
    """Largest slope of the force over the speed [N s/m]."""
    return mu * m * g / v_s
