"""Inputs that a filter uses: recent odometry and free distances, and punctual samples."""

import casadi as ca
import numpy as np
import pytest

from tests.tables import changes
from wmr_ctrl.control.filter.governor_step import Governor
from wmr_ctrl.control.filter.heard import Heard, Watching
from wmr_ctrl.control.filter.ramp_stop import RampStopper
from wmr_ctrl.world.scenario import load_scenario

STATED = changes("""
    clock.control = 0.05
    filter.kind = governor
    filter.tau = [0.2, 0.3]
    filter.odometry = [0.02, 0.02]
    filter.age = 0.05
    filter.jitter = 0.005
    filter.delay = [0.0, 0.12]
""")
STOPS = changes("""
    filter.kind = clip
    filter.decel = [1.0, 2.0]
    filter.free_error = 0.02
    filter.free_age = 0.1
    filter.rest = 1.0
""")


def value(graph, expr, **known):
    """An expression of a graph, for values of its ports by name."""
    own = {name: getattr(graph, name) for name in ("odometry", "age", "elapsed", "free", "free_age")
           if hasattr(graph, name)}  # fmt: skip
    own["counted"] = graph.counted[0]
    ports = {
        **{name: item.sym for name, item in own.items()},
        "p": ca.vertcat(*(i.sym for i in graph.p.ports)),
    }
    numbers = {"p": [v for item in graph.p.ports for v in item.value]}
    given = {name: np.zeros(sym.shape) for name, sym in ports.items()} | numbers | known
    return float(ca.Function("heard", list(ports.values()), [expr])(*given.values()))


@pytest.fixture(scope="module")
def governor():
    return Governor(load_scenario("paper-simulation", STATED))


@pytest.fixture(scope="module")
def clip():
    return RampStopper(load_scenario("paper-simulation", {**STATED, **STOPS}))


@pytest.mark.parametrize("age, seen", [(-1, 0), (0, 1), (0.05, 1), (0.06, 0), (np.nan, 0)])
def test_odometry_counts_while_it_is_young(governor, age, seen):
    assert isinstance(governor, Heard)
    assert value(governor, governor.seen, age=age) == seen
    assert value(governor, governor.seen, age=age, odometry=[np.inf, 0]) == 0


@pytest.mark.parametrize("elapsed, came", [
    (0, 1), (0.05, 1), (0.055, 1), (0.045, 1), (0.06, 0), (0.04, 0), (-1, 0), (np.nan, 0),
])  # fmt: skip
def test_a_sample_comes_within_its_jitter(governor, elapsed, came):
    assert value(governor, governor.came, elapsed=elapsed) == came
    counted = value(governor, governor.in_time[0], elapsed=elapsed, counted=1)
    assert counted == (2 if came else 0)


def test_commands_are_in_time_once_all_that_may_act_are(governor):
    enough = governor.oldest
    assert value(governor, governor.punctual, elapsed=0.05, counted=enough - 1) == 1
    assert value(governor, governor.punctual, elapsed=0.05, counted=enough - 2) == 0
    assert value(governor, governor.in_time[0], elapsed=0.05, counted=enough) == enough


@pytest.mark.parametrize("age, fresh", [(-1, 0), (0, 1), (0.1, 1), (0.11, 0), (np.nan, 0)])
def test_free_distances_count_while_they_are_young_and_numbers(clip, age, fresh):
    assert isinstance(clip, Watching)
    assert value(clip, clip.is_fresh, free_age=age) == fresh
    assert value(clip, clip.hears(1), free_age=age, free=[np.nan, np.inf, 1, 1]) == fresh
    assert value(clip, clip.hears(0), free_age=age, free=[np.nan, 1, 1, 1]) == 0
