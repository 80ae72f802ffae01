"""What effects tell the guard, at the ends of what they admit."""

import pytest

from tests.papers_robot import paper
from wmr_ctrl.world.effect import Bound, total
from wmr_ctrl.world.scenario import override


@pytest.mark.parametrize("axis", [0, 1])
def test_two_means_of_one_axis_are_none_and_of_two_axes_are_two(axis):
    own, other = [0.0, 0.0], [0.0, 0.0]
    own[axis] = other[1 - axis] = 0.02
    one, two = Bound(window=tuple(own)), Bound(window=tuple(other))

    assert "window: two sensors average" in total([one, one]).void
    assert total([one, two]).void == ""
    assert total([one, two]).window == (0.02, 0.02)


@pytest.mark.parametrize("key", ["lag", "delay", "unmodelled_delay", "jitter"])
def test_drives_are_ideal_only_where_nothing_of_them_is_late(key):
    assert paper().actuator.ideal
    assert not override(paper(), {f"actuator.{key}": 0.01}).actuator.ideal
