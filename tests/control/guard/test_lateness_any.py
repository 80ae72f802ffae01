"""Robots outside return for random combinations of late velocities, jitter and lag."""

import math
from dataclasses import replace

import numpy as np
import pytest

from tests.control.guard.exact_axis import PARTS
from tests.control.guard.late_trial import LIMITS, Case, Thrown, trial


def any_case(seed):
    """Random windows, ages, delays, lags, errors, friction, brakes and slopes; dbar up to its
    largest value.

    That is the largest value that the guard accepts; half of the cases are close to it.
    """
    draw = np.random.default_rng(seed)

    def parts(most):
        return float(draw.integers(0, int(most * PARTS) + 1) / PARTS * (draw.random() < 0.7))

    lo, sure = parts(1.5), draw.random() < 0.3
    lag = float(draw.uniform(0.05, 1.5) * (draw.random() < 0.6))
    case = Case(
        T=float(draw.choice([0.01, 0.02, 0.1])),
        age=parts(1.5), window=parts(2.0), lo=lo, hi=lo + parts(1.0), lag=lag,
        fast=float(lag * draw.uniform(0, 0.95)) if lag and draw.random() < 0.5 else None,
        nbar=float(draw.choice([0.0, 0.0, 0.02, 0.1, 0.25])),
        f_speed=float(draw.choice([0.05, 0.1, 0.4])) if sure else 0.0,
        alpha=float(draw.choice([1.0, 1.0, 0.7, 0.3])),
    )  # fmt: skip
    late = case.age + case.window + case.hi + case.lag
    mixed = max(late - case.window / 2, 1e-9)
    slowed = (1 - case.f_speed) / (1 / case.alpha + late)
    most = case.M_min / case.T / 2 * min(slowed, (1 - 2 * case.nbar) / mixed)
    net = float(most * draw.choice([1 - 1e-9, 0.97, draw.uniform(0.05, 0.97)]))
    f_min = float(0.2 * most * draw.random()) if sure else 0.0
    brake = float(net * draw.uniform(1.001, 3)) if draw.random() < 0.5 else None
    return replace(case, dbar=net + f_min, f_min=f_min, brake=brake)


@pytest.mark.parametrize("seed", [0, 1, 37, 73, 109])
@pytest.mark.slow_but("1", "37", "73")
def test_from_outside_it_comes_back_as_stated_and_not_through_the_other_limit(seed):
    """Pushed by several times dbar for some samples, or started outside, always the same way."""
    case, draw = any_case(seed), np.random.default_rng(seed + 10_000)
    way = draw.choice([-1.0, 1.0], 100)
    if case.age + case.window == 0 and seed % 2:
        thrown = Thrown(way, start=float(draw.uniform(1.0, 3.0)))
    else:
        count = int(draw.integers(1, 6))
        thrown = Thrown(way, times=float(draw.uniform(2, 12)), samples=count)
    found = trial(case, 100, 80, seed, thrown=thrown)

    assert found.apart < 1e-11 * case.M_min / case.T
    for axis in (0, 1):
        returned(found, axis, case.formula(axis), thrown)


def returned(found, axis, f, thrown):
    """Assert the promises of docs/explanation/guarantee.md on robots outside.

    Speeds are measured in the direction of the event.
    """
    u1, h = LIMITS[axis], f.T / PARTS
    v = np.vstack([thrown.start * u1 * np.ones(len(thrown.way)), found.seen[:, axis] * thrown.way])
    assert (v >= -u1).all()

    clean = 0 if thrown.start else thrown.samples + math.ceil(f.L / f.T - 1e-9)
    begin = round((clean * f.T + f.hi) / h)
    most = f.net if thrown.start else max(f.largest, 0.0) + f.net
    felt = f.lag * max(most, 0.0) / f.M_min if f.lag else 0.0
    after = v[begin:]
    counted = np.maximum(after[0], u1) + felt
    assert (after <= counted + 1e-12).all()
    if not f.lag:
        assert (np.diff(np.maximum(after, u1), axis=0) <= 1e-12).all()
    if thrown.start:
        assert (v <= thrown.start * u1 + (f.hi + f.lag) * max(f.net, 0.0) / f.M_min + 1e-12).all()
    step = f.T * (f.brakes - f.net) / f.M_max
    for e in (step, step / 2, step / 8):
        at = np.ceil((f.lag + f.T * (counted - u1 - e) / e) / h + 1e-9)
        for lane in np.nonzero((at >= 0) & (at < len(after)))[0]:
            near = after[: int(at[lane]) + 1, lane].min()
            assert near <= u1 + e + 1e-12
