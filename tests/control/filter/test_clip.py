"""The memoryless clip, and ramps to its commands."""

import casadi as ca
import numpy as np
import pytest

from tests.control.filter.test_filter import scenario
from wmr_ctrl.control.filter.clip import Clip, moved, ramp_shares, swung
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


def test_commands_both_ways_keep_both_rooms_and_the_worst_loop_uses_one_up():
    """P a + Q b is at most the room in a's direction, with P and Q a loop's forward and backward
    swings.
    """
    N, least, most, own, other = symbols = [ca.SX.sym(name) for name in "NlmUD"]
    ends = [swung(N, least, most, *rooms) for rooms in ((own, other), (other, own))]
    clip = ca.Function("clip", symbols, ends)
    rng = np.random.default_rng(7)
    for _ in range(300):
        least, more, high = rng.uniform(0.2, 1), rng.uniform(0, 0.3), rng.uniform(0, 1)
        most, rooms = least + more, rng.uniform(0.1, 2, 2)
        a, b = (float(x) for x in clip(most + high, least, most, *rooms))
        loops = [((most + high + gain) / 2, (most + high - gain) / 2) for gain in (least, most)]
        spare = [min(rooms[0] - P * a - Q * b, rooms[1] - Q * a - P * b) for P, Q in loops]

        assert min(a, b) >= 0
        assert -1e-12 < min(spare) < 1e-9
