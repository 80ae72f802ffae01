"""The monitor of unguarded runs reveals broken bounds and never accuses bounds that hold."""

from dataclasses import replace
from types import SimpleNamespace

import casadi as ca
import numpy as np
import pytest

from tests.equal_runs import runs_equal
from tests.tables import changes
from wmr_ctrl.api import simulate, simulate_many
from wmr_ctrl.control.guard.lateness import AT_ONCE, Since
from wmr_ctrl.control.guard.monitor import LateMotion, least_push
from wmr_ctrl.control.laws import LAWS
from wmr_ctrl.results import load_run
from wmr_ctrl.results.formats import save_run

every_law = pytest.mark.parametrize("law", tuple(LAWS))
OFF = changes("guard.enabled = false; clock.duration = 5.0; changes = []")
PUSHED = changes("""
    disturbance.push = [150.0, 40.0]
    disturbance.std = 0.0
    robot.mu = 0.0
    guard.dbar = [60.0, 15.0]
    guard.mass_margin = 0.0
    guard.trust = true
""")


@every_law
@pytest.mark.slow_but("mb", "nn")
def test_a_push_beyond_dbar_is_revealed_by_a_known_mass(law, tmp_path):
    """Without friction and with the mass known, d_least is the push itself."""
    run = simulate("paper-simulation-no-switch", law, overrides={**OFF, **PUSHED})
    found = run["d_least"].max(axis=0)

    assert not run.guard
    assert found[0] == pytest.approx(150.0, rel=1e-6)
    assert 15.0 < found[1] < 40.0 * (1 + 1e-6)
    assert run.monitor.d_least == tuple(found)
    assert run.settings.dbar == (60.0, 15.0)
    assert run.monitor.bounds_left is not None
    assert run.outcome != "bounds-left"
    save_run(run, tmp_path / "run.csv")
    assert runs_equal(load_run(tmp_path / "run.csv"), run)
    assert load_run(tmp_path / "run.csv").monitor == run.monitor


@every_law
@pytest.mark.slow_but("mb", "prox")
def test_the_same_push_costs_a_guarded_run_its_outcome(law):
    """The event is the same; the outcome is a warning only where there is a guarantee."""
    run = simulate("paper-simulation", law, guard=True, overrides={**OFF, **PUSHED})

    assert run.monitor.bounds_left is not None
    assert run.outcome in ("bounds-left", "limit-violated")


@pytest.mark.parametrize("law", ["pid", "mb", "prox"])
@pytest.mark.slow_but("pid", "mb")
def test_a_push_of_dbar_itself_contradicts_nothing_by_rounding(law):
    """d_least is the push to a few units in the last place; in some sample it is above."""
    push = [60.0, 15.0]
    changed = {**OFF, **PUSHED, "disturbance.push": push, "guard.dbar": push}
    run = simulate("paper-simulation-no-switch", law, overrides=changed)
    table = simulate_many("paper-simulation-no-switch", law, [0], [changed])

    assert (run["d_least"].max(axis=0) > push).any()
    assert run.monitor.bounds_left is None
    assert np.isnan(table["bounds_left"]).all()


@pytest.mark.parametrize(
    "old, v, force, least",
    [
        (0.5, 0.6, 0.0, 40.0 * (0.1 - 0.02) / 0.1),
        (0.5, 0.6, 10.0, 40.0 * (0.1 - 0.02) / 0.1 - 10.0),
        (0.5, 0.4, -80.0, 80.0 - 60.0 * (0.1 + 0.02) / 0.1),
        (-0.5, -0.6, 0.0, 40.0 * (0.1 - 0.02) / 0.1),
        (-0.05, 0.05, 0.0, 0.0),
    ],
)
def test_the_least_push_is_what_the_lightest_or_heaviest_robot_leaves_open(old, v, force, least):
    """Speeds are known to 0.01, so a change to 0.02; the lightest robot explains a rise best."""
    bounds = SimpleNamespace(nbar=0.01, period=0.1, M_min=40.0, M_max=60.0)

    assert float(ca.evalf(least_push(*map(ca.SX, (v, old, force)), bounds))) == pytest.approx(least)


def test_it_waits_until_all_that_acted_before_is_known_on_both_axes():
    late = [
        Since(mean=(), rest=(), mean_time=1.0, rest_time=1.0, older=replace(AT_ONCE, most=periods))
        for periods in (0.5, 2.5)
    ]

    assert LateMotion((late[0], late[1]), [], ca.SX(2, 1)).begins == 4
    assert LateMotion((late[0], None), [], ca.SX(2, 1)).begins == 2
