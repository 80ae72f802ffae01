"""The linear loop's response against compiled runs from growing starts."""

import numpy as np
import pytest

import wmr_ctrl
from tests.tables import changes
from wmr_ctrl.core.errors import ArgumentError
from wmr_ctrl.theory.linear import closed_loop, start_off


@pytest.fixture(scope="module")
def model_based(nominal):
    return wmr_ctrl.linear_against_run(nominal, ["mb"], overrides={"clock.duration": 4.0})


def test_deviation_grows_like_the_start_while_that_is_small(model_based):
    """The error of a linear model is quadratic at first."""
    for item in model_based.laws["mb"].directions.values():
        small = (item.sizes < 0.03) & (item.sizes > 1e-3)
        shares = item.deviations[small] / item.sizes[small]

        assert item.deviations[0] < 1e-4
        assert shares == pytest.approx(np.full(small.sum(), shares.mean()), rel=0.2)


def test_levels_are_passed_where_they_are_said_to_be(model_based):
    for item in model_based.laws["mb"].directions.values():
        for size, level in ((item.one_per_cent, 0.01), (item.ten_per_cent, 0.1)):
            assert item.deviations[item.sizes <= size].max() <= level
            assert item.deviations[item.sizes > size].min() > level


def test_linear_answer_is_the_state_space(nominal, model_based):
    loop = closed_loop(nominal, "mb", period=nominal.clock.control)
    item = model_based.laws["mb"].directions["ahead"]
    states = [item.shown * np.eye(loop.nstates)[0]]
    for _ in range(300):
        states.append(loop.A @ states[-1])

    assert item.linear[:301] == pytest.approx(np.array(states)[:, :3], abs=1e-9)


def test_a_start_has_the_error_that_is_asked_for(nominal):
    e = (0.3, -0.2, 0.7)
    x, y, theta, v, omega = start_off(nominal, e)
    start = {"initial.pose": [x, y, theta], "initial.velocity": [v, omega]}
    run = wmr_ctrl.simulate(nominal, "mb", overrides={**start, "clock.duration": 0.1})

    assert run["e"][0] == pytest.approx(e, abs=1e-12)


def test_a_reference_that_changes_its_speed_is_followed(nominal):
    """Also by a law that remembers its last commanded speed."""
    told = "reference.kind = 'lemniscate'; reference.rate = 0.1; reference.size = 2.0"
    eight = changes(f"{told}; clock.duration = 4.0")
    found = wmr_ctrl.linear_against_run(nominal, ["kanayama"], overrides=eight).laws["kanayama"]

    assert all(item.ten_per_cent is not None for item in found.directions.values())
    assert found.directions["left"].one_per_cent > 0.005
    assert found.remarks == ()


def test_a_run_that_does_not_stay_is_refused_in_words():
    pushed = {"disturbance.push": [1e5, 1e4]}
    with pytest.raises(ArgumentError, match="does not stay on its reference"):
        wmr_ctrl.linear_against_run("paper-simulation-nominal", ["mb"], overrides=pushed)
