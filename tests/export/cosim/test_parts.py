"""FMUs as parts of a loop: their steps and their required outputs."""

import math
from types import SimpleNamespace

import pytest

from tests.papers_robot import paper
from wmr_ctrl.export.cosim.mapping import identity
from wmr_ctrl.export.cosim.parts import Part, limiter, ready, wheels_of


class Stub:
    """An FMU that returns its inputs."""

    def __init__(self):
        self.given, self.steps = [], []
        self.failure = ArithmeticError

    def writer(self, _names):
        return lambda values: self.given.__setitem__(slice(None), values)

    def reader(self, _names):
        return lambda: list(self.given)

    def step(self, t, h):
        self.steps.append((t, h))


def part(step=None, foreign=False):
    rows = identity(["a", "b"])
    return Part(Stub(), rows, rows, ["a", "b"], step, foreign=foreign)


@pytest.mark.parametrize("step, count", [(None, 1), (0.01, 3), (0.05, 1)])
def test_it_steps_by_its_own_size_to_the_end(step, count):
    own = part(step)
    reached = list(own.steps(1.0, 0.03, 1.03))

    assert len(own.slave.steps) == count
    assert reached[-1] == 1.03
    assert sum(h for _, h in own.slave.steps) == pytest.approx(0.03)


def test_what_a_foreign_part_gives_is_finite():
    own, theirs = part(), part(foreign=True)
    for item in (own, theirs):
        item.write([1.0, math.nan])

    assert own.read()[0] == 1.0
    with pytest.raises(ArithmeticError, match="which give b = nan"):
        theirs.read()


def test_wheels_turn_as_the_robot_moves():
    robot = SimpleNamespace(r=0.1, l=0.25)

    assert wheels_of((0.5, 0.4), robot) == pytest.approx((6.0, 4.0))
    assert ready((0.0, 0.0, 0.3, 0.5, 0.4), robot) == pytest.approx((0.3 + math.pi / 2, 6.0, 4.0))


def test_thrust_goes_before_turning_where_torques_are_limited():
    robot = paper().robot
    for asked, given in (([5.0, 3.0], [4.0, 4.0]), ([3.0, -1.0], [3.0, -1.0])):
        limited = limiter()(asked, robot.r, robot.l, 4.0).full().ravel()
        assert limited == pytest.approx(given)
