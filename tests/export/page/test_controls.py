"""Sliders of the page."""

import pytest

from tests.papers_robot import paper
from wmr_ctrl.export.page.controls import controls_of
from wmr_ctrl.world.scenario import override


def test_a_slider_spans_a_fifth_to_five_times_its_value_within_its_bounds():
    scenario = override(paper(), {"guard.brake_share": 0.5, "robot.m": 40.0})
    keys = "robot.m robot.I robot.g limits.v_u1 limits.v_u2 guard.brake_share disturbance.push"
    given = [scenario.number(key) for key in keys.split()]
    values = {n: x for signal, own in given for n, x in zip(signal.elements, own, strict=True)}

    found = {item.name: item for item in controls_of(scenario, [s for s, _ in given], values)}

    names = "limits.v_u1[1] limits.v_u1[2] robot.m robot.I disturbance.push[1] disturbance.push[2]"
    assert list(found) == [*names.split(), "guard.brake_share"]
    assert found["robot.m"].span == (10.0, 150.0)
    assert found["robot.I"].span == pytest.approx((5.4 / 5, 5.4 * 5))
    assert found["guard.brake_share"].span == (pytest.approx(0.1), 1.0)
    assert found["limits.v_u1[2]"].along == ["limits.v_u2[2]"]
    assert found["limits.v_u1[2]"].meaning.endswith("(angular)")
    plain = [name for name, item in found.items() if not item.log]
    assert plain == ["disturbance.push[1]", "disturbance.push[2]"]
