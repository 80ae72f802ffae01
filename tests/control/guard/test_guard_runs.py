"""Guarded runs: both engines, the switch, the monitor's verdict, and the price in speed."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests import oracle
from tests.equal_runs import runs_equal
from wmr_ctrl.api import simulate, simulate_runs
from wmr_ctrl.control.guard.price import usable_speed
from wmr_ctrl.control.laws.registry import NAMES
from wmr_ctrl.control.setup import settle
from wmr_ctrl.results import Run, load_run
from wmr_ctrl.results.formats import save_run
from wmr_ctrl.world.scenario import load_scenario

every_law = pytest.mark.parametrize("law", NAMES)
PAPERS = {"gains.kinematics.k": [10.0, 5.0, 4.0]}
SHORT = {"clock.duration": 6.0, "changes": [{"t": 3.0, "m": 65.0, "I": 7.0, "mu": 0.15}]}


def gap(first: Run, second: Run) -> float:
    return max(float(abs(first[s.name] - second[s.name]).max()) for s in first.signals)


@pytest.mark.parametrize("law", ["pid", "pursuit"])
@pytest.mark.slow
def test_native_equals_the_oracle(law: str) -> None:
    native, slow = (
        run("safe-simulation", law, seed=3, overrides={**PAPERS, **SHORT})
        for run in (simulate, oracle.simulate)
    )

    assert gap(native, slow) < 1e-9
    assert native.monitor.max_abs_v == pytest.approx(slow.monitor.max_abs_v, abs=1e-9)
    assert native.monitor.bounds_left is slow.monitor.bounds_left is None
    assert [s.name for s in native.signals] == [s.name for s in slow.signals]


@pytest.mark.parametrize("changed", [
    {"actuator.tau_max": 10.0, "guard.map": "rotation-first", "guard.alpha": 20.0},
    {"guard.f_min": [5.0, 1.0], "guard.f_speed": [0.05, 0.05], "guard.trust": True},
    {"actuator.lag": 0.02, "actuator.delay": 0.013},
    {"initial.velocity": [1.3, 2.0]},
])  # fmt: skip
@pytest.mark.slow_but("changed0")
def test_every_option_means_what_the_oracle_takes_it_for(changed: dict[str, object]) -> None:
    """prox reads the torque that was applied, so it sees delay and lag."""
    native, slow = (
        run("safe-simulation", "prox", overrides={**SHORT, **changed})
        for run in (simulate, oracle.simulate)
    )

    assert gap(native, slow) < 1e-9
    assert native.monitor.violations == slow.monitor.violations


@pytest.mark.parametrize(
    ("law", "scenario"),
    [("pid", "safe-simulation"), ("smc", "safe-experiment"), ("kanayama", "safe-experiment")],
)
@pytest.mark.slow_but("pid-safe-simulation")
def test_presets_of_ours_keep_the_limits(law: str, scenario: str) -> None:
    for run in simulate_runs(scenario, law, range(3)):
        assert run.outcome == "completed"
        assert run.guard


@every_law
@pytest.mark.slow_but("prox")
def test_switch(law: str) -> None:
    off, on, preset = (
        simulate("far-start", law, guard=guard, overrides={"clock.duration": 6.0})
        for guard in (False, True, None)
    )

    assert on.guard
    assert "guarded" in repr(on)
    assert on.monitor.violations == 0
    assert not off.guard
    assert not off["clip_active"].any()
    assert runs_equal(off, preset)


def test_monitor_notices_a_disturbance_beyond_dbar(tmp_path: Path) -> None:
    pushed = {"disturbance.push": [60.0, 15.0], "robot.mu": 0.0, "model.mu": 0.08}
    too_small = {
        "guard.dbar": [20.0, 5.0],
        "guard.trust": True,
        "disturbance.std": 0.0,
        "clock.duration": 5.0,
    }
    run = simulate("safe-simulation", "prox", overrides={**pushed, **too_small, "changes": []})

    assert run.outcome == "bounds-left"
    assert run.monitor.bounds_left is not None
    assert "guard.dbar" in run.explanation
    assert 20.0 < run["d_least"].max() <= 60.0 * (1 + 1e-9)
    save_run(run, tmp_path / "run.npz")
    assert runs_equal(load_run(tmp_path / "run.npz"), run)


def test_monitor_notices_a_mass_below_m_min() -> None:
    drop = [{"t": 1.0, "m": 5.0, "I": 0.5, "mu": 0.0}]
    stated = {"guard.M_min": [45.0, 4.8], "guard.M_max": [71.5, 7.7], "guard.dbar": [60.0, 15.0]}
    changed = {**stated, "guard.trust": True, "changes": drop, "clock.duration": 5.0}

    assert simulate("safe-simulation", "mb", overrides=changed).monitor.bounds_left


def test_clip_is_told_where_it_acts() -> None:
    run = simulate("safe-simulation", "pid", overrides=PAPERS)

    assert 0 < run["clip_active"].mean() < 0.1
    assert set(np.unique(run["clip_active"])) == {0.0, 1.0}
    assert (run["feasible"] == 1).all()


def test_usable_speed_tells_how_fast_the_robot_gets() -> None:
    """On a straight line that asks for more, at 100 ms with wide bounds: v_use is the speed."""
    wide = {"guard.M_min": [25.0, 2.7], "guard.dbar": [60.0, 15.0], "clock.control": 0.1}
    still = {"disturbance.std": 0.0, "robot.mu": 0.15, "actuator.tau_max": 40.0}
    changed = {**wide, **still, "guard.enabled": True, "clock.duration": 40.0}
    friction = (0.15 * 50 * 9.81, 0.0)
    scenario = load_scenario("fast-reference", changed)
    expected = usable_speed(scenario, settle(scenario, "pid").guard, friction)[0]
    run = simulate("fast-reference", "pid", overrides=changed)

    assert expected == pytest.approx(1 - (73.575 + 60) / 250, abs=1e-9)
    assert run["v1"][-1] == pytest.approx(expected, rel=1e-3)
    assert run["v1"][-1] < 0.9
