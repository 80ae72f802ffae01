"""Robot files are recognised by their content."""

import pytest

from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.world.robot_files.read import read_robot_files

DRIVE = "<plugin name='diff_drive'><wheel_separation>1</wheel_separation></plugin>"
CONTROLLER = "{}: {{ros__parameters: {{left_wheel_names: [l], wheel_radius: 0.1}}}}\n"


@pytest.mark.parametrize(
    "name, text, words",
    [
        ("a.yaml", "planner: {ros__parameters: {rate: 1}}", "no node of it is a diff_drive"),
        ("a.yaml", CONTROLLER.format("one") + CONTROLLER.format("two"), "drives, one and two"),
        ("a.sdf", f"<sdf>{DRIVE}{DRIVE}</sdf>", "2 differential drives of Gazebo"),
        ("a.sdf", "<sdf/>", "neither a <robot> with links nor"),
        ("a.txt", "", "must end in .urdf or .xacro"),
    ],
)
def test_what_is_no_robot_is_named(tmp_path, name, text, words):
    (tmp_path / name).write_text(text)

    with pytest.raises(ScenarioError) as caught:
        read_robot_files([tmp_path / name])
    assert words in str(caught.value)
