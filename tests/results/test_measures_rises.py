"""Rises of the barrier function, weights, distance and settling."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from wmr_ctrl.core.signals import Signal
from wmr_ctrl.results import Rises, rises
from wmr_ctrl.results.measures import settling_time, weight_norm

WEIGHTS = (Signal("W_norm", "1", "norm of the weights", 2),)


@given(values=st.lists(st.integers(-1000, 1000), min_size=100, max_size=100))
def test_rises_less_falls_are_the_change_over_the_run(make_run, values):
    up, down = rises(make_run(V1=values)), rises(make_run(V1=-np.array(values)))

    assert up.total - down.total == values[-1] - values[0]
    assert up.count + down.count == sum(a != b for a, b in pairwise(values))
    assert up.largest == max(0, *np.diff(values))


def test_rises_are_those_between_the_samples_of_the_window(make_run):
    stairs = np.where(np.arange(100) < 50, 0.0, 1.0)
    run = make_run(V1=stairs)

    assert rises(run, 0.49, 0.51) == Rises(1, 1.0, 1.0)
    assert rises(run, 0.0, 0.5) == rises(run, 0.5) == Rises(0, 0.0, 0.0)
    assert rises(run, 0.5, 1.2) is None


def test_weight_norms_at_the_end_and_at_their_largest(make_run):
    first = np.concatenate([np.arange(60.0), np.arange(40.0)])
    norms = np.stack([first, np.arange(100.0)], axis=1)
    found = weight_norm(make_run(extra=WEIGHTS, W_norm=norms))

    assert found == {"end": [39.0, 99.0], "largest": [59.0, 99.0]}
    assert weight_norm(make_run()) is None
    assert weight_norm(make_run(extra=WEIGHTS, rows=0)) is None


def test_the_settling_time_is_the_start_of_the_last_stay(make_run):
    away = np.ones(100)
    away[20:30] = away[70:] = 0.1

    assert settling_time(make_run(x=away), 0.1) == pytest.approx(0.7)
    assert settling_time(make_run(x=away), 0.09) is None
    assert settling_time(make_run(x=away), 1.0) == 0.0


def test_a_nan_distance_is_not_near(make_run):
    assert settling_time(make_run(x=np.nan), 1.0) is None
