"""The memoryless clip, and ramps to its commands."""

import casadi as ca
import pytest

from tests.control.filter.test_filter import scenario
from wmr_ctrl.control.filter.clip import Clip, moved, ramp_shares
from wmr_ctrl.world.scenario import override


def test_each_axis_goes_as_far_as_its_change_allows():
    last, wanted, most = ca.SX([0.0, 1.0]), ca.SX([1.0, 0.0]), ca.SX([0.25, 2.0])
    shares = ca.vertcat(*ramp_shares(last, wanted, most))

    assert ca.evalf(shares).full().ravel() == pytest.approx([0.25, 1.0])
    assert ca.evalf(moved(last, wanted, shares)).full().ravel() == pytest.approx([0.25, 0.0])


def test_it_remembers_nothing_and_sends_within_its_limits():
    clip = Clip(override(scenario(), {"filter.kind": "clip"}))
    system = clip.system
    limits = ca.Function("limits", [system.p], [ca.vertcat(*clip.limits)])(system.p0).full().ravel()
    sent = system.function("sent", [clip.sent])

    assert system.state == ()
    found = sent([9.0, 0.0, clip.scenario.clock.control], [], system.p0).full().ravel()
    assert 0 < found[0] <= limits[0] * (1 + 1e-12)
    assert found[0] == pytest.approx(limits[0])
