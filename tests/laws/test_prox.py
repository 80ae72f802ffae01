"""The sampled-data law: what its theorem promises, on its own graph and in the loop."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from wmr_ctrl.api import simulate
from wmr_ctrl.barrier.paper import f, lyapunov, minimiser
from wmr_ctrl.barrier.resolvent import resolvent
from wmr_ctrl.laws.prox import prox_step
from wmr_ctrl.results import Run

U1, U2 = 1.0, 0.8
c, k, v, c_next, E = (ca.SX.sym(name) for name in ("c", "k", "v", "c_next", "E"))
LIMITS = (ca.SX(U1), ca.SX(U2))
X = {s: ca.Function("X", [c, k], [resolvent(c, k, *LIMITS, s)]) for s in (False, True)}
STEP = {
    s: ca.Function("step", [v, c, c_next, E], [prox_step(v, c, c_next, (E, 1 - E), LIMITS, s)])
    for s in (False, True)
}
TARGET = ca.Function("x", [c], [minimiser(c, *LIMITS)])
V1 = ca.Function("V1", [v, c], [lyapunov(v, c, *LIMITS)])
F = ca.Function("f", [v], [f(v, *LIMITS)])
both_forms = pytest.mark.parametrize("smooth", [False, True])


def targets(draw: np.random.Generator, count: int) -> np.ndarray:
    return draw.normal(size=count) * 10 ** draw.uniform(-2, 3, count)


def test_resolvent_with_weight_1_is_the_papers_target() -> None:
    for value in (*targets(np.random.default_rng(0), 300), 0.8, 5.8, 0.0, -0.8):
        assert float(X[False](value, 1.0)) == pytest.approx(float(TARGET(value)), abs=1e-13)


def barrier_at(x: np.ndarray, smooth: bool) -> np.ndarray:
    beyond = np.abs(x) - U2
    tangent = np.maximum(beyond, 0) / (U1 - U2) if smooth else 0.0
    return F(x).full().ravel() - tangent


@both_forms
def test_resolvent_minimises_its_cost(smooth: bool) -> None:
    draw = np.random.default_rng(1)
    grid = np.linspace(-1, 1, 4003)[1:-1]
    for value, weight in zip(targets(draw, 200), draw.uniform(0.01, 1, 200), strict=True):
        found = float(X[smooth](value, weight))
        least = 0.5 * (found - value) ** 2 + weight * barrier_at(np.array([found]), smooth)[0]
        cost = 0.5 * (grid - value) ** 2 + weight * barrier_at(grid, smooth)
        assert least <= cost.min() + 1e-9 * abs(cost.min())


@both_forms
def test_resolvent_does_not_expand_and_stays_inside(smooth: bool) -> None:
    draw = np.random.default_rng(2)
    for weight in draw.uniform(1e-6, 1, 100):
        first, second = targets(draw, 2)
        near = [float(X[smooth](value, weight)) for value in (first, second)]
        assert abs(near[0] - near[1]) <= abs(first - second) * (1 + 1e-12)
        assert max(map(abs, near)) < U1


@both_forms
def test_a_step_ends_inside_and_comes_nearer(smooth: bool) -> None:
    """P1, P2: |v+| < v_u1 and |w+| <= E |w| from every v, also outside the limit."""
    draw = np.random.default_rng(3)
    for _ in range(500):
        here, there = targets(draw, 2)
        start, keep = draw.choice([draw.uniform(-1, 1), draw.normal() * 30]), draw.uniform(0.003, 1)
        end = float(STEP[smooth](start, here, there, keep))
        before = start - float(X[smooth](here, 1.0))
        after = end - float(X[smooth](there, 1.0))
        assert abs(end) < U1
        assert abs(after) <= keep * abs(before) * (1 + 1e-9) + 1e-13


def test_a_step_divides_v1_by_at_least_exp_rho_t() -> None:
    """P3, with the target at rest: V1(v+) <= E^2 V1(v), and equal where there is no barrier."""
    draw = np.random.default_rng(4)
    for _ in range(500):
        here, start, keep = targets(draw, 1)[0], draw.uniform(-0.999, 0.999), draw.uniform(0.003, 1)
        end = float(STEP[False](start, here, here, keep))
        before, after = float(V1(start, here)), float(V1(end, here))
        assert after <= keep**2 * before * (1 + 1e-9) + 1e-12 * (1 + abs(here))
        if max(abs(here), abs(start)) < U2:
            assert after == pytest.approx(keep**2 * before, rel=1e-9, abs=1e-15)


def noise_free(law: str, period: float, **changed: object) -> Run:
    overrides = {"clock.control": period, "clock.duration": 40.0, **changed}
    return simulate("paper-simulation-nominal", law, overrides=overrides)


def test_law_9_breaks_at_40_ms_and_prox_holds_at_200_ms() -> None:
    assert noise_free("mb", 0.04).outcome != "completed"
    assert noise_free("prox", 0.2).outcome == "completed"
    assert noise_free("prox", 0.2, **{"gains.prox.wo": 0.0}).outcome == "completed"


def test_exact_decay_keeps_law_9_inside_at_100_ms() -> None:
    assert noise_free("mb", 0.1).outcome != "completed"
    assert noise_free("mb", 0.1, **{"gains.mb.decay": "exact"}).outcome == "completed"


def test_observer_removes_the_offset_of_wrong_friction() -> None:
    with_it, without = (
        simulate("paper-simulation", "prox", seed=100, overrides={"gains.prox.wo": wo})
        for wo in (10.0, 0.0)
    )
    late = [abs(run["e"][run.time >= 70, 0]).mean() for run in (with_it, without)]

    assert late[0] < 0.4e-3
    assert late[1] > 10e-3


def test_observer_finds_a_constant_force() -> None:
    """A push of 20 N along the motion appears as d_hat."""
    changed = {"disturbance.push": [20.0, 0.0], "clock.duration": 20.0}
    run = simulate("paper-simulation-nominal", "prox", overrides=changed)

    assert run["d_hat"][-1] == pytest.approx([20.0, 0.0], abs=0.05)


def test_first_sample_respects_the_laws_own_torque_limit() -> None:
    limited, free = (
        simulate("paper-simulation-nominal", "prox", overrides={"gains.prox.tau_max": tau})
        for tau in (20.0, 1e6)
    )

    assert abs(limited["tau_right"]).max() <= 20.0 * (1 + 1e-15)
    assert max(abs(free["tau_right"]).max(), abs(free["tau_left"]).max()) > 150.0
