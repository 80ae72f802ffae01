"""Model descriptions as XML."""

from tests.papers_robot import paper
from wmr_ctrl.export.fmi.blocks import plant_model
from wmr_ctrl.export.fmi.xml import documentation

MODEL = plant_model(paper())


def test_the_page_of_a_model_has_its_title():
    assert MODEL.title in documentation(MODEL, "toy tool")
