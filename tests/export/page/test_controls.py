"""Sliders of the page."""

import pytest

from tests.papers_robot import paper
from wmr_ctrl.core.signals import Signal
from wmr_ctrl.export.page.controls import ALONG, controls_of


def controls(*names, value=2.0):
    signals = [Signal(name, "kg", "toy", 2 if "v_u" in name else 1) for name in names]
    values = {element: value for item in signals for element in item.elements}
    return controls_of(paper(), signals, values)


def test_a_slider_goes_from_a_fifth_to_five_times_its_value():
    (mass,) = controls("robot.m", value=50.0)

    if mass.span == pytest.approx((10.0, 250.0)):
        assert mass.log
    assert mass.bounds[0] > 0
    assert mass.span[0] < 50.0 < mass.span[1]


def test_what_a_variant_decides_is_hidden_and_what_moves_along_has_no_slider():
    assert controls("clock.control", "robot.g") == []
    found = controls("limits.v_u1", "limits.v_u2")
    assert [item.name for item in found] == ["limits.v_u1[1]", "limits.v_u1[2]"]
    assert found[0].along == ALONG["limits.v_u1[1]"]
    assert found[0].meaning.endswith("(linear)")
