"""The loop without its plant: what its monitor makes of any state, and that a start is a start."""

import math

import numpy as np
import pytest

from wmr_ctrl.simulation.coupled import Coupled
from wmr_ctrl.simulation.engines import runnable
from wmr_ctrl.world.scenario import load_scenario

LATE = {"clock.duration": 2.0, "actuator.delay": 0.02, "sensor.velocity_noise": [0.02, 0.03]}
NAN, INF = math.nan, math.inf


@pytest.fixture(scope="module")
def loop(loop_with):
    """Limits are 1 m/s and 1.5 rad/s, and a run ends at 1000 of either."""
    return loop_with(LATE)


@pytest.fixture(scope="module")
def loop_with():
    return lambda changes: runnable(load_scenario("paper-simulation", changes), "mb", "mujoco")


def coupled(loop):
    return Coupled(loop.compiled, 5, loop.scenario.clock.plant)


def columns_of(loop):
    return sum(item.size for item in loop.compiled.layout.columns)


@pytest.mark.parametrize(
    "v, omega, most, violated, stop",
    [
        (-1.0, 1.5, (1.0, 1.5), None, None),
        (0.5, -1.6, (0.5, 1.6), 2, None),
        (-1.1, 1.6, (1.1, 1.6), 1, None),
        (999.0, 0.0, (999.0, 0.0), 1, None),
        (-1000.0, 0.0, (1000.0, 0.0), 1, ("diverged", 1)),
        (0.0, 1000.0, (0.0, 1000.0), 2, ("diverged", 2)),
        (-1000.0, 1000.0, (1000.0, 1000.0), 1, ("diverged", 1)),
        (1.2, NAN, (1.2, 0.0), None, ("non-finite", 2)),
        (NAN, 1.2, (0.0, 0.0), None, ("non-finite", 1)),
        (INF, NAN, (0.0, 0.0), None, ("non-finite", 1)),
        (0.0, -INF, (0.0, 0.0), None, ("non-finite", 2)),
    ],
)
def test_the_monitor_takes_each_state_for_what_it_is(loop, v, omega, most, violated, stop):
    """At plant step 7: what is no number counts neither as fastest nor as beyond a limit."""
    one = coupled(loop)
    ends = one.ends((0.0, 0.0, 0.0, v, omega), 7)
    seen, time = one.monitor(), 7 * loop.scenario.clock.plant

    assert ends is (stop is not None)
    assert seen.max_abs_v == most
    assert seen.violations == (violated is not None)
    assert seen.first_violation == (violated and (time, violated))
    assert (seen.stop_reason, seen.stopped) == (
        (stop[0], (time, stop[1])) if stop else (seen.stop_reason, None)
    )


def test_a_torque_comes_near_its_command_as_fast_as_its_lag_of_this_sample(loop_with):
    """A lag that varies stays the same within a sample, and another sample has another."""
    slow, h, wanted = 0.02, 0.001, 3.0
    varying = loop_with({"actuator.lag": slow, "actuator.lag_spread": 0.5})
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
    """And draws the same numbers, and has seen nothing.  What is watched moves no counter."""
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
