"""Parameters of ros2_control's differential drive."""

from wmr_ctrl.world.robot_files.controllers import is_controller, read


def found(**params):
    return {item.key: item.value for item in read("base", params, "robot.yaml")}


def test_limits_are_of_the_axis_and_may_be_switched_off():
    limits = {"linear.x.max_velocity": 1.0, "angular.z.max_velocity": 2.0}

    assert found(**limits) == {"limits.v_max[1]": 1.0, "limits.v_max[2]": 2.0}
    off = found(**limits, **{"angular.z.has_velocity_limits": False})
    assert off == {"limits.v_max[1]": 1.0}


def test_topics_are_below_the_controllers_name_stamped_or_not():
    names = {"left_wheel_names": ["left"]}

    assert is_controller(names)
    assert not is_controller({"max_velocity": 1.0})
    assert found(**names)["ros.cmd_vel"] == "/base/cmd_vel"
    plain = found(**names, use_stamped_vel=False)
    assert plain["ros.cmd_vel"] == "/base/cmd_vel_unstamped"
    assert plain["ros.odom"] == "/base/odom"
