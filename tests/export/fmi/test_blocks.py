"""Parts of the loop as models."""

import numpy as np
import pytest

from tests.papers_robot import paper
from wmr_ctrl.control.setup import settle
from wmr_ctrl.core.errors import ArgumentError, ScenarioError
from wmr_ctrl.export.fmi.blocks import CHANGED, guard_model, law_model, plant_model, stepped_plant
from wmr_ctrl.export.fmi.model_description import Role
from wmr_ctrl.world.model.dynamics import plant, rk4_step
from wmr_ctrl.world.scenario import override


def test_the_plants_step_is_that_of_the_loop():
    system, step = stepped_plant(paper())
    own, x = plant(paper()), [0.1, 0.2, 0.3, 0.4, 0.5]
    u = np.arange(1.0, own.u.numel() + 1)
    wanted = own.function("w", [rk4_step(own, 0.001)])(u, x, own.p0)

    found = step.function(u, x, system.p0)
    assert found.full()[:5] == pytest.approx(wanted.full(), rel=1e-14)


def test_of_a_plant_what_changes_in_a_run_is_tunable():
    model = plant_model(paper())
    roles = {item.name: item.role for item in model.variables}

    assert {name for name, role in roles.items() if role is Role.TUNABLE} == set(CHANGED)
    assert (roles["robot.r"], roles["tau_right"]) == (Role.FIXED, Role.INPUT)


def test_a_law_and_a_guard_give_torques():
    scenario = override(paper(), {"guard.enabled": True, "disturbance.truncate": 3.0})
    for model in (law_model(settle(scenario, "mb")), guard_model(settle(scenario, None))):
        torque = model.variables[model.row("tau_left")]
        assert (torque.output, torque.discrete, torque.unit) == (True, True, "N.m")
    with pytest.raises((ArgumentError, ScenarioError)):
        law_model(settle(scenario, None))
