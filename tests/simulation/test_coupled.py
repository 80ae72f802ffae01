"""The loop without its plant: its monitor for any state, and its restart."""

import math

import numpy as np
import pytest

from tests.papers_robot import preset
from tests.tables import cases
from wmr_ctrl.simulation.coupled import Coupled
from wmr_ctrl.simulation.engines import runnable


def loop_with(told):
    return runnable(preset("paper-simulation", told), "mb", "mujoco")


@pytest.fixture(scope="module")
def loop():
    """Limits are 1 m/s and 1.5 rad/s, and a run ends at 1000 of either."""
    late = "clock.duration = 2.0; changes = []; actuator.delay = 0.02"
    return loop_with(f"{late}; sensor.velocity_noise = [0.02, 0.03]")


def coupled(loop):
    return Coupled(loop.compiled, 5, loop.scenario.clock.plant)


def columns_of(loop):
    return sum(item.size for item in loop.compiled.layout.columns)


@pytest.mark.parametrize(
    "given, most, violated, stop",
    cases("""
        -1.0 1.5 | 1.0 1.5 | 0 | goes on
        0.5 -1.6 | 0.5 1.6 | 2 | goes on
        -1.1 1.6 | 1.1 1.6 | 1 | goes on
        999.0 0.0 | 999.0 0.0 | 1 | goes on
        -1000.0 0.0 | 1000.0 0.0 | 1 | diverged 1
        0.0 1000.0 | 0.0 1000.0 | 2 | diverged 2
        -1000.0 1000.0 | 1000.0 1000.0 | 1 | diverged 1
        1.2 nan | 1.2 0.0 | 0 | non-finite 2
        nan 1.2 | 0.0 0.0 | 0 | non-finite 1
        inf nan | 0.0 0.0 | 0 | non-finite 1
        0.0 -inf | 0.0 0.0 | 0 | non-finite 2
    """),
)
def test_the_monitor_takes_each_state_for_what_it_is(loop, given, most, violated, stop):
    """Speeds, the largest of each axis, the axis beyond its limit, and the cause of the end.

    At plant step 7, NaN counts neither as fastest nor as beyond a limit.
    """
    one, time = coupled(loop), 7 * loop.scenario.clock.plant
    ends = one.ends((0.0, 0.0, 0.0, *map(float, given.split())), 7)
    seen, axis = one.monitor(), int(violated)

    assert ends is (stop != "goes on")
    assert seen.max_abs_v == tuple(map(float, most.split()))
    assert seen.violations == (axis > 0)
    assert seen.first_violation == ((time, axis) if axis else None)
    if ends:
        assert (f"{seen.stop_reason} {seen.stopped[1]}", seen.stopped[0]) == (stop, time)
    else:
        assert seen.stopped is None


def test_a_torque_comes_near_its_command_as_fast_as_its_lag_of_this_sample():
    """A varying lag is constant within a sample and differs between samples."""
    slow, h, wanted = 0.02, 0.001, 3.0
    varying = loop_with(f"actuator.lag = {slow}; actuator.lag_spread = 0.5")
    one, columns = coupled(varying), columns_of(varying)
    left, lags = wanted, []
    for _ in range(3):
        rest = one.sampled((0.0,) * 5)[2:-columns]
        shares = []
        for _ in range(varying.scenario.clock.substeps):
            before, left = left, wanted - one.acting([wanted, wanted, *rest])[0]
            shares.append(left / before)
        lags.append(-h / math.log(shares[0]))
        assert shares == pytest.approx([shares[0]] * len(shares), rel=1e-9)

    assert all(0.5 * slow <= lag <= 1.5 * slow for lag in lags)
    assert np.ptp(lags) > 0.01 * slow


def test_a_loop_that_starts_again_has_nothing_under_way(loop):
    """It draws the same numbers, and has no history.  The monitor moves no counter."""
    one, state = coupled(loop), (0.1, 0.2, 0.3, 0.4, 0.5)
    columns = columns_of(loop)

    def course(aside=0):
        rows = [one.sampled(state)]
        for step in range(1, 25):
            rows.append(one.acting([3.0, -2.0, *rows[0][2:-columns]]))
            one.ends(state, step + aside)
        return [*rows, one.sampled(state)]

    first, seen = course(), one.monitor()
    one.ends((0.0, 0.0, 0.0, 2.0, 2.0), 30)
    one._library.wmr_outside_start(*one._at)

    assert np.array_equal(np.hstack(course(7)), np.hstack(first), equal_nan=True)
    assert one.monitor() == seen
