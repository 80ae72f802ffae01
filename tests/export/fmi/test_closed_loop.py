"""The closed loop as one model."""

from tests.papers_robot import paper
from wmr_ctrl.control.setup import settle
from wmr_ctrl.export.fmi.closed_loop import FOUND, closed_loop_model
from wmr_ctrl.export.fmi.model_description import Role
from wmr_ctrl.world.scenario import override


def test_it_has_a_seed_its_start_and_its_findings():
    scenario = override(paper(), {"initial.pose": [1.0, 2.0, 0.5]})
    model = closed_loop_model(settle(scenario, "mb"))
    rows = {item.name: item for item in model.variables}

    assert (rows["seed"].integer, rows["seed"].role) == (True, Role.FIXED)
    assert [rows[f"initial.pose[{i}]"].start for i in (1, 2, 3)] == [1.0, 2.0, 0.5]
    assert {rows[name].output for name in FOUND.values()} == {rows["violations"].integer} == {True}
    assert Role.INPUT not in [item.role for item in model.variables]
