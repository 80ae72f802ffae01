"""Parameters of controllers, of nav2 and of Gazebo, and which one counts if they disagree."""

import pytest

from tests.world.robot_files.test_urdf import PAIR, assert_refused, read, robot, times_refused
from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.world.robot_files import read_robot_files
from wmr_ctrl.world.robot_files.parameter_files import nodes

CONTROLLER = """
controller_manager:
  ros__parameters:
    update_rate: 100
    base: {type: diff_drive_controller/DiffDriveController}
/**:
  base:
    ros__parameters:
      left_wheel_names: [l_joint]
      right_wheel_names: [r_joint]
      wheel_separation: 0.5
      wheel_separation_multiplier: 1.5
      wheel_radius: 0.2
      left_wheel_radius_multiplier: 1.0
      right_wheel_radius_multiplier: 0.9
      cmd_vel_timeout: 0.25
      publish_rate: 30.0
      base_frame_id: base_footprint
      odom_frame_id: odom
      use_stamped_vel: false
      linear: {x: {max_velocity: 1.0, min_velocity: -0.4, max_acceleration: 2.0}}
      angular.z.max_velocity: 2.0
      angular.z.max_acceleration: 4.0
      angular.z.min_acceleration: -3.0
      linear.x.max_jerk: .nan
"""
ROS1 = """
old_controller:
  type: diff_drive_controller/DiffDriveController
  left_wheel: l_joint
  right_wheel: [r_joint]
  wheel_separation_multiplier: 1.25
  linear: {x: {has_velocity_limits: false, max_velocity: 3.0}}
"""
NAV2 = """
velocity_smoother:
  ros__parameters:
    smoothing_frequency: 20.0
    max_velocity: [0.5, 0.0, 1.5]
    min_velocity: [-0.3, 0.0, -1.5]
    max_accel: [2.5, 0.0, 3.2]
    max_decel: [-2.0, 0.0, -3.2]
    odom_topic: odometry/filtered
controller_server:
  ros__parameters:
    controller_plugins: [FollowPath]
    FollowPath: {plugin: "nav2_mppi_controller::MPPIController", vx_max: 0.6, vx_min: 0.0}
local_costmap:
  local_costmap:
    ros__parameters: {footprint: "[[0.3, 0.4], [-0.3, 0.4], [-0.3, -0.4]]", global_frame: map}
"""
GAZEBO = """
<gazebo><plugin filename="libgazebo_ros_diff_drive.so" name="drive">
<ros><remapping>cmd_vel:=cmd</remapping></ros><leftJoint>l_joint</leftJoint>
<rightJoint>r_joint</rightJoint><wheelSeparation>0.6</wheelSeparation><wheelDiameter>0.3</wheelDiameter>
<update_rate>50</update_rate><odometry_frame>wheel_odom</odometry_frame></plugin></gazebo>
"""
GZ = """
<sdf><model name="m"><plugin filename="gz-sim-diff-drive-system" name="gz::sim::systems::DiffDrive">
<wheel_separation>0.6</wheel_separation><wheel_radius>0.15</wheel_radius>
<max_linear_velocity>0.7</max_linear_velocity><min_linear_velocity>-0.7</min_linear_velocity>
<max_angular_acceleration>2</max_angular_acceleration></plugin></model></sdf>
"""


def values(tmp_path, *texts, name="file{}.yaml"):
    return {key: item.value for key, item in read(tmp_path, *texts, name=name).found.items()}


def test_controller(tmp_path):
    assert values(tmp_path, CONTROLLER) == {
        "robot.l": 0.375, "robot.r": 0.19, "base.timeout": 0.25, "clock.control": 0.033,
        "limits.v_max": (1.0, 2.0), "limits.v_min": (-0.4, -2.0),
        "base.accel": (2.0, 4.0), "base.decel": (2.0, 3.0),
        "ros.base_frame": "base_footprint", "ros.odometry_frame": "odom", "ros.stamped": False,
        "ros.cmd_vel": "/base/cmd_vel_unstamped", "ros.odom": "/base/odom",
    }  # fmt: skip


def test_multiplier_of_ros_1_stretches_the_track_of_the_description(tmp_path):
    (tmp_path / "control.yaml").write_text(ROS1, encoding="utf-8")
    (tmp_path / "r.urdf").write_text(robot(PAIR), encoding="utf-8")
    found = read_robot_files([tmp_path / "r.urdf", tmp_path / "control.yaml"]).found

    assert found["robot.l"].value == 0.25
    assert "limits.v_u1[1]" not in found


def test_a_path_follower_that_never_reverses(tmp_path):
    """Also with a least speed, since a base must be allowed to stop."""
    for least in ("0.0", "0.08"):
        text = NAV2.replace("velocity_smoother", "x").replace("vx_min: 0.0", f"vx_min: {least}")
        found = values(tmp_path, text, name="{}.yaml")
        assert (found["limits.v_max[1]"], found["limits.v_min[1]"]) == (0.6, 0.0)
        assert "limits.v_u1" not in found


def test_gazebo(tmp_path):
    described = values(tmp_path, robot(PAIR, GAZEBO), name="{}.urdf")
    assert (described["robot.l"], described["robot.r"], described["clock.control"]) == (
        0.3,
        0.15,
        0.02,
    )
    assert (described["ros.cmd_vel"], described["ros.odometry_frame"]) == ("cmd", "wheel_odom")
    assert values(tmp_path, GZ, name="{}.sdf") == {
        "robot.l": 0.3, "robot.r": 0.15, "limits.v_u1[1]": 0.7, "base.accel[2]": 2.0,
        "base.decel[2]": 2.0,
    }  # fmt: skip


def test_gz_limits_of_both_axes_count_where_they_are_smaller(tmp_path):
    both = "<max_velocity>1</max_velocity><min_velocity>-0.5</min_velocity><max_acceleration>1.5<"
    text = GZ.replace("<max_linear_velocity>", f"{both}/max_acceleration><max_linear_velocity>")
    found = values(tmp_path, text, name="{}.sdf")
    assert (found["limits.v_max"], found["limits.v_min"]) == ((0.7, 1.0), (-0.5, -0.5))
    assert found["base.accel"] == (1.5, 1.5)


def test_controller_counts_and_both_are_told(tmp_path):
    sheet = read(tmp_path, NAV2, CONTROLLER, name="{}.yaml")

    assert sheet.found["limits.v_min"].value == (-0.4, -1.5)
    told = {(item.key, item.value) for item in sheet.overruled}
    assert {("limits.v_min[1]", -0.3), ("limits.v_max[2]", 1.5), ("clock.control", 0.05)} <= told


def test_half_of_a_pair_that_a_controller_names_is_refused(tmp_path):
    for lost in ("l_joint", "r_joint"):
        (tmp_path / "c.yaml").write_text(CONTROLLER.replace(lost, "x_joint"), encoding="utf-8")
        (tmp_path / "r.urdf").write_text(robot(PAIR), encoding="utf-8")
        with pytest.raises(ScenarioError, match=r"r.urdf has ._joint, but no joint x_joint"):
            read_robot_files([tmp_path / "r.urdf", tmp_path / "c.yaml"])


RADIUS = "wheel_radius: 0.2"
FAULTS = {
    "is of no known kind": "a: {ros__parameters: {b: 1}}",
    "no known kind": "- 1",
    "has two differential drives, base and other": CONTROLLER
    + "other: {ros__parameters: {wheel_separation: 1.0}}",
    "is not YAML": "a: [",
    "is stated twice": CONTROLLER.replace(RADIUS, f"{RADIUS}\n      {RADIUS}"),
    "must be above 0": CONTROLLER.replace(RADIUS, "wheel_radius: -0.2"),
    "angular.z.max_velocity = -2 must be above": CONTROLLER.replace("y: 2.0", "y: -2.0"),
    "must be three numbers": NAV2.replace("[2.5, 0.0, 3.2]", "[2.5, 3.2]"),
    "must be a number": CONTROLLER.replace(RADIUS, "wheel_radius: [0.2]"),
    "of usual size": CONTROLLER.replace(RADIUS, "wheel_radius: .inf"),
    "substitution": CONTROLLER.replace(RADIUS, 'wheel_radius: "$(var r)"'),
    "is no point": NAV2.replace("[-0.3, 0.4]", "0.3"),
    "has an alias": "a: &a [1]\nb: [*a, *a]\n",
}  # fmt: skip


@pytest.mark.parametrize("words", FAULTS)
def test_faulty_file_is_refused_in_words(words, tmp_path):
    assert_refused(tmp_path, FAULTS[words], words, "file{}.yaml")


def test_every_cut_and_altered_file_is_read_or_refused(tmp_path):
    pieces = ["", "nan", "-1e308", "[", "{a: 1}", "ü\u2028", "null", "*a", "&a", "!!python/none"]
    assert 50 < times_refused(tmp_path, CONTROLLER + NAV2, pieces, "{}.yaml") < 300


def test_nodes_have_their_parameters_flat_by_dotted_name():
    of_ros2 = {"/**": {"a": {"/b": {"ros__parameters": {"x": {"y": 1}, "z": [2, 3]}}}}}

    assert list(nodes(of_ros2)) == [("a/b", {"x.y": 1, "z": [2, 3], "z[1]": 2, "z[2]": 3})]
    assert list(nodes({"c": {"type": "drive", "r": 1}})) == [("c", {"type": "drive", "r": 1})]
    assert list(nodes({"type": "no node"})) == list(nodes(7)) == []
