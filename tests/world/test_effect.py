"""Each effect of this package acts alike in engines, lanes, co-simulation and refusals."""

import casadi as ca
import numpy as np
import pytest

from tests import oracle
from tests.papers_robot import paper
from tests.tables import cases, changes
from tests.world.motion import (
    ALL,
    EFFECTS,
    LAW,
    scenario,
)
from wmr_ctrl.api import simulate
from wmr_ctrl.control.loop import LoopGraphs
from wmr_ctrl.control.setup import settle
from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.core.signals import TORQUE
from wmr_ctrl.world.effect import Bound, total
from wmr_ctrl.world.scenario import override

TWINNED = ("lost poses", "untold delay", "lag that varies")


def run_of(name):
    return simulate(scenario(ALL[name]), LAW, seed=3)


@pytest.mark.parametrize(
    "name", [*TWINNED, "encoder", "gyro", "motor", "resistance", "all at once"]
)
@pytest.mark.slow_but("lost poses", "all at once")
def test_the_engine_without_a_compiler_and_the_twin_agree(name):
    run, numpy = run_of(name), simulate(scenario(ALL[name]), LAW, seed=3, engine="numpy")
    assert max(np.abs(run[s.name] - numpy[s.name]).max() for s in run.signals) < 1e-9
    if name in TWINNED:
        slow = oracle.simulate(scenario(EFFECTS[name]), LAW, seed=3)
        assert max(np.abs(run[c] - slow[c]).max() for c in ("x", "theta", "v1", "omega")) < 1e-9


def test_laws_see_only_measured_values():
    """Torques depend on no true velocity if encoders measure it.

    The graph of a sample reads the pose (x, y, theta) from the plant, and the path length, which
    encoders count together with the orientation.
    """
    counted = {**EFFECTS["encoder"], "actuator.lag": 0.02, "disturbance.std": 0.0}
    for law in ("nn", "prox"):
        loop = LoopGraphs(settle(scenario(counted), law))
        true = {item.signal.name: item.sym for item in loop.plant.state}
        torque = loop.sample.column(TORQUE)
        seen = {name for name, sym in true.items() if ca.depends_on(torque, sym)}
        assert seen == {"x", "y", "theta", "path"}


def test_delays_of_effects_add_up_and_a_lag_cannot_be_split():
    late = {**EFFECTS["jitter of a delay"], "actuator.unmodelled_delay": 0.004}
    bound = settle(scenario({**late, **EFFECTS["encoder"]}), LAW).bound

    assert (bound.delay, bound.jitter) == (pytest.approx(0.021), 0.01)
    assert bound.window == (0.01, 0.01)
    assert "lag" in total([Bound(lag=(0.01, 0.02))] * 2).void
    assert "0.01 s cannot vary by 0.02" in total([Bound(delay=0.01, jitter=0.02)]).void


BAD = r"""
    encoder.counts = 10.5 | encoder\.counts = 10\.5 must be a whole number
    encoder.counts = 64; encoder.window = 0.015 | encoder\.window = 0\.015 s .*control
    encoder.counts = 64; sensor.velocity_window = 0.01 | encoder\.counts = 64 both
    actuator.jitter = 0.02 | actuator\.jitter = 0\.02 s must be at most clock\.control
    guard.delay = [0.02, 0.01] | guard\.delay = \[0\.02, 0\.01\].*wrong way.*\[0\.01, 0\.02
    guard.lag = [0.02, 0.01] | guard\.lag = \[0\.02, 0\.01\].*wrong way.*\[0\.01, 0\.02
    guard.delay = [0.0, 0.02] | guard\.delay = .* may not vary by more than clock\.control
    guard.delay = [-0.01, 0.01] | guard\.delay\[1\] = -0\.01 must be at least 0
    actuator.lag = [0.02, 0.03] | actuator\.lag =
    actuator.jitter = [0.0, 0.005] | actuator\.jitter =
    actuator.jitter = 0.0015 | actuator\.jitter = 0\.0015 s .*clock\.plant
    motor.free = 20.0 | motor\.free = 20\.0 rad/s does nothing without motor\.stall
"""


@pytest.mark.parametrize("text, message", cases(BAD))
def test_bad_numbers_are_refused_with_key_and_remedy(text, message):
    with pytest.raises(ScenarioError, match=message):
        scenario(changes(text))


def test_two_means_of_one_axis_are_none_and_of_two_axes_are_two():
    one, two = Bound(window=(0.02, 0.0)), Bound(window=(0.0, 0.02))

    for twice in (one, two):
        assert "window: two sensors average" in total([twice, twice]).void
    assert total([one, two]).void == ""
    assert total([one, two]).window == (0.02, 0.02)


@pytest.mark.parametrize("key", ["lag", "delay", "unmodelled_delay", "jitter"])
def test_drives_are_ideal_only_where_nothing_of_them_is_late(key):
    assert paper().actuator.ideal
    assert not override(paper(), {f"actuator.{key}": 0.01}).actuator.ideal
