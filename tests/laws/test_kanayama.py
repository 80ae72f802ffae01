"""The plain peer: its kinematic law, its two limits, its observer, and how well it tracks."""

from __future__ import annotations

import numpy as np
import pytest

from wmr_ctrl.api import simulate
from wmr_ctrl.results import Run

LAW = "kanayama"
OWN = f"gains.{LAW}"


def run_at(period: float, law: str = LAW, **changed: object) -> Run:
    return simulate("safe-simulation", law, overrides={"clock.control": period, **changed})


def last_quarter_rms(run: Run) -> float:
    gap = np.hypot(run["x"] - run["x_d"], run["y"] - run["y_d"])
    return float(np.sqrt(np.mean(gap[3 * run.rows // 4 :] ** 2)))


@pytest.mark.parametrize(("period", "most"), [(0.01, 0.6e-3), (0.1, 6e-3)])
@pytest.mark.parametrize("guard", [False, True])
def test_it_tracks_the_circle_to_millimetres(period: float, most: float, guard: bool) -> None:
    run = run_at(period, **{"guard.enabled": guard})

    assert run.outcome == "completed"
    assert last_quarter_rms(run) < most


def test_the_command_is_cut_and_rises_no_faster_than_allowed() -> None:
    """From rest, far away: both velocities climb as slowly as a_max says, up to their share."""
    slow = {f"{OWN}.a_max": [0.1, 0.2], f"{OWN}.share": 0.5, "guard.enabled": False}
    still = {"initial.velocity": [0.0, 0.0], "initial.pose": [-5.0, -5.0, -0.7]}
    run = run_at(0.01, **slow, **still, **{"disturbance.std": 0.0, "clock.duration": 20.0})

    begun = run.time < 3.0
    assert (abs(run["v1"][begun]) <= 0.1 * run.time[begun] + 1e-3).all()
    assert run.monitor.max_abs_v[0] == pytest.approx(0.5, rel=0.02)
    assert run.monitor.max_abs_v[1] <= 0.75 * 1.02


def test_observer_finds_a_constant_force_and_removes_its_offset() -> None:
    pushed = {"disturbance.push": [20.0, 0.0], "disturbance.std": 0.0, "changes": []}
    guarded = {"guard.enabled": False, "clock.duration": 20.0}
    run = run_at(0.01, **pushed, **guarded)
    without = run_at(0.01, **pushed, **guarded, **{f"{OWN}.wo": 0.0})

    assert run["d_hat"][-1] == pytest.approx([20.0, 0.0], abs=0.05)
    assert last_quarter_rms(run) < 1e-4
    assert last_quarter_rms(without) > 1e-3
