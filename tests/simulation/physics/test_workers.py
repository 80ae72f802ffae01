"""Many runs on the rigid body: one table, whoever makes it and however many at a time."""

import os
import sys

import numpy as np
import pytest

import wmr_ctrl
from tests.simulation.physics.test_run import SHORT
from wmr_ctrl import simulate, simulate_many
from wmr_ctrl.core.errors import (
    ArgumentError,
    MissingExtraError,
    ScenarioError,
    UnknownNameError,
    WmrError,
)
from wmr_ctrl.results import summary
from wmr_ctrl.simulation.campaign.study_plan import plan_of
from wmr_ctrl.simulation.physics.workers import make_each

BRIEF = SHORT | {"clock.duration": 0.5}
PLAN = {
    "scenario": "paper-simulation",
    "plant": "mujoco",
    "laws": ["mb"],
    "seeds": 2,
    "set": {"clock.duration": 0.5},
    "grid": {"actuator.tau_max": [10.0, 60.0]},
    "figures": ["violated", "position_rms", "slipped", "settling_time"],
}


@pytest.mark.slow
def test_a_table_has_the_figures_of_single_runs():
    table = simulate_many("paper-simulation", "mb", [3, 4], BRIEF, plant="mujoco", jobs=1)
    for k, seed in enumerate((3, 4)):
        run = simulate("paper-simulation", "mb", seed=seed, overrides=BRIEF, plant="mujoco")
        figures, seen = summary(run), run.monitor.rigid
        assert table["ise_total"][k] == figures["ise"]["total"]
        assert [table["max_abs_v1"][k], table["max_abs_v2"][k]] == figures["max_abs_v"]
        assert table["max_slip"][k] == seen.max_slip
        assert table["least_tip_margin"][k] == seen.least_tip_margin
        assert table["outcome"][k] == run.outcome
        assert max(abs(table[f"final_{name}"][k] - run[name][-1]) for name in "xy") < 0.02
    assert table["slipped"].shape == (2,)
    assert {"tipped", "max_wheel_speed", "max_tilt"} < set(table)


@pytest.mark.slow
def test_overrides_and_starts_may_differ_by_run():
    starts = [[0.3, -0.2, 0.5, 0.1, 0.0], [0.0, 0.0, -1.0, 0.0, 0.2]]
    changed = [BRIEF | {"body.tyre": tyre} for tyre in (0.8, 0.02)]
    table = simulate_many(
        "paper-simulation", "mb", [1, 1], changed, plant="mujoco", jobs=1, starts=starts
    )
    begun = BRIEF | {"initial.pose": starts[0][:3], "initial.velocity": starts[0][3:]}
    alone = simulate("paper-simulation", "mb", seed=1, plant="mujoco", overrides=begun)
    assert table["position_rms"][0] == summary(alone)["position_rms"]["all"]
    assert np.isnan(table["slipped"][0])
    assert table["slipped"][1] < 0.2


def test_what_a_run_raises_comes_through(monkeypatch):
    refused = ScenarioError("body.x: no.")

    def refuse(loop, seed):
        raise refused

    with pytest.raises(ScenarioError, match=r"body\.x"):
        make_each(refuse, [(None, 0)], 1)
    with pytest.raises(ArgumentError, match="jobs"):
        make_each(refuse, [(None, 0)], 0)


def died(loop, seed):
    os._exit(3)


@pytest.mark.slow
def test_a_process_that_ends_is_told():
    with pytest.raises(WmrError, match="ended before its result"):
        make_each(died, [(None, 0), (None, 1)], 2)


def test_plants_that_are_not_there_are_named():
    with pytest.raises(UnknownNameError, match="mujoco"):
        simulate_many("paper-simulation", "mb", [0], plant="bullet")
    with pytest.raises(ScenarioError, match="mujoco"):
        plan_of({**PLAN, "plant": "bullet"})
    with pytest.raises(UnknownNameError, match="slipped"):
        plan_of({**PLAN, "plant": "ode"})


def test_without_the_package_nothing_is_begun(monkeypatch, tmp_path):
    monkeypatch.setitem(sys.modules, "mujoco", None)
    with pytest.raises(MissingExtraError, match=r"wmr_ctrl\[physics\]"):
        simulate_many("paper-simulation", "mb", [0], BRIEF, plant="mujoco")
    with pytest.raises(MissingExtraError, match=r"wmr_ctrl\[physics\]"):
        wmr_ctrl.study(PLAN, tmp_path / "s")
    assert not (tmp_path / "s").exists()
