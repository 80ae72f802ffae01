"""Margins of both axes together, robots that differ from the model, and requested times."""

import numpy as np
import pytest

from tests.papers_robot import paper
from wmr_ctrl.theory.linear import margins
from wmr_ctrl.theory.linear.linearise import instant
from wmr_ctrl.theory.linear.margins import Margins, model_errors, with_robot, worst
from wmr_ctrl.world.references import sample
from wmr_ctrl.world.scenario import override


def test_the_worse_of_two_margins_is_the_nearer_to_one():
    one = Margins(2.0, 0.5, 60.0, 0.1, 0.9, 2.6, 50.0)
    other = Margins(3.0, 0.7, 40.0, None, 0.8, 2.3, 55.0)

    assert worst([one, other]) == Margins(2.0, 0.7, 40.0, 0.1, 0.8, 2.3, 50.0)
    assert worst([one, None]) is None


def test_a_robot_that_differs_is_believed_to_be_what_it_was():
    scenario = override(paper(), {"model.m": 45.0})
    other = with_robot(scenario, m=2.0, I=0.5, mu=3.0)

    assert (other.robot.m, other.robot.I, other.robot.mu) == pytest.approx((100.0, 2.7, 0.24))
    assert (other.believed.m, other.believed.I, other.believed.mu) == (45.0, 5.4, 0.08)


@pytest.mark.parametrize("changed, period", [({}, None), ({"actuator.delay": 0.02}, 0.01)])
def test_late_loops_are_sampled_and_each_number_is_half_off_either_way(
    monkeypatch, changed, period
):
    asked = []

    def margins_of(scenario, law, axis, point, period):
        robot = scenario.robot
        asked.append((robot.m / 50, robot.I / 5.4, robot.mu / 0.08, axis, period))

    monkeypatch.setattr(margins, "margins_at", margins_of)
    monkeypatch.setattr(margins, "on_reference", lambda *_: None)
    monkeypatch.setattr(margins, "largest_stable_period", lambda *_: 0.5)
    errors = model_errors(override(paper(), changed), "mb")

    cases = [(name, factor) for name in ("m", "I", "mu") for factor in (0.5, 1.5)]
    assert [(e.parameter, e.factor) for e in errors] == cases
    own = [[f if name == item else 1.0 for item in ("m", "I", "mu")] for name, f in cases]
    assert np.array([row[:3] for row in asked]) == pytest.approx(np.repeat(own, 2, axis=0))
    assert [row[3:] for row in asked] == [(0, period), (1, period)] * 6


def test_where_no_time_is_asked_for_it_is_where_the_reference_drives_fastest():
    scenario = override(paper(), {"reference.kind": "stop-and-go"})
    v = sample(scenario, np.linspace(0.0, scenario.reference.cycle, 1001))[:, 3]

    assert sample(scenario, np.array([instant(scenario, None)]))[0, 3] == pytest.approx(
        v.max(), rel=1e-3
    )
    assert np.ptp(v) > 0.1
