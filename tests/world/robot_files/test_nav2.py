"""Parameters of nav2."""

import pytest

from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.world.robot_files.nav2 import read, reads


def test_only_nodes_that_say_something_on_the_robot_are_read():
    known = ("velocity_smoother", "a/controller_server", "local_costmap/local_costmap")

    assert all(map(reads, known))
    assert not reads("planner_server")


def test_a_footprint_is_as_large_as_its_farthest_corner():
    params = {"footprint": "[[0.3, 0.4], [-0.1, 0.2]]"}
    (radius,) = [i for i in read("global_costmap", params, "nav2.yaml") if i.key == "body.radius"]

    assert radius.value == pytest.approx(0.5, rel=1e-3)
    with pytest.raises(ScenarioError, match=r"footprint: \[1, 2, 3\] is no point"):
        list(read("global_costmap", {"footprint": "[[1, 2, 3]]"}, "nav2.yaml"))
