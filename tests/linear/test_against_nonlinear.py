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


def test_read_continuously_a_memory_changes_in_a_second_by_its_change_over_a_period(nominal):
    """The memory's rate is its change over one period, and the robot moves along its heading."""
    sampled, continuous = loop_nlsys(nominal, "pid", sampled=True), loop_nlsys(nominal, "pid")
    memory = np.array([0.3, -0.2, 1.0])
    state, pushes = np.array([*memory, -0.5, -0.5, 0.7, 0.3, 0.2]), np.zeros(4)
    after = sampled.dynamics(0.0, state, pushes)[:3]

    rate = continuous.dynamics(0.0, state, pushes)
    assert rate[:3] == pytest.approx((after - memory) / nominal.clock.control)
    assert rate[3:6] == pytest.approx((-0.3 * np.sin(0.7), 0.3 * np.cos(0.7), 0.2))
