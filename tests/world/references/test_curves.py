"""References in closed form, and what they are where nobody sizes them."""

import math

import casadi as ca
import pytest

from wmr_ctrl.world.references.curves import (
    circle,
    lemniscate,
    line,
)


def test_curves_are_their_formulas():
    """Radius 2 m, 0.5 rad/s for 3 s; a line along (-sin, cos); an eight of 1.5 m."""
    found = ca.evalf(circle(ca.SX(3.0), {"ref_radius": ca.SX(2.0), "ref_rate": ca.SX(0.5)}))
    x, y = 2 * math.sin(1.5), 2 - 2 * math.cos(1.5)
    assert found.full().ravel() == pytest.approx([x, y, 1.5 - math.pi / 2, 1.0, 0.5, 0, 0])

    own = {"ref_speed": ca.SX(0.2), "ref_heading": ca.SX(0.3), "ref_origin": ca.SX([1.0, -1.0])}
    found = ca.evalf(line(ca.SX(5.0), own)).full().ravel()
    assert found[:2] == pytest.approx([1 - math.sin(0.3), -1 + math.cos(0.3)])
    assert found[2:] == pytest.approx([0.3, 0.2, 0, 0, 0])

    found = ca.evalf(lemniscate(ca.SX(3.0), {"ref_size": ca.SX(1.5), "ref_rate": ca.SX(0.5)}))
    assert found.full()[:2, 0] == pytest.approx([1.5 * x / 2, 1.5 * x / 2 * math.cos(1.5)])
