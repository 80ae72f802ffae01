"""python-control's nonlinear objects against the native loop, and linear against nonlinear."""

import control as ct
import numpy as np
import pytest

import wmr_ctrl
from wmr_ctrl.theory.linear import loop_nlsys, start_of
from wmr_ctrl.world.scenario import override


@pytest.mark.parametrize("law", ["mb", "pid"])
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


def test_read_continuously_a_memory_changes_in_a_second_by_its_change_over_a_period(nominal):
    sampled, continuous = loop_nlsys(nominal, "pid", sampled=True), loop_nlsys(nominal, "pid")
    memory = np.array([0.3, -0.2, 1.0])
    state, pushes = np.concatenate((memory, start_of(nominal, "pid")[3:])), np.zeros(4)
    after = sampled.dynamics(0.0, state, pushes)[:3]

    rate = continuous.dynamics(0.0, state, pushes)[:3]
    assert rate == pytest.approx((after - memory) / nominal.clock.control)
