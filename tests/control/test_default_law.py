"""The law that drives where none is named."""

from dataclasses import replace

from tests.papers_robot import paper
from wmr_ctrl.control.default_law import UNSTATED, default_law, judges_gains, law_of
from wmr_ctrl.world.scenario import override


def test_a_named_law_counts_before_the_scenarios_and_that_before_ours():
    stated = override(paper(), {"law": "pid"})

    assert [law_of(stated, name) for name in (None, "mb")] == ["pid", "mb"]
    assert default_law(stated).why == "stated in the scenario"
    assert law_of(paper(), None) == UNSTATED
    assert default_law(paper()).why == "not stated"


def test_gains_are_judged_where_they_are_somebodys_choice():
    stated = override(paper(), {"law": "pid"})

    assert judges_gains(stated, "pid", asked=False)
    assert not judges_gains(stated, "mb", asked=False)
    assert judges_gains(stated, "mb", asked=True)
    unstated = replace(paper(), gains={})
    assert not judges_gains(unstated, UNSTATED, asked=False)
    own = override(unstated, {f"gains.{UNSTATED}.share": 0.9})
    assert judges_gains(own, UNSTATED, asked=False)
