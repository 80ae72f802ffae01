"""The differential drive of Gazebo."""

import pytest

from wmr_ctrl.world.robot_files.gazebo import drives, joints, read
from wmr_ctrl.world.robot_files.xml_text import tree


def plugin(name, parts):
    return tree(f'<robot><plugin name="{name}">{parts}</plugin></robot>', "robot.sdf")


def test_both_spellings_are_read_and_a_radius_is_half_of_the_diameter():
    new = plugin(
        "diff_drive",
        "<left_joint>l</left_joint><right_joint> r </right_joint>"
        "<wheel_separation>0.5</wheel_separation><wheel_diameter>0.3</wheel_diameter>"
        "<remapping>cmd_vel:=go</remapping>",
    )
    old = plugin("DiffDrive", "<wheelSeparation>0.5</wheelSeparation>")

    (drive,) = drives(new)
    assert joints(drive) == ["l", "r"]
    found = {item.key: item.value for item in read(drive, "robot.sdf")}
    assert found["robot.r"] == pytest.approx(0.15)
    assert "go" in found["ros.cmd_vel"]
    assert len(drives(old)) == 1


def test_another_plugin_is_no_drive():
    assert drives(plugin("camera", "<wheel_separation>1</wheel_separation>")) == []
    assert drives(plugin("diff_drive", "<rate>1</rate>")) == []
