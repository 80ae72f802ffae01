"""The PID law."""

from tests.control.laws.points import assert_twin
from wmr_ctrl.control.basis import ANY_BASIS
from wmr_ctrl.control.laws.pid import LAW, rule


def test_pid_differentiates_from_the_second_sample_on():
    assert_twin(LAW.name)


def test_gains_that_follow_damp_and_differentiate_nothing():
    assert rule(ANY_BASIS) == {"Kp": ANY_BASIS.damping, "Kd": (0.0, 0.0)}
