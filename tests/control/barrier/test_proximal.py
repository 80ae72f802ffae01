"""The level transport and the step behind it, against a barrier in 50-digit arithmetic."""

import casadi as ca
import numpy as np
import pytest

from wmr_ctrl.control.barrier.proximal import transported
from wmr_ctrl.control.laws.prox import prox_step

LIMITS = ((1.0, 0.8), (1.5, 1.3), (0.7, 0.2))
EPS = float(np.finfo(float).eps)
every_axis = pytest.mark.parametrize(
    "axis", [(*limits, smooth) for limits in LIMITS for smooth in (False, True)]
)
v, c, c_m, c_next, E = (ca.SX.sym(name) for name in ("v", "c", "c_m", "c_next", "E"))


def step(axis):
    """(v, c, c_m, c+, E) to (v*, v+)."""
    limits = (ca.SX(axis[0]), ca.SX(axis[1]))
    start = transported(v, c, c_m, limits, axis[2])
    end = prox_step(v, (c, c_m, c_next), (E, 1 - E), limits, axis[2])
    return ca.Function("step", [v, c, c_m, c_next, E], [start, end])


def x_of(c, axis):
    """v_c1 in extended precision."""
    u1, u2 = map(np.longdouble, axis[:2])
    size = np.abs(c.astype(np.longdouble))
    t = size - u1 + (1 / (u1 - u2) if axis[2] else 0)
    far = u1 - 2 / (t + np.sqrt(t * t + 4))
    flat = size <= (u2 if axis[2] else u2 + 1 / (u1 - u2))
    return np.sign(c) * np.where(size <= u2, size, np.where(flat, u2, far))


@every_axis
@pytest.mark.slow_but("axis0", "axis5")
def test_w_falls_and_the_limit_is_kept_from_every_speed(axis):
    """|w+| <= E (|w| + |c+ - c_m|) and |v+| <= v_u1; v* = v for a constant target."""
    count, u1 = 20_000, axis[0]
    draw = np.random.default_rng(6)
    speed = draw.normal(size=count) * 10 ** draw.uniform(-3, 2, count)
    here, middle, there = (
        draw.normal(size=count) * 10 ** draw.uniform(-2, 4, count) for _ in range(3)
    )
    middle = np.where(draw.random(count) < 0.3, here, middle)
    keep = np.exp(-(10 ** draw.uniform(-3, 0.7, count)))
    rows = (speed, here, middle, there, keep)
    made = step(axis).map(count)(*(ca.DM(item).T for item in rows))
    start, end = (np.asarray(item).ravel() for item in made)
    before, after = np.abs(speed - x_of(here, axis)), np.abs(end - x_of(there, axis))

    assert (np.abs(end) < u1).all()
    assert (start == speed)[middle == here].all()
    assert (after <= keep * (before + np.abs(there - middle)) * (1 + 1e-12) + 4 * EPS * u1).all()
    assert (np.abs(start - x_of(middle, axis)) <= before * (1 + 1e-12) + 4 * EPS * u1).all()
