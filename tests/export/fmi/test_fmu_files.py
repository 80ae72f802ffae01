"""FMUs by their names and versions."""

import pytest

from tests.papers_robot import paper
from wmr_ctrl.core.errors import ScenarioError, UnknownNameError
from wmr_ctrl.export.fmi.fmu_files import export_fmu, model_of, scenario_given, versions_of
from wmr_ctrl.world.scenario import override


@pytest.mark.parametrize("given, versions", [("2", (2,)), (3, (3,)), ("both", (2, 3))])
def test_versions_are_named_by_numbers_or_both(given, versions):
    assert versions_of(given) == versions
    with pytest.raises(UnknownNameError, match="no version of FMI is named '4'"):
        versions_of(4)


@pytest.mark.parametrize("what", ["plant", "reference", "closed-loop", "pid"])
def test_a_model_is_called_by_its_name(what):
    assert model_of(what, "pid", paper()).what == what


def test_what_is_no_model_or_is_not_for_this_base_is_refused(tmp_path):
    with pytest.raises(UnknownNameError, match=r"no FMU is named 'plnt' \(near: plant"):
        model_of("plnt", "pid", paper())
    base = override(paper(), {"base.kind": "velocity"})
    with pytest.raises(ScenarioError, match="the plant is exported only for robots"):
        export_fmu("plant", scenario=base, out=tmp_path)
    assert list(tmp_path.iterdir()) == []
    assert scenario_given(paper()) == paper()
    with pytest.raises(UnknownNameError):
        scenario_given(override(paper(), {"gains": {"pdi": {"k": 1.0}}}))
