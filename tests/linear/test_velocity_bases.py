"""Poles and margins of bases that take velocities, compared with changes of the base itself."""

import numpy as np
import pytest

from wmr_ctrl.control.setup import settle
from wmr_ctrl.core.errors import ArgumentError, ScenarioError
from wmr_ctrl.theory.checks.radius import largest_radius
from wmr_ctrl.theory.checks.sending import loop_of
from wmr_ctrl.theory.linear import closed_loop, margins_at, report_linear
from wmr_ctrl.world.scenario import load_scenario, override

T = 0.05


@pytest.fixture(scope="module")
def burger():
    return load_scenario("turtlebot3-burger", {"filter.kind": "none"})


@pytest.mark.parametrize("axis", [0, 1])
def test_the_gain_margin_is_the_gain_of_the_base_that_makes_it_unstable(burger, axis):
    """The law is prox, which rests on its reference at any gain of the base."""
    margin = margins_at(burger, "prox", axis, period=T)
    gains = [margin.gain if place == axis else 1.0 for place in (0, 1)]
    there = override(burger, {"base.gain": gains})

    assert largest_radius(loop_of(settle(there, "prox")), T) == pytest.approx(1.0, abs=1e-6)


@pytest.mark.parametrize("law", ["mb", "kanayama"])
@pytest.mark.slow
def test_poles_are_those_of_the_closed_loop_as_an_object_and_of_checks_radius(burger, law):
    off = override(burger, {"base.gain": [1.2, 0.9]})
    page = report_linear(off, law)
    poles = closed_loop(off, law, period=T).poles()
    told = np.exp(np.array([complex(*pair) for pair in page.to_json()["poles"]]) * T)

    assert page.rest > 1e-3
    assert page.stable
    assert max(np.abs(poles - pole).min() for pole in told) < 1e-6
    assert page.spectral_radius == pytest.approx(np.abs(told).max(), abs=1e-9)
    assert page.spectral_radius == pytest.approx(largest_radius(loop_of(settle(off, law)), T))
    assert "omega command, 0.05 s" in page.table()


def test_what_has_no_meaning_there_is_refused_with_a_remedy(burger):
    with pytest.raises(ArgumentError, match="no continuous loop"):
        closed_loop(burger, "mb")
    with pytest.raises(ScenarioError, match=r"guard\.enabled"):
        report_linear(burger, "mb", guard=True)
    weak = override(burger, {"base.gain": [0.5, 0.5]})
    with pytest.raises(ArgumentError, match="no resting point near its reference"):
        report_linear(weak, "pursuit")
