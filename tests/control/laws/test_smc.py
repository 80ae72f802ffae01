"""The adaptive sliding mode."""

from tests.control.laws.points import assert_twin
from wmr_ctrl.control.laws.smc import LAW


def test_estimates_learn_by_the_error_and_the_force_adds_what_is_learnt():
    assert_twin(LAW.name)
