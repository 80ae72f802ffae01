"""Numbers found in robot files, and the choice among several."""

import pytest

from wmr_ctrl.world.robot_files.found import Found, Rank, merged


def test_the_controller_counts_before_others_and_what_differs_is_told():
    mine = Found("robot.r", 0.1, "controller", Rank.CONTROLLER)
    near = Found("robot.r", 0.1005, "gazebo", Rank.GAZEBO)
    far = Found("robot.r", 0.12, "urdf", Rank.DESCRIPTION)

    sheet = merged([far, near, mine])

    assert sheet.found == {"robot.r": mine}
    assert sheet.overruled == (far,)


def test_a_base_brakes_as_it_speeds_up_and_axes_become_a_pair():
    one, two = (Found(f"base.accel[{k}]", float(k), f"file {k}", Rank.GAZEBO) for k in (1, 2))

    found = merged([two, one]).found

    assert found["base.accel"].value == found["base.decel"].value == (1.0, 2.0)
    assert found["base.accel"].source == "file 1; file 2"
    assert merged([one]).found["base.decel[1]"].value == 1.0


def test_a_multiplier_is_one_of_its_length():
    size = Found("robot.r", 0.1, "a", Rank.CONTROLLER)
    factor = Found("radius factor", 1.5, "b", Rank.CONTROLLER)

    assert merged([size, factor]).found["robot.r"].value == pytest.approx(0.15)
