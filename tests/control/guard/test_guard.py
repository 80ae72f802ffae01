"""The guard's own graph: box, maps, monitor, and its generated C in exact arithmetic."""

import math

import casadi as ca
import numpy as np
import pytest

from wmr_ctrl.control.guard.guard import MAPS, Bounds, ceiling, clipped, feasible, floor

NAMES = ("u1", "period", "M_min", "M_max", "dbar", "nbar", "alpha", "brake", "f_min", "f_speed")
BOUNDS = Bounds(**{name: ca.SX.sym(name) for name in NAMES})
SYMBOLS = ca.vertcat(*(getattr(BOUNDS, name) for name in NAMES))
ASKED, Y = ca.SX.sym("asked"), ca.SX.sym("y")
ONE_AXIS = ca.Function("axis", [ASKED, Y, SYMBOLS], [clipped(ASKED, Y, BOUNDS)])
BOX = ca.Function("box", [Y, SYMBOLS], [floor(Y, BOUNDS), ceiling(Y, BOUNDS), feasible(BOUNDS)])
SHRUNK = 1 - 2.0**-44


def drawn(draw):
    """Feasible numbers of one axis in the order of NAMES, and the limit that they serve."""
    u1, period = 10 ** draw.uniform(-1, 1), 10 ** draw.uniform(-3.5, 0)
    low = 10 ** draw.uniform(-1, 2.5)
    high = low * draw.uniform(1, 4)
    alpha = draw.choice([1.0, draw.uniform(0.05, 1.0)]) / period
    f_speed = u1 * draw.choice([0.0, draw.uniform(0, 0.4)])
    most = low * alpha * (u1 * SHRUNK - f_speed) / 2
    net = most * draw.choice([1 - 1e-12, draw.uniform(0, 1), 0.0])
    f_min = net * draw.choice([0.0, draw.uniform(0, 1)])
    brake = draw.choice([1e30, net + (2 * most - 2 * net) * draw.uniform(0, 1)])
    nbar = u1 / 2 * draw.choice([0.0, draw.uniform(0, 0.999)])
    numbers = (u1 * SHRUNK, period, low, high, net + f_min, nbar, alpha, brake, f_min, f_speed)
    return np.array(numbers), u1


def test_box_is_never_empty():
    draw = np.random.default_rng(2)
    for _ in range(3000):
        row, u1 = drawn(draw)
        low, high, possible = (float(item) for item in BOX(draw.normal() * u1, row))
        assert low <= high
        assert possible == 1.0


@pytest.mark.parametrize(
    "name, value",
    [("dbar", 1e9), ("nbar", 0.51), ("alpha", 100.1), ("brake", 5.0), ("M_max", 1.0)],
)
def test_bounds_that_cannot_be_met_are_flagged(name, value):
    row = np.array([1.0, 0.01, 45.0, 70.0, 60.0, 0.0, 100.0, 400.0, 0.0, 0.0])
    assert float(BOX(0.0, row)[2]) == 1.0
    row[NAMES.index(name)] = value
    assert float(BOX(0.0, row)[2]) == 0.0


def test_a_force_that_is_no_number_becomes_a_safe_one():
    row = np.array([1.0, 0.01, 45.0, 70.0, 60.0, 0.0, 100.0, 400.0, 0.0, 0.0])
    low, high, _ = (float(item) for item in BOX(0.9, row))

    assert low <= float(ONE_AXIS(math.nan, 0.9, row)) <= high


def test_safe_force_inside_the_box_is_left_alone():
    row = np.array([1.0, 0.01, 45.0, 70.0, 60.0, 0.0, 100.0, 1e30, 0.0, 0.0])

    assert float(ONE_AXIS(123.456, 0.3, row)) == 123.456


@pytest.mark.parametrize("name", MAPS)
def test_maps_end_in_the_box_and_in_reach(name):
    draw, half, reach = np.random.default_rng(3), 0.25, 150.0
    force, safe = ca.SX.sym("f", 2), ca.SX.sym("s", 2)
    mapped = ca.Function("map", [force, safe], [MAPS[name](force, reach, ca.SX(half), safe)])
    for _ in range(2000):
        low, high = np.sort(draw.normal(size=(2, 2)) * (100, 25), axis=0)
        near, asked = np.clip(0.0, low, high), draw.uniform(low, high)
        if abs(near[0]) + abs(near[1]) / half <= reach:
            found = mapped(asked, near).full().ravel()
            assert (np.clip(found, low - 1e-12, high + 1e-12) == found).all()
            assert abs(found[0]) + abs(found[1]) / half <= reach * (1 + 1e-15)
            if abs(asked[0]) + abs(asked[1]) / half <= reach:
                assert found == pytest.approx(asked)
