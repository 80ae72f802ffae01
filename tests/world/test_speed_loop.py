"""Axes that each kind of speed loop drives."""

from tests.world.motion import based
from wmr_ctrl.world.scenario import override
from wmr_ctrl.world.speed_loop import has_loop


def test_only_a_base_that_takes_velocities_has_a_loop_on_each_axis():
    mixed = based(loop=["first-order", "pi"])

    assert has_loop(mixed, "pi", [1])
    assert not has_loop(mixed, "pi")
    assert has_loop(based(), "first-order")
    assert not has_loop(override(based(), {"base.kind": "torque"}), "first-order")
