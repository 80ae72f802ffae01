"""A loop's graphs without a compiler."""

from __future__ import annotations

import numpy as np
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


def test_a_step_at_rest_stays_where_it_is():
    scenario = override(paper(), {"initial.velocity": [0.0, 0.0]})
    loop = loop_functions(settle(scenario, "mb"))
    fast = len(loop.step.outputs[0])
    place = next(k for k, item in enumerate(loop.step.inputs) if len(item) == fast)
    loop.step.inputs[place][:] = np.array(loop.numbers.start)[:fast]
    for k, item in enumerate(loop.step.inputs):
        if len(item) == len(loop.numbers.parameters[0]):
            loop.step.inputs[k][:] = loop.numbers.parameters[0]
    loop.step()

    assert np.isfinite(loop.step.outputs[0]).all()
    assert loop.step.outputs[0][:3] == pytest.approx(np.array(loop.numbers.start)[:3], abs=1e-9)
