"""A single push far beyond dbar: what it does without the guard, and with it."""

from __future__ import annotations

import numpy as np
import pytest

from tests.simulation.physics.shove import SHOVE
from wmr_ctrl import simulate
from wmr_ctrl.world.registry import EFFECTS

pytestmark = pytest.mark.slow
PUSHED = {
    "shove.force": 400.0, "shove.start": 10.0, "actuator.tau_max": 10.0,
    "disturbance.truncate": 3.0, "clock.duration": 24.0,
}  # fmt: skip


def test_mb_is_thrown_off_its_way_and_with_the_guard_it_is_not(monkeypatch):
    monkeypatch.setitem(EFFECTS.__dict__, "plugins", (SHOVE,))
    plain, guarded = (
        simulate("paper-simulation-no-switch", "mb", seed=2001, plant="mujoco", guard=guard,
                 overrides=PUSHED)
        for guard in (False, True)
    )  # fmt: skip
    away, kept = (
        np.hypot(run["x"] - run["x_d"], run["y"] - run["y_d"]) for run in (plain, guarded)
    )
    first = plain.settings.index(10.0)
    assert np.array_equal(away[:first], kept[:first]), "the guard had nothing to do before"
    assert plain["v1"][first + 15] > 0.5, "it came"
    assert away.max() > 1.0
    assert kept[first:].max() < 0.3
    assert kept[-100:].max() < 0.05
    assert guarded.monitor.bounds_left is not None, "400 N are beyond dbar, and the monitor says so"
