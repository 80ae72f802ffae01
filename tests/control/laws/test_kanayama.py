"""Kanayama's kinematic law above the velocity loop: command, limits and force are the twin's."""

from tests.control.laws.points import assert_twin
from tests.tables import changes
from wmr_ctrl.control.laws.kanayama import LAW

OTHER = changes("""
    clock.control = 0.05
    model.m = 60.0
    model.I = 4.0
    model.mu = 0.1
    gains.kanayama.k = [1.5, 2.0, 3.0]
    gains.kanayama.rate = [9.0, 6.0]
    gains.kanayama.a_max = [2.0, 6.0]
""")


def test_command_and_force_are_those_of_its_formulas():
    assert_twin(LAW.name)
    assert_twin(LAW.name, **OTHER)


def test_behind_a_delay_it_is_asked_about_the_time_when_its_command_acts():
    assert_twin(LAW.name, **changes("actuator.delay = 0.015; gains.kanayama.delay = 0.015"))
