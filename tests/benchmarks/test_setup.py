"""Numbers of the benchmarks and of the scenario that they stand for are the same."""

import pytest

from benchmarks.setup import Case, Setup
from wmr_ctrl.core.errors import ArgumentError
from wmr_ctrl.world.scenario import load_scenario


def test_defaults_are_the_papers_simulation():
    scenario = load_scenario("paper-simulation")

    assert Setup.from_scenario(scenario) == Setup()
    assert Case.from_scenario(scenario) == Case()


def test_a_scenario_without_noise_or_change_is_taken_over():
    case = Case.from_scenario(load_scenario("paper-simulation-nominal"), seed=3)

    assert (case.noise_std, case.first, case.seed) == (0.0, case.later, 3)


@pytest.mark.parametrize(
    "name, key, value",
    [
        ("paper-simulation", "gains.nn.integrator", "semi-implicit"),
        ("paper-simulation", "actuator.tau_max", 5.0),
    ],
)
def test_laws_that_the_c_does_not_know_are_refused(name, key, value):
    with pytest.raises(ArgumentError, match="hand-written laws cannot follow"):
        Setup.from_scenario(load_scenario(name, {key: value}))


def test_loops_that_the_c_does_not_know_are_refused():
    with pytest.raises(ArgumentError, match="hand-written loop cannot run"):
        Case.from_scenario(load_scenario("paper-experiment"))
