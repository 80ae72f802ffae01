"""Model descriptions as XML."""

import xml.etree.ElementTree as ET

import pytest

from tests.papers_robot import paper
from wmr_ctrl.export.fmi.blocks import plant_model
from wmr_ctrl.export.fmi.files import sources_of
from wmr_ctrl.export.fmi.xml import description, documentation, terminals

MODEL = plant_model(paper())


@pytest.mark.parametrize("version", [2, 3])
def test_every_variable_stands_in_it_once_and_outputs_in_its_structure(version):
    text = description(MODEL, sources_of(MODEL, version), version, "toy tool", note=", noted")
    root = ET.fromstring(text)
    named = [item.get("name") for item in root.find("ModelVariables")]
    outputs = [item for item in MODEL.variables if item.output]

    assert sorted(named) == sorted(item.name for item in MODEL.variables)
    assert root.get("generationTool") == "toy tool"
    assert ", noted" in text
    structure = root.find("ModelStructure")
    found = structure.findall("Output") if version == 3 else list(structure.find("Outputs"))
    assert len(found) == len(outputs)


def test_terminals_are_those_whose_signals_are_there():
    text = terminals(MODEL)

    assert 'name="torque"' in text
    assert 'name="reference"' not in text
    assert MODEL.title in documentation(MODEL, "toy tool")
