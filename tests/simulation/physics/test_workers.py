"""Many runs on the rigid body give one table, for any number of workers."""

import os
import sys

import pytest

import wmr_ctrl
from tests.simulation.campaign.studies import PLAN
from tests.simulation.physics.test_run import SHORT
from wmr_ctrl import simulate_many
from wmr_ctrl.core.errors import ArgumentError, MissingExtraError, ScenarioError, WmrError
from wmr_ctrl.simulation.physics.workers import make_each

BRIEF = SHORT | {"clock.duration": 0.5}


def test_an_error_of_a_run_is_raised():
    def refuse(loop, seed):
        raise ScenarioError("body.x: no.")

    with pytest.raises(ScenarioError, match=r"body\.x"):
        make_each(refuse, [(None, 0)], 1)
    with pytest.raises(ArgumentError, match="jobs"):
        make_each(refuse, [(None, 0)], 0)


@pytest.mark.slow
def test_overrides_and_starts_may_differ_by_run():
    starts = [[0.3, -0.2, 0.5, 0.1, 0.0], [0.0, 0.0, -1.0, 0.0, 0.2]]
    changed = [BRIEF | {"body.tyre": tyre} for tyre in (0.8, 0.02)]
    plant = {"plant": "mujoco", "jobs": 1}
    table = simulate_many("paper-simulation", "mb", [1, 1], changed, starts=starts, **plant)
    begun = changed[1] | {"initial.pose": starts[1][:3], "initial.velocity": starts[1][3:]}
    (alone,) = simulate_many("paper-simulation", "mb", [1], begun, **plant).records()

    assert table.records()[1]["position_rms"] == alone["position_rms"]
    assert table["slipped"][1] < 0.2
    assert table["slipped"][0] != table["slipped"][0]


def died(loop, seed):
    os._exit(3)


@pytest.mark.slow
def test_a_process_that_ends_is_reported():
    with pytest.raises(WmrError, match="ended before its result"):
        make_each(died, [(None, 0), (None, 1)], 2)


def test_without_the_package_nothing_is_begun(monkeypatch, tmp_path):
    monkeypatch.setitem(sys.modules, "mujoco", None)
    with pytest.raises(MissingExtraError, match=r"wmr_ctrl\[physics\]"):
        simulate_many("paper-simulation", "mb", [0], BRIEF, plant="mujoco")
    with pytest.raises(MissingExtraError, match=r"wmr_ctrl\[physics\]"):
        wmr_ctrl.study({**PLAN, "plant": "mujoco"}, tmp_path / "s")
    assert not (tmp_path / "s").exists()
