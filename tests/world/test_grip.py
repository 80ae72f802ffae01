"""Torques at which wheels spin."""

import pytest

from tests.papers_robot import paper
from wmr_ctrl.world.grip import grip
from wmr_ctrl.world.scenario import override


def test_what_tyres_keep_is_the_least_of_all_phases():
    changes = [{"t": 1.0, "m": 20.0, "mu": 0.02}, {"t": 2.0, "m": 80.0, "mu": 0.2}]
    scenario = override(paper(), {"changes": changes})
    alone = [
        grip(override(paper(), {f"robot.{name}": change[name] for name in ("m", "mu")})).keep
        for change in changes
    ]

    assert grip(scenario).keep == pytest.approx(min(grip(paper()).keep, *alone))
    assert min(alone) < 0.9 * grip(paper()).keep
    assert grip(scenario).spin == grip(paper()).spin
