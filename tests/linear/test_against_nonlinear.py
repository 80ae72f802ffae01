"""python-control's nonlinear objects against the native loop, and linear against nonlinear."""

from __future__ import annotations

import math

import control as ct
import numpy as np
import pytest

import wmr_ctrl
from analysis.authority import BarrierTerm, VelocityFeedback
from analysis.stepper import linear_gain, loop_pair, reach, stepper, sweep
from wmr_ctrl.core.errors import UnknownNameError
from wmr_ctrl.theory.linear import closed_loop, law_nlsys, loop_nlsys, plant_nlsys, start_of
from wmr_ctrl.world.scenario import override

LAWS = ("pid", "smc", "mb", "nn")


@pytest.mark.parametrize("law", LAWS)
def test_sampled_nonlinear_loop_is_the_native_run(nominal, law):
    short = override(nominal, {"clock.duration": 1.0})
    run = wmr_ctrl.simulate(short, law)
    loop = loop_nlsys(short, law, sampled=True)
    response = ct.input_output_response(
        loop, run.time, np.zeros((4, run.rows)), start_of(short, law)
    )

    for row, name in enumerate(("x", "y", "theta", "v1", "omega")):
        assert response.outputs[row] == pytest.approx(run[name], abs=1e-9)


def test_continuous_reading_is_the_limit_of_a_fast_clock(nominal):
    fast = override(nominal, {"clock.control": 1e-3, "clock.duration": 1.0})
    run = wmr_ctrl.simulate(fast, "mb")
    times = run.time[::100]
    response = ct.input_output_response(
        loop_nlsys(fast, "mb"), times, np.zeros((4, len(times))), start_of(fast, "mb")
    )

    assert response.outputs[0] == pytest.approx(run["x"][::100], abs=2e-3)
    assert response.outputs[4] == pytest.approx(run["omega"][::100], abs=3e-2)


def test_python_control_linearises_the_plant_to_the_same_matrices(nominal):
    """Its own differences, as an independent check of ours."""
    from wmr_ctrl.theory.linear import linearise
    from wmr_ctrl.world.model.dynamics import plant

    x, u = np.array((0.1, -0.2, 0.4, 0.3, 0.2)), np.array((2.0, 1.0, 0.0, 0.0, 0.0, 0.0))
    theirs = plant_nlsys(nominal).linearize(x, u)

    assert pytest.approx(theirs.A, abs=1e-4) == linearise(plant(nominal), u, x).A


def test_law_has_named_signals_in_both_readings(nominal):
    sampled, continuous = law_nlsys(nominal, "nn", sampled=True), law_nlsys(nominal, "nn")

    assert sampled.dt == nominal.clock.control
    assert continuous.dt == 0
    assert sampled.input_labels[:2] == ["x_d", "y_d"]
    assert sampled.output_labels == ["tau_right", "tau_left"]
    assert sampled.nstates == 128
    assert law_nlsys(nominal, "nn", memory="frozen").nstates == 0
    with pytest.raises(UnknownNameError):
        law_nlsys(nominal, "nn", memory="none")


def test_deviation_vanishes_with_the_amplitude(nominal):
    given = loop_pair(nominal, "mb", duration=5.0)
    small, smaller = (given.deviation(np.array((0.0, a, 0.0))) for a in (2e-3, 1e-3))

    assert smaller < 1e-3
    assert small / smaller == pytest.approx(2.0, rel=0.3)  # the first nonlinear term is quadratic


def test_the_barrier_sets_the_amplitude_that_matters(nominal):
    """k1 e1 + v1_d = v_u2 at e1 = 0.06 m: from there on the linear loop runs ahead."""
    found = reach(loop_pair(nominal, "mb", duration=10.0))

    assert 0.06 < found[0.01] < found[0.1] < 0.3
    assert found[1.0] is None or found[1.0] > found[0.1]


def test_barrier_terms_describing_function_is_its_integral():
    term, plain = (
        BarrierTerm(1.0, 0.8),
        lambda v: math.copysign(1 / (1 - abs(v)), v) * (abs(v) > 0.8),
    )
    p = (np.arange(200_000) + 0.5) * math.pi / 400_000
    for amplitude in (0.85, 0.95, 0.99):
        values = [plain(v) for v in amplitude * np.sin(p[::40])]
        integral = 2 / amplitude * np.mean(values * np.sin(p[::40]))
        assert term.describing_function(amplitude) == pytest.approx(integral, rel=2e-3)
    assert term.describing_function(0.8) == 0.0
    assert math.isinf(term.describing_function(1.0))


def test_velocity_feedback_is_linear_below_the_barrier_and_fades_above(nominal):
    """M rho/2 up to v_u2."""
    feedback = VelocityFeedback(nominal, "mb", 0)
    gains = np.real(ct.describing_function(feedback, [0.1, 0.7, 0.9, 0.99]))

    assert gains[:2] == pytest.approx(50 * 15 / 2, rel=1e-9)
    assert gains[1] > gains[2] > gains[3]


@pytest.mark.parametrize("law", ["mb", "smc"])
def test_a_small_sine_sees_the_linear_loop(nominal, law):
    smooth = override(nominal, {"robot.mu": 0.0})
    loop = stepper(smooth, law, memory="frozen")
    used, measured = sweep(loop, 1, 0.02, np.array((2.0, 12.0)), output=4)
    linear = linear_gain(closed_loop(smooth, law, period=0.01), 1, used, output=4)

    assert np.abs(measured) == pytest.approx(np.abs(linear), rel=2e-3)


def test_a_large_sine_does_not(nominal):
    loop = stepper(nominal, "mb")
    used, measured = sweep(loop, 0, 400.0, np.array((3.0,)), output=3)
    linear = linear_gain(closed_loop(nominal, "mb", period=0.01), 0, used, output=3)

    assert abs(abs(measured[0]) / abs(linear[0]) - 1) > 0.02
