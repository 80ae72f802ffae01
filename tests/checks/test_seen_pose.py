"""Late and filtered poses in the linear loop: what it says is what runs do."""

from __future__ import annotations

import numpy as np
import pytest

from wmr_ctrl.api import simulate
from wmr_ctrl.checks import stability
from wmr_ctrl.checks.lateness import lost_poses, rare_poses
from wmr_ctrl.checks.loop import Loop
from wmr_ctrl.checks.sample_time import closed_loop
from wmr_ctrl.control.setup import settle
from wmr_ctrl.linear.report import report_linear
from wmr_ctrl.model.tracking import error_rotation
from wmr_ctrl.results import Run
from wmr_ctrl.scenario import Scenario, load_scenario
from wmr_ctrl.world.references import sample

AWAY = np.array([1.0, -0.5, 0.7, 0.3, -0.2])
"""A displacement of the pose, in the frame of the reference, and of the velocity."""
SMALL = 1e-6
SAMPLES = 80


def on_a_line(age: float, correction: float, every: int = 1) -> Scenario:
    """Straight ahead without friction, the believed robot, on the reference."""
    changes = {
        "sensor.pose_delay": age, "sensor.correction": correction, "reference.kind": "line",
        "sensor.pose_period": 0.01 * every,
        "robot.mu": 0.0, "model.mu": 0.0, "clock.duration": SAMPLES * 0.01,
    }  # fmt: skip
    return load_scenario("paper-simulation-nominal", changes)


def started(scenario: Scenario, away: np.ndarray) -> np.ndarray:
    """Error and velocity (N, 5) of the run of mb that starts so far from the reference."""
    at = sample(scenario, np.array([0.0]))[0]
    level = np.asarray(error_rotation(at[2]).T @ error_rotation(0.0)) @ away[:3]
    start = {
        "initial.pose": (at[:3] + level).tolist(), "initial.velocity": (at[3:5] + away[3:]).tolist()
    }  # fmt: skip
    run: Run = simulate(scenario, "mb", overrides=start)
    return np.column_stack((run["e"], run["v1"], run["omega"]))


@pytest.mark.parametrize(
    ("age", "correction", "every"),
    [(0.0, 1.0, 1), (0.05, 1.0, 1), (0.0, 0.3, 1), (0.1, 0.5, 1), (0.0, 1.0, 7), (0.1, 0.4, 5)],
)
def test_a_small_displacement_goes_the_way_of_the_matrices(
    age: float, correction: float, every: int
) -> None:
    """The rest is where the robot settles: it is behind by what it drives while a pose is old."""
    scenario = on_a_line(age, correction, every)
    seen = (started(scenario, SMALL * AWAY) - started(scenario, 0 * AWAY)) / SMALL
    loop, v_d = Loop(settle(scenario, "mb")), sample(scenario, np.array([0.0]))[0][3:5]
    matrices = [closed_loop(loop, v_d, 0.01, comes=comes) for comes in (False, True)]
    poses = len(matrices[0]) - 5
    x = np.concatenate((seen[0], np.tile(AWAY[:3], poses // 3)))

    assert loop.lateness.samples_a_pose(0.01) == every
    assert poses == (0 if (age, correction, every) == (0.0, 1.0, 1) else 3 + 3 * round(age / 0.01))
    for k, row in enumerate(seen):
        assert x[:5] == pytest.approx(row, abs=0.2 * age + 1e-3)
        x = matrices[k % every == 0] @ x


@pytest.mark.parametrize(("law", "below", "above"), [("prox", 0.1, 0.2), ("mb", 0.2, 0.4)])
def test_runs_cycle_where_a_pose_is_said_to_be_too_old(
    law: str, below: float, above: float
) -> None:
    for age, stable in ((below, True), (above, False)):
        scenario = load_scenario("paper-simulation-nominal", {"sensor.pose_delay": age})
        remarks = [item.key for item in simulate(scenario, law).remarks]

        assert (stability(scenario, law).period > 0.01) is stable
        assert ("oscillates" not in remarks) is stable


@pytest.mark.slow
def test_the_linear_report_has_the_same_limit() -> None:
    for age, every, stable in ((0.1, 0.0, True), (0.2, 0.2, False), (0.2, 0.5, True)):
        late = {"sensor.pose_delay": age, "sensor.pose_period": every}
        scenario = load_scenario("paper-simulation-nominal", late)
        page = report_linear(scenario, "prox")

        assert page.late
        assert page.stable is stable
        assert (page.max_sample_time > 0.01) is stable
        assert (page.spectral_radius < 1) is stable


@pytest.mark.parametrize("every", [0.2, 0.5])
def test_rare_poses_that_are_late_are_less_harmful_than_frequent_ones(every: float) -> None:
    """Dead reckoning needs no pose to be stable; a late one corrects what has passed since."""
    late = {"sensor.pose_delay": 0.2, "sensor.pose_period": every}
    scenario = load_scenario("paper-simulation-nominal", late)
    remarks = [item.key for item in simulate(scenario, "prox").remarks]

    assert (stability(scenario, "prox").period > 0.01) is (every > 0.3)
    assert ("oscillates" not in remarks) is (every > 0.3)


def test_what_is_left_out_is_said() -> None:
    rare = {"sensor.pose_period": 0.1, "sensor.pose_dropout": 0.3}

    assert rare_poses(load_scenario("paper-simulation")) == ""
    assert lost_poses(load_scenario("paper-simulation")) == ""
    assert lost_poses(load_scenario("paper-simulation", rare)) == (
        "as if all poses came, though 30% of them do not"
    )
    assert rare_poses(load_scenario("paper-simulation", rare)) == (
        "as if a pose came at every sample, though a pose comes every 0.1 s and 30% of them do "
        "not come"
    )
