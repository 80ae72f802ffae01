"""The level transport and the step behind it, against a barrier in 50-digit arithmetic."""

from __future__ import annotations

from collections.abc import Iterator

import casadi as ca
import mpmath as mp
import numpy as np
import pytest

from wmr_ctrl.control.barrier.proximal import transported
from wmr_ctrl.control.laws.prox import prox_step

LIMITS = ((1.0, 0.8), (1.5, 1.3), (0.7, 0.2))
EPS = float(np.finfo(float).eps)
TINY = mp.mpf(10) ** -40
Axis = tuple[float, float, bool]
every_axis = pytest.mark.parametrize(
    "axis", [(*limits, smooth) for limits in LIMITS for smooth in (False, True)]
)
v, c, c_m, c_next, E = (ca.SX.sym(name) for name in ("v", "c", "c_m", "c_next", "E"))


def step(axis: Axis) -> ca.Function:
    """(v, c, c_m, c+, E) to (v*, v+)."""
    limits = (ca.SX(axis[0]), ca.SX(axis[1]))
    start = transported(v, c, c_m, limits, axis[2])
    end = prox_step(v, (c, c_m, c_next), (E, 1 - E), limits, axis[2])
    return ca.Function("step", [v, c, c_m, c_next, E], [start, end])


def nearest(c: mp.mpf, axis: Axis) -> mp.mpf:
    """v_c1: where the slope x - |c| + f'(x) changes its sign, up to the sign of c."""
    (u1, u2), size = map(mp.mpf, axis[:2]), abs(c)

    def slope(x: mp.mpf) -> mp.mpf:
        bent = 1 / (u1 - x) - (1 / (u1 - u2) if axis[2] else 0) if x > u2 else 0
        return x - size + bent

    x = min(size, u2)
    if size > u2 and slope(u2 * (1 + TINY)) < 0:
        low, high = u2, u1
        for _ in range(60):
            x = (low + high) / 2
            low, high = (low, x) if slope(x) > 0 else (x, high)
        for _ in range(4):  # Newton's steps from there on: each doubles the digits
            x -= slope(x) / (1 + (u1 - x) ** -2)
    assert slope(x - TINY) <= 0 <= slope(x + TINY)
    return mp.sign(c) * x


def distance(v: mp.mpf, c: mp.mpf, axis: Axis) -> mp.mpf:
    """S = sqrt(2 V1) by the definition of V1, Eq. (20), in 50 digits."""
    u1, u2 = map(mp.mpf, axis[:2])

    def cost(y: mp.mpf) -> mp.mpf:
        size = abs(y)
        bent = (size - u2) / (u1 - u2) if axis[2] else 0
        return (y - c) ** 2 / 2 - (mp.log((u1 - size) / (u1 - u2)) + bent if size > u2 else 0)

    return mp.sqrt(2 * max(cost(v) - cost(nearest(c, axis)), mp.mpf(0)))


def rounded(v: float, axis: Axis) -> list[mp.mpf]:
    """v, and what it may have been before a few roundings."""
    room = mp.mpf(axis[0]) * (1 - mp.mpf(10) ** -25)
    apart = (mp.mpf(v) + k * EPS * axis[0] for k in (-4, 0, 4))
    return [min(max(x, -room), room) for x in apart]


def places(draw: np.random.Generator, count: int, axis: Axis) -> Iterator[np.ndarray]:
    """v, c, c_m, c+ and E: at corners, near limits and targets, far away, held and moving."""
    u1, u2, _ = axis
    edge = u2 + 1 / (u1 - u2)
    corners = np.array([0, u2, -u2, edge, -edge])
    tiny = np.array([0, 0, 1e-15, -1e-15, 1e-9, -1e-9])

    def target() -> np.ndarray:
        wide = draw.normal(size=count) * 10 ** draw.uniform(-2, 6, count)
        kinks = draw.choice(corners, count) * (1 + draw.choice(tiny, count))
        kind = draw.integers(0, 3, count)
        return np.choose(kind, [wide, kinks, draw.uniform(-1.5 * u1, 1.5 * u1, count)])

    def moved(here: np.ndarray) -> np.ndarray:
        near = here + draw.normal(size=count) * 10 ** draw.uniform(-9, 0, count)
        return np.choose(draw.integers(0, 4, count), [here, near, near, target()])

    here = target()
    middle = moved(here)
    inside = draw.uniform(-u1, u1, count)
    at_limit = draw.choice([-u1, u1], count) * (1 - 10 ** draw.uniform(-14, -1, count))
    x = np.array([float(nearest(mp.mpf(float(item)), axis)) for item in here])
    at_target = np.clip(x + draw.normal(size=count) * 10 ** draw.uniform(-10, -1, count), -u1, u1)
    speed = np.choose(draw.integers(0, 3, count), [inside, at_limit, at_target * (1 - 1e-15)])
    yield from (speed, here, middle, moved(middle), np.exp(-(10 ** draw.uniform(-3, 0.7, count))))


@every_axis
@pytest.mark.slow_but("axis1", "axis4")
def test_s_falls_but_for_the_way_that_is_not_carried(axis: Axis) -> None:
    """S(v*; c_m) <= S(v; c), S(v+; c+) <= E (S(v; c) + |c+ - c_m|), to a few roundings of v."""
    count = 12
    with mp.workdps(50):
        given = tuple(places(np.random.default_rng(count), count, axis))
        made = step(axis).map(count)(*(ca.DM(item).T for item in given))
        starts, ends = (np.asarray(item).ravel() for item in made)
        for speed, here, middle, there, keep, start, end in zip(*given, starts, ends, strict=True):
            one, two, three = map(mp.mpf, (here, middle, there))
            most = max(distance(x, one, axis) for x in rounded(speed, axis))
            assert min(distance(x, two, axis) for x in rounded(start, axis)) <= most
            least = min(distance(x, three, axis) for x in rounded(end, axis))
            assert least <= mp.mpf(keep) * (most + abs(three - two)) * (1 + 4 * EPS)


def x_of(c: np.ndarray, axis: Axis) -> np.ndarray:
    """v_c1 in extended precision."""
    u1, u2 = map(np.longdouble, axis[:2])
    size = np.abs(c.astype(np.longdouble))
    t = size - u1 + (1 / (u1 - u2) if axis[2] else 0)
    far = u1 - 2 / (t + np.sqrt(t * t + 4))
    flat = size <= (u2 if axis[2] else u2 + 1 / (u1 - u2))
    return np.sign(c) * np.where(size <= u2, size, np.where(flat, u2, far))


@every_axis
@pytest.mark.slow_but("axis0", "axis5")
def test_w_falls_and_the_limit_is_kept_from_every_speed(axis: Axis) -> None:
    """|w+| <= E (|w| + |c+ - c_m|) and |v+| <= v_u1; v* = v where the target is held."""
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


@every_axis
def test_v_star_has_no_jump_where_the_velocity_enters_the_limit(axis: Axis) -> None:
    act, u1 = step(axis), axis[0]
    for here, there in ((0.3, 0.31), (0.31, 0.3), (5.0, 5.5), (5.5, 5.0), (90.0, -3.0)):
        inside, outside = (
            float(act(u1 * (1 + way * 1e-13), here, there, there, 0.5)[0]) for way in (-1, 1)
        )
        assert inside == pytest.approx(outside, abs=0.05 * u1)


@every_axis
def test_below_the_threshold_the_velocity_is_carried_all_the_way(axis: Axis) -> None:
    act, u2 = step(axis), axis[1]
    draw = np.random.default_rng(7)
    for _ in range(50):
        speed, here, there = draw.uniform(-u2 / 3, u2 / 3, 3)
        start = float(act(speed, here, there, there, 0.5)[0])
        assert start == pytest.approx(speed + there - here, abs=4 * EPS)


def test_what_a_plain_shift_with_the_target_does_to_v1() -> None:
    """At the limit v + v_c1+ - v_c1 raises V1; the level transport does not."""
    axis = (1.0, 0.8, False)
    speed, here, there = -0.75089, -0.79974, -2.37
    with mp.workdps(50):
        before = distance(mp.mpf(speed), mp.mpf(here), axis)
        shift = nearest(mp.mpf(there), axis) - nearest(mp.mpf(here), axis)
        plain = distance(speed + shift, mp.mpf(there), axis)
        start = float(step(axis)(speed, here, there, there, 0.5)[0])
        assert plain > 1.3 * before
        assert distance(mp.mpf(start), mp.mpf(there), axis) <= before * (1 + 1e-12)
