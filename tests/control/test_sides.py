"""Limits of both directions, as graphs read them."""

import casadi as ca
import pytest

from tests.tables import changes
from wmr_ctrl.control.sides import sides
from wmr_ctrl.world.model.system import Parameters
from wmr_ctrl.world.scenario import load_scenario

APART = changes("limits.v_min = [0.0, -0.4]; limits.v_max = [0.3, 0.9]")


def numbers(scenario, kept=0.0):
    taken = Parameters(scenario)
    both = sides(scenario.limits, taken, kept)
    found = ca.Function("sides", [port.sym for port in taken.ports], [*both])
    return [side.full().ravel().tolist() for side in found(*(port.value for port in taken.ports))]


def test_one_limit_is_that_of_both_directions():
    scenario = load_scenario("paper-simulation")

    ahead, back = numbers(scenario)

    assert ahead == back == [*scenario.limits.v_u1]


def test_what_is_kept_back_is_a_share_of_the_larger_limit():
    """A direction with a limit of 0 still loses the rounding margin of the opposite direction."""
    scenario = load_scenario("paper-simulation", APART)

    assert numbers(scenario) == [[0.3, 0.9], [0.0, 0.4]]
    ahead, back = numbers(scenario, 0.1)
    assert ahead == pytest.approx([0.27, 0.81])
    assert back == pytest.approx([-0.03, 0.31])
