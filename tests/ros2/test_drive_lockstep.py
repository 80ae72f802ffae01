"""The drive's decisions, message by message, are the native loop's to the bit."""

import numpy as np
import pytest

from tests.ros2.lockstep import BASES, CARRIED, COMMON, messages, sent_by
from wmr_ctrl import simulate
from wmr_ctrl.control.filter.gate import GateSettings
from wmr_ctrl.control.setup import settle
from wmr_ctrl.ros2.clocks import Moment
from wmr_ctrl.ros2.drive_core import DriveCore, DriveSettings
from wmr_ctrl.world.registry import EFFECTS
from wmr_ctrl.world.scenario import load_scenario

WIDE = GateSettings(
    odometry="required", command_timeout=0.1, rise=(1e6, 1e6), fall=(1e6, 1e6), excess=(1.0, 1.0)
)
"""Ramps so wide that none acts, as in a run."""


@pytest.fixture
def carried(monkeypatch):
    monkeypatch.setitem(EFFECTS.__dict__, "plugins", (CARRIED,))


@pytest.mark.parametrize("base", BASES)
@pytest.mark.parametrize("simulated", [True, False])
@pytest.mark.slow_but("True-efforts, guard")
def test_every_command_is_that_of_the_run(carried, base, simulated):
    law, changes = BASES[base]
    scenario = load_scenario("paper-simulation", {**COMMON, **changes, "message.sent": 1.0})
    run = simulate(scenario, law)
    core = DriveCore(settle(scenario, law), DriveSettings(gate=WIDE))
    sent = []
    for message, stamp in messages(run, core.period):
        now = Moment(stamp, stamp, simulated)
        core.see(now)
        assert not sent or core.tick(now) is None  # fresh odometry leaves nothing to a timer
        reason, gated = core.odometry(message, stamp, "odom", "base_link", now)
        assert reason == ""
        sent.append(gated.command)
    expected = sent_by(run)

    assert np.array(sent).tobytes() == expected.tobytes()
    assert np.ptp(expected[:, 0]) > 0.01
    assert core.e == pytest.approx(run["e"][-1], abs=1e-12)
