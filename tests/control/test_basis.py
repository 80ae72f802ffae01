"""Robot, base and path in the numbers from which gains follow."""

import pytest

from tests.papers_robot import paper
from tests.tables import changes
from wmr_ctrl.control.basis import REACHED, SLOWEST, basis_of
from wmr_ctrl.world.scenario import override


def test_it_is_the_believed_robot_on_its_path():
    basis = basis_of(override(paper(), changes("model.m = 40.0; base.accel = [1.0, 1e3]")))

    assert basis.mass[0] == 40.0
    assert basis.weight == pytest.approx(40.0 * 9.81 * 0.1)
    assert basis.accel == (1.0, pytest.approx(REACHED * basis.limits[1]))
    assert basis.speed >= SLOWEST * basis.limits[0]


def test_what_is_later_is_slower():
    rates = [basis_of(override(paper(), {"actuator.delay": late})).wo for late in (0.0, 0.05, 0.2)]

    assert rates == sorted(rates, reverse=True)
    assert rates[0] > rates[2]
