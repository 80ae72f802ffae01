"""Guarded runs: both engines, the switch, the monitor's verdict, and the price in speed."""

import pytest

from tests import oracle
from tests.equal_runs import runs_equal
from tests.tables import changes
from wmr_ctrl.api import simulate
from wmr_ctrl.control.laws.registry import NAMES
from wmr_ctrl.results import load_run
from wmr_ctrl.results.formats import save_run

SHORT = changes("""
    clock.duration = 6.0
    changes = [{t = 3.0, m = 65.0, I = 7.0, mu = 0.15}]
""")


def gap(first, second):
    return max(float(abs(first[s.name] - second[s.name]).max()) for s in first.signals)


@pytest.mark.parametrize("changed", [
    changes("""
        actuator.tau_max = 10.0
        guard.map = rotation-first
        guard.alpha = 20.0
    """),
    changes("""
        guard.f_min = [5.0, 1.0]
        guard.f_speed = [0.05, 0.05]
        guard.trust = true
    """),
    changes("actuator.lag = 0.02; actuator.delay = 0.013"),
    changes("initial.velocity = [1.3, 2.0]"),
])  # fmt: skip
@pytest.mark.slow_but("changed0", "changed2")
def test_every_option_means_what_the_oracle_takes_it_for(changed):
    """prox reads the torque that was applied, so it sees delay and lag."""
    native, slow = (
        run("safe-simulation", "prox", overrides={**SHORT, **changed})
        for run in (simulate, oracle.simulate)
    )

    assert gap(native, slow) < 1e-9
    assert native.monitor.violations == slow.monitor.violations


@pytest.mark.parametrize("law", NAMES)
@pytest.mark.slow_but("prox")
def test_switch(law):
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


def test_monitor_notices_a_disturbance_beyond_dbar(tmp_path):
    pushed = changes("""
        disturbance.push = [60.0, 15.0]
        robot.mu = 0.0
        model.mu = 0.08
    """)
    too_small = changes("""
        guard.dbar = [20.0, 5.0]
        guard.trust = true
        disturbance.std = 0.0
        clock.duration = 5.0
    """)
    run = simulate("safe-simulation", "prox", overrides={**pushed, **too_small, "changes": []})

    assert run.outcome == "bounds-left"
    assert run.monitor.bounds_left is not None
    assert "guard.dbar" in run.explanation
    assert 20.0 < run["d_least"].max() <= 60.0 * (1 + 1e-9)
    save_run(run, tmp_path / "run.npz")
    assert runs_equal(load_run(tmp_path / "run.npz"), run)
