"""Noise and drives, which the theorems leave out."""

from tests.corridor.further import EXACT
from wmr_ctrl.cli.check_sentences import promise
from wmr_ctrl.control.setup import settle
from wmr_ctrl.theory.checks import grip_warnings, warnings_for
from wmr_ctrl.world.scenario import load_scenario


def test_a_base_that_takes_velocities_gets_no_advice_on_torques_of_the_law():
    """A law on a velocity base sends no torque and takes no guard, so advice on both is omitted."""
    free = {"filter.kind": "none", "initial.pose": [-2.0, -2.0, 0.0]}
    setup = settle(load_scenario("turtlebot3-burger", free), "pid")
    said = " ".join(str(item) for item in (*warnings_for(setup), *grip_warnings(setup)))

    assert "At its first sample" not in said
    assert "switch the guard on" not in said
    assert "set a filter.kind, or start nearer" in said


def test_a_filter_is_named_where_there_is_none():
    setup = settle(load_scenario("turtlebot3-burger", {**EXACT, "filter.kind": "none"}), "prox")
    (found,) = [item for item in warnings_for(setup) if item.key == "filter.kind"]

    assert 'Set filter.kind = "clip"; what [filter] has to state' in found.sentence
    assert 'Set filter.kind = "clip"; what [filter] has to state' in promise(setup)
