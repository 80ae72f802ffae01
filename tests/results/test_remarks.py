"""Remarks: each key in the right case, with its numbers; and the figures behind them."""

import numpy as np
import pytest

from tests.results.conftest import build
from wmr_ctrl.api import simulate
from wmr_ctrl.core.signals import GUARD_DIAGNOSTICS
from wmr_ctrl.results import Monitor, percent, position_rms
from wmr_ctrl.results.measures import (
    guard_share,
    position_max,
)

CLIP = next(signal for signal in GUARD_DIAGNOSTICS if signal.name == "clip_active")


def keys(run):
    return [item.key for item in run.remarks]


def remark(run, key):
    (text,) = (item.text for item in run.remarks if item.key == key)
    return text


def test_position_is_the_straight_distance():
    away = np.where(np.arange(100) < 75, 0.0, 0.05)
    run = build(x=3 + 0.6 * away, x_d=3.0, y=1.0, y_d=1 + 0.8 * away, theta=3.0)

    assert position_rms(run) == pytest.approx({"all": 0.025, "last_quarter": 0.05})
    assert position_max(run) == pytest.approx(0.05)


def test_guard_share_is_per_axis_and_zero_without_guard():
    clipped = {"extra": (CLIP,), "clip_active": np.tile([[1.0, 0.0], [0.0, 0.0]], (50, 1))}

    assert guard_share(build(**clipped, labels={"guard": True})) == (0.5, 0.0)
    assert guard_share(build(**clipped)) == (0.0, 0.0)
    assert guard_share(build(labels={"guard": True})) is None


def test_the_outcome_is_a_remark_too():
    beyond = Monitor((1.7, 1.2), 12, (0.0125, 1), bounds_left=(0.5, 1))

    assert keys(build(monitor=beyond)) == ["limit-violated"]
    guarded = build(monitor=beyond, labels={"guard": True})
    assert keys(guarded) == ["limit-violated", "bounds-left"]
    assert "completed" not in remark(guarded, "bounds-left")
    assert "linear velocity v1 at t = 0.5 s" in remark(guarded, "bounds-left")


@pytest.mark.parametrize("engine", ["native", "numpy"])
@pytest.mark.parametrize("share, counted", [(1e-13, False), (1e-9, True)])
def test_rounding_is_no_violation(engine, share, counted):
    """A start beyond the limit by this amount, and no other violation after it."""
    start = {"initial.velocity": [1.0 + share, 0.0], "disturbance.std": 0.0}
    short = {"clock.duration": 0.2, "changes": [], "guard.enabled": False}
    run = simulate("safe-simulation", "kanayama", engine=engine, overrides={**start, **short})

    assert run.monitor.max_abs_v[0] == 1.0 + share
    assert (run.monitor.violations > 0) == counted


def test_shares_read_as_percent():
    shares = (0.0, 0.00275, 0.5, 0.9996, 1.0, 1.5, 12.34)
    assert [percent(x) for x in shares] == [
        "0 %", "0.275 %", "50 %", "100 %", "100 %", "150 %", "1230 %",
    ]  # fmt: skip
