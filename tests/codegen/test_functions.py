"""A loop's graphs without a compiler."""

import pytest

from tests.papers_robot import paper
from wmr_ctrl.codegen.functions import loop_functions
from wmr_ctrl.control.setup import settle
from wmr_ctrl.world.scenario import override


def test_it_has_the_numbers_of_its_scenario_and_streams_of_both_rates():
    scenario = override(paper(), {"disturbance.std": 0.5, "disturbance.truncate": 2.0})
    loop = loop_functions(settle(scenario, "mb"))

    assert loop.limits[:2] == pytest.approx(scenario.limits.v_u1, rel=1e-9)
    noise = next(item for item in loop.sampled if item.normal)
    assert (noise.wanted, noise.bound, noise.size) == (True, 2.0, 2)
    assert not loop.stepped
