"""Hypotheses of a filter that a run of its base breaks."""

import pytest

from tests.control.filter.test_peak_gain import scenario
from tests.tables import changes
from wmr_ctrl.control.filter.hypotheses import broken_hypotheses
from wmr_ctrl.world.effect import Bound
from wmr_ctrl.world.scenario import override

BASE = changes("""
    base.kind = velocity
    base.loop = pi
    robot.mu = 0.0
    robot.m = 60.0
    changes = []
    base.kp = 150.0
    base.ki = 300.0
""") | {"robot.I": 60 / 16}  # fmt: skip


def test_a_quantum_must_be_stated():
    stated = scenario(kind="band", d=(0.01, 0.0), push=(0.0, 0.0))
    base = override(stated, BASE)
    assert not broken_hypotheses(base, Bound(command=(0.01, 0.0)))
    (sentence,) = broken_hypotheses(base, Bound(command=(0.02, 0.0)))
    assert "off by 0.02 m/s (base.quantum). Raise filter.d[1] = 0.01 to that." in sentence


@pytest.mark.parametrize("own, counts", [({}, False), ({"slew": (1.0, 1.0)}, True)])
def test_a_command_that_acts_as_0_pushes_on_unless_a_clip_alone_sends_it(own, counts):
    base = override(scenario(d=(0.01, 0.01), push=(0.0, 0.0), **own), BASE)
    said = broken_hypotheses(base, Bound(dropped=(0.02, 0.0)))
    assert bool(said) == counts


@pytest.mark.parametrize("name", ["m", "I"])
def test_a_loop_that_changes_has_no_peak_gain(name):
    base = override(scenario(), BASE | {"changes": [{"t": 1.0, name: 9.0}]})
    assert any("[[changes]]" in text for text in broken_hypotheses(base, Bound()))
