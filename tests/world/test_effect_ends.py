"""What effects tell the guard, at the ends of what they admit."""

from dataclasses import replace

import casadi as ca
import pytest

from tests.papers_robot import paper
from wmr_ctrl.core.errors import ArgumentError
from wmr_ctrl.world.effect import Bound, total
from wmr_ctrl.world.registry import EFFECTS
from wmr_ctrl.world.scenario import override
from wmr_ctrl.world.velocity_mean import VELOCITY_MEAN


@pytest.mark.parametrize("axis", [0, 1])
def test_two_means_of_one_axis_are_none_and_of_two_axes_are_two(axis):
    own, other = [0.0, 0.0], [0.0, 0.0]
    own[axis] = other[1 - axis] = 0.02
    one, two = Bound(window=tuple(own)), Bound(window=tuple(other))

    assert "window: two sensors average" in total([one, one]).void
    assert total([one, two]).void == ""
    assert total([one, two]).window == (0.02, 0.02)


def test_only_commands_and_drives_are_under_way():
    mean = next(item for item in EFFECTS if item.name == VELOCITY_MEAN.name)
    late = replace(
        mean, build=lambda scenario: replace(mean.build(scenario), transport=ca.SX(0.01))
    )

    with pytest.raises(ArgumentError, match="has a transport"):
        late.system(paper())


@pytest.mark.parametrize("key", ["lag", "delay", "unmodelled_delay", "jitter"])
def test_drives_are_ideal_only_where_nothing_of_them_is_late(key):
    assert paper().actuator.ideal
    assert not override(paper(), {f"actuator.{key}": 0.01}).actuator.ideal
