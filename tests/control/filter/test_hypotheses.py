"""Hypotheses of a filter that a run of its base breaks."""

from tests.control.filter.test_peak_gain import scenario
from tests.tables import changes
from wmr_ctrl.control.filter.hypotheses import broken_hypotheses
from wmr_ctrl.world.effect import Bound
from wmr_ctrl.world.scenario import override


def test_a_quantum_must_be_stated():
    stated = scenario(kind="band", d=(0.01, 0.0), push=(0.0, 0.0))
    base = override(stated, changes("""
        base.kind = velocity
        base.loop = pi
        robot.mu = 0.0
        robot.m = 60.0
        changes = []
        base.kp = 150.0
        base.ki = 300.0
    """) | {"robot.I": 60 / 16})  # fmt: skip
    assert not broken_hypotheses(base, Bound(command=(0.01, 0.0)))
    (sentence,) = broken_hypotheses(base, Bound(command=(0.02, 0.0)))
    assert "off by 0.02 m/s (base.quantum). Raise filter.d[1] = 0.01 to that." in sentence
