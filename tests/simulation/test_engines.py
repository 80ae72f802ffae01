"""Engines: which plant runs where."""

import pytest

from tests.papers_robot import paper
from wmr_ctrl.core.errors import ArgumentError, UnknownNameError
from wmr_ctrl.simulation.engines import check_device, check_plant, run_compiled, run_numpy, runnable
from wmr_ctrl.world.scenario import override


@pytest.mark.parametrize(
    "device, plant, error, words",
    [
        ("tpu", "ode", UnknownNameError, "no device is named 'tpu'"),
        ("cpu", "odd", UnknownNameError, "no plant is named 'odd'"),
        ("gpu", "mujoco", ArgumentError, "device = 'gpu' runs the plant ode alone"),
    ],
)
def test_a_device_and_a_plant_go_together(device, plant, error, words):
    with pytest.raises(error, match=words):
        check_device(device, plant, here=False)
    check_device("gpu", here=False)
    with pytest.raises(ArgumentError, match="works only with compiled laws"):
        check_plant("mujoco", "numpy")


def test_both_engines_run_the_same_loop():
    short = override(paper(), {"clock.duration": 0.2})
    compiled, numpy = run_compiled(short, "mb", 3), run_numpy(short, "mb", 3)

    assert compiled["v1"] == pytest.approx(numpy["v1"], abs=1e-12)
    assert (compiled.engine, numpy.engine) == ("native", "numpy")
    assert runnable(short, "mb").law == "mb"
