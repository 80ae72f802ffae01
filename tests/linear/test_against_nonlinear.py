"""python-control's nonlinear objects against the native loop, and linear against nonlinear."""

import control as ct
import numpy as np
import pytest

import wmr_ctrl
from wmr_ctrl.core.errors import UnknownNameError
from wmr_ctrl.theory.linear import law_nlsys, loop_nlsys, plant_nlsys, start_of
from wmr_ctrl.world.scenario import override


@pytest.mark.parametrize("law", ["mb", "pid"])
@pytest.mark.slow_but("mb")
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
