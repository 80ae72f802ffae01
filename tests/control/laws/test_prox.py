"""The sampled-data law: its theorem's statements, on its own graph and in the loop."""

import casadi as ca
import numpy as np
import pytest

from tests.checks.asking import closed
from tests.control.laws.points import assert_twin
from tests.tables import changes
from wmr_ctrl.control.barrier.proximal import resolvent
from wmr_ctrl.control.laws.prox import guide, prox_step
from wmr_ctrl.control.setup import settle
from wmr_ctrl.theory.checks.loop import Loop
from wmr_ctrl.world.scenario import load_scenario
from wmr_proofs.paper_barrier import lyapunov, minimiser

U1, U2 = 1.0, 0.8
c, k, v, E = (ca.SX.sym(name) for name in "ckvE")
LIMITS = (ca.SX(U1), ca.SX(U2))
X = {s: ca.Function("X", [c, k], [resolvent(c, k, *LIMITS, s)]) for s in (False, True)}
STEP = ca.Function("step", [v, c, E], [prox_step(v, (c, c, c), (E, 1 - E), LIMITS, False)])
TARGET = ca.Function("x", [c], [minimiser(c, *LIMITS)])
V1 = ca.Function("V1", [v, c], [lyapunov(v, c, *LIMITS)])


def targets(draw, count):
    return draw.normal(size=count) * 10 ** draw.uniform(-2, 3, count)


def test_resolvent_with_weight_1_is_the_papers_target():
    for value in (*targets(np.random.default_rng(0), 300), 0.8, 5.8, 0.0, -0.8):
        assert float(X[False](value, 1.0)) == pytest.approx(float(TARGET(value)), abs=1e-13)


@pytest.mark.parametrize("smooth", [False, True])
def test_resolvent_does_not_expand_and_stays_inside(smooth):
    draw = np.random.default_rng(2)
    for weight in draw.uniform(1e-6, 1, 100):
        first, second = targets(draw, 2)
        near = [float(X[smooth](value, weight)) for value in (first, second)]
        assert abs(near[0] - near[1]) <= abs(first - second) * (1 + 1e-12)
        assert max(map(abs, near)) < U1


def test_a_step_divides_v1_by_at_least_exp_rho_t():
    """V1(v+) <= E^2 V1(v) holds for a target at rest, with equality without a barrier."""
    draw = np.random.default_rng(4)
    for _ in range(500):
        here, start, keep = targets(draw, 1)[0], draw.uniform(-0.999, 0.999), draw.uniform(0.003, 1)
        end = float(STEP(start, here, keep))
        before, after = float(V1(start, here)), float(V1(end, here))
        assert after <= keep**2 * before * (1 + 1e-9) + 1e-12 * (1 + abs(here))
        if max(abs(here), abs(start)) < U2:
            assert after == pytest.approx(keep**2 * before, rel=1e-9, abs=1e-15)


@pytest.mark.parametrize("transport", ["level", "two-part"])
@pytest.mark.parametrize("barrier", ["paper", "smooth"])
def test_its_force_is_that_of_its_formulas(transport, barrier):
    assert_twin("prox", **{"gains.prox.transport": transport, "gains.prox.barrier": barrier})


@pytest.mark.parametrize("period, share", [(0.1, 0.5), (0.01, 0.0), (0.2, 0.5)])
@pytest.mark.slow_but("0.1-0.5")
def test_gains_of_the_guide_stand_a_mass_that_is_believed_wrong(period, share):
    """The linear loop with its delay is stable for 0.6 to 1.6 times the believed mass."""
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


@pytest.mark.parametrize("period, delay", [(0.01, 0.0), (0.01, 0.05), (0.1, 0.1), (0.05, 0.2)])
def test_the_guides_observer_slows_with_period_and_delay_together(period, delay):
    assert guide(period, delay, 0.2).wo == pytest.approx(min(10.0, 0.45 / (period + delay)))
    for wrong in ((0.0, delay, 0.2), (period, -1e-9, 0.2), (period, delay, 0.0)):
        with pytest.raises(ValueError, match="needs period, speed > 0"):
            guide(*wrong)
