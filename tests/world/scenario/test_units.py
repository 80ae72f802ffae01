"""Values with a probably mistaken unit lead to a question, with the unit that may be meant."""

import pytest

from tests.tables import cases, changes
from wmr_ctrl.control.setup import settle
from wmr_ctrl.core.fields.section import quantities
from wmr_ctrl.core.fields.units import OTHERS, USUAL
from wmr_ctrl.theory.checks import warnings_for
from wmr_ctrl.world.references import REFERENCES
from wmr_ctrl.world.scenario import load_scenario
from wmr_ctrl.world.scenario.scenario import sections
from wmr_ctrl.world.scenario.units import unit_questions

SLIPS = """
    clock.control = 20 | Milliseconds? 20 ms is 0.02 s.
    filter.gain[2] = 110 | Per cent? 110 % is 1.1.
    reference.kind = line; reference.heading = -90 | Degrees? -90 deg is -1.571 rad.
    limits.v_u1[2] = 70 | Degrees per second? 70 deg/s is 1.222 rad/s.
    limits.v_u1[2] = 70 | Revolutions per minute? 70 rpm is 7.33 rad/s.
    robot.r = 80 | Millimetres? 80 mm is 0.08 m.
    robot.I = 5.4e4 | 54000 kg.cm2 is 5.4 kg.m2.
    reference.kind = line; reference.speed = 300 | Millimetres per second? 300 mm/s is 0.3 m/s.
    model.m = 50_000 | Grams? 50000 g is 50 kg.
    robot.mu = 8 | Per cent? 8 % is 0.08.
    guard.delay = [5, 5] | guard.delay[2] = 5 s is unusual
    initial.pose = [0, 0, 45] | initial.pose[3] = 45 rad is unusual
    changes = [{t = 1, m = 8e4}] | changes[1].m = 80000 kg is unusual
"""


def asked(scenario):
    return [sentence for _, sentence in unit_questions(scenario)]


@pytest.mark.parametrize("text, question", cases(SLIPS))
def test_a_slip_is_asked_about_with_its_remedy(text, question):
    assert any(question in item for item in asked(load_scenario("far-start", changes(text))))


def test_a_question_is_a_warning_of_every_law():
    setup = settle(load_scenario("far-start", {"robot.r": 80}), "mb")

    assert warnings_for(setup)[0].key == "robot.r"
    assert "Millimetres?" in warnings_for(setup)[0].sentence


@pytest.mark.parametrize(
    "size, words",
    [(1e-3, ""), (1.0, "5.41 km long. Millimetres?"), (0.15, "takes 1.2 h for 812.1 m")],
)
def test_a_very_long_way_is_asked_about(size, words):
    points = [[size * x, size * y] for x, y in ((0, 0), (1000, 0), (2000, 1000), (5000, 1000))]
    way = {"reference.kind": "waypoints", "reference.points": points, "reference.speed": 0.2}
    way["filter.frequency"] = [50, 100]  # as quick loops have
    said = asked(load_scenario("far-start", way))

    assert [words in item for item in said] == [True] * bool(words)


def test_units_of_all_fields_are_known_where_a_range_is_stated():
    tables = [*sections().values(), *(REFERENCES[kind].section for kind in REFERENCES)]
    stated = [what for cls in tables for _, what in quantities(cls) if what.usual]

    assert stated
    assert all(unit.strip() in OTHERS for what in stated for unit in what.unit.split(","))
    assert all(low < high for low, high in (*USUAL.values(), *(what.usual for what in stated)))
