"""The sampled-data law: what its theorem promises, on its own graph and in the loop."""

import math

import casadi as ca
import numpy as np
import pytest

from tests.checks.asking import closed
from tests.control.laws.points import DRIVING, M, T, at, graph
from tests.tables import changes
from wmr_ctrl.api import simulate
from wmr_ctrl.control.barrier.proximal import resolvent
from wmr_ctrl.control.laws.prox import guide, prox_step
from wmr_ctrl.control.setup import settle
from wmr_ctrl.theory.checks.loop import Loop
from wmr_ctrl.world.scenario import load_scenario
from wmr_proofs.paper_barrier import lyapunov, minimiser

U1, U2 = 1.0, 0.8
c, k, v, c_next, E = (ca.SX.sym(name) for name in ("c", "k", "v", "c_next", "E"))
LIMITS = (ca.SX(U1), ca.SX(U2))
X = {s: ca.Function("X", [c, k], [resolvent(c, k, *LIMITS, s)]) for s in (False, True)}
STEP = {
    s: ca.Function(
        "step", [v, c, c_next, E], [prox_step(v, (c, c_next, c_next), (E, 1 - E), LIMITS, s)]
    )
    for s in (False, True)
}
TARGET = ca.Function("x", [c], [minimiser(c, *LIMITS)])
V1 = ca.Function("V1", [v, c], [lyapunov(v, c, *LIMITS)])
both_forms = pytest.mark.parametrize("smooth", [False, True])


def targets(draw, count):
    return draw.normal(size=count) * 10 ** draw.uniform(-2, 3, count)


def test_resolvent_with_weight_1_is_the_papers_target():
    for value in (*targets(np.random.default_rng(0), 300), 0.8, 5.8, 0.0, -0.8):
        assert float(X[False](value, 1.0)) == pytest.approx(float(TARGET(value)), abs=1e-13)


@both_forms
def test_resolvent_does_not_expand_and_stays_inside(smooth):
    draw = np.random.default_rng(2)
    for weight in draw.uniform(1e-6, 1, 100):
        first, second = targets(draw, 2)
        near = [float(X[smooth](value, weight)) for value in (first, second)]
        assert abs(near[0] - near[1]) <= abs(first - second) * (1 + 1e-12)
        assert max(map(abs, near)) < U1


@both_forms
def test_a_step_ends_inside_and_comes_nearer(smooth):
    """|v+| < v_u1 and |w+| <= E |w| from every v, also outside the limit."""
    draw = np.random.default_rng(3)
    for _ in range(500):
        here, there = targets(draw, 2)
        start, keep = draw.choice([draw.uniform(-1, 1), draw.normal() * 30]), draw.uniform(0.003, 1)
        end = float(STEP[smooth](start, here, there, keep))
        before = start - float(X[smooth](here, 1.0))
        after = end - float(X[smooth](there, 1.0))
        assert abs(end) < U1
        assert abs(after) <= keep * abs(before) * (1 + 1e-9) + 1e-13


def test_a_step_divides_v1_by_at_least_exp_rho_t():
    """With the target at rest V1(v+) <= E^2 V1(v), and equal where there is no barrier."""
    draw = np.random.default_rng(4)
    for _ in range(500):
        here, start, keep = targets(draw, 1)[0], draw.uniform(-0.999, 0.999), draw.uniform(0.003, 1)
        end = float(STEP[False](start, here, here, keep))
        before, after = float(V1(start, here)), float(V1(end, here))
        assert after <= keep**2 * before * (1 + 1e-9) + 1e-12 * (1 + abs(here))
        if max(abs(here), abs(start)) < U2:
            assert after == pytest.approx(keep**2 * before, rel=1e-9, abs=1e-15)


def noise_free(law, period, **changed):
    overrides = {"clock.control": period, "clock.duration": 40.0, **changed}
    return simulate("paper-simulation-nominal", law, overrides=overrides)


@pytest.mark.parametrize("transport, falls", [("level", True), ("two-part", False)])
def test_level_transport_keeps_the_decay_of_v1_in_a_run(transport, falls):
    """S(v; c+) at the next sample, c+ as the law expected it: exp(-rho T/2) S, or less."""
    plain = changes("""
        gains.prox.wo = 0.0
        gains.prox.tau_max = 1e6
        robot.mu = 0.0
        model.mu = 0.0
    """)
    run = noise_free("prox", 0.05, **plain, **{"gains.prox.transport": transport})
    (_, e2, e3), speed, here = run["e"].T, run["v1"], run["v_c0"][:, 0]
    turning = run["omega"]
    rate = 10.0 * (e2 * turning - speed + 0.2 * np.cos(e3)) - 0.2 * np.sin(e3) * (0.1 - turning)
    S, S_next = (
        np.sqrt(2 * np.maximum(V1(*pair).full().ravel(), 0))
        for pair in ((speed, here), (speed[1:], (here + 0.05 * rate)[:-1]))
    )
    moving = S[:-1] > 1e-4

    assert moving.sum() > 20
    assert (S_next <= np.exp(-15 * 0.05 / 2) * S[:-1] * (1 + 1e-6) + 1e-7)[moving].all() == falls


@pytest.mark.parametrize("period, share", [(0.1, 0.5), (0.01, 0.0), (0.2, 0.5)])
@pytest.mark.slow_but("0.1-0.5")
def test_gains_of_the_guide_stand_a_mass_that_is_believed_wrong(period, share):
    """The linear loop, delay in it, with 0.6 to 1.6 times the believed mass."""
    delay = share * period
    start = guide(period, delay, 0.2)
    for ratio in np.linspace(0.6, 1.6, 6):
        text = f"""
            clock.control = {period}
            actuator.delay = {delay}
            changes = []
            model.m = 50
            model.I = 5.4
            robot.m = {50.0 * ratio}
            robot.I = {5.4 * ratio}
            gains.kinematics.k = {[*start.k]}
            gains.prox.rho = {[*start.rho]}
            gains.prox.wo = {start.wo}
        """
        changed = changes(text)
        loop = Loop(settle(load_scenario("paper-simulation", changed), "prox"))
        matrix = closed(loop, np.array((0.2, 0.1)), period)
        assert np.abs(np.linalg.eigvals(matrix)).max() < 1, ratio


def test_prox_makes_up_for_friction_at_the_speed_that_it_is_after():
    slow = {**DRIVING, "v1": 0.0, "omega": 0.0, "v1_d": 0.02}
    rough, smooth = (at(graph("prox", **{"model.mu": mu}), slow)[0] for mu in (0.08, 0.0))

    reached = T * smooth[0] / M
    friction = 0.08 * M * 9.81 * math.tanh(reached / 0.01)
    assert reached > 1e-3
    assert rough - smooth == pytest.approx([friction, 0.0], rel=1e-6)


@pytest.mark.parametrize("period, delay", [(0.01, 0.0), (0.01, 0.05), (0.1, 0.1), (0.05, 0.2)])
def test_the_guides_observer_slows_with_period_and_delay_together(period, delay):
    assert guide(period, delay, 0.2).wo == pytest.approx(min(10.0, 0.45 / (period + delay)))
    for wrong in ((0.0, delay, 0.2), (period, -1e-9, 0.2), (period, delay, 0.0)):
        with pytest.raises(ValueError, match="needs period, speed > 0"):
            guide(*wrong)
