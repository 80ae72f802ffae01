"""actuator.traction: torques that tyres pass on, under which the guard's promise is one again."""

import pytest

from wmr_ctrl import simulate
from wmr_ctrl.control.setup import settle
from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.world.grip import grip
from wmr_ctrl.world.scenario import load_scenario

BOUNDED = {"disturbance.truncate": 3.0}
GRIPPING = {"actuator.traction": True, **BOUNDED}


@pytest.mark.parametrize("stated", [5.0, 1e9])
def test_the_smaller_of_both_limits_counts(stated):
    chosen = load_scenario("paper-simulation", {**GRIPPING, "actuator.tau_max": stated})
    setup = settle(chosen, "mb")
    assert setup.tau_max == min(stated, grip(chosen).keep)
    for engine in ("native", "numpy"):
        run = simulate(
            chosen, "mb", engine=engine, overrides={"clock.duration": 0.5, "changes": []}
        )
        peak = max(abs(run[name]).max() for name in ("tau_right", "tau_left"))
        assert peak == pytest.approx(setup.tau_max)


def test_where_no_torque_is_sure_of_its_grip_it_is_refused():
    with pytest.raises(ScenarioError, match=r"actuator\.traction"):
        simulate("paper-simulation", "mb", overrides={**GRIPPING, "body.tyre": 0.1})


def promise_is_one(scenario, law, seed, **overrides):
    chosen = {key.replace("__", "."): value for key, value in overrides.items()}
    run = simulate(
        scenario, law, seed=seed, guard=True, plant="mujoco", overrides={**GRIPPING, **chosen}
    )
    assert run.outcome == "completed"
    assert run.monitor.violations == 0
    assert run.monitor.bounds_left is None
    assert run.monitor.rigid.slipped is None


@pytest.mark.parametrize("law", ["mb", "pid"])
@pytest.mark.slow
def test_the_guard_s_promise_on_a_rigid_body(law):
    promise_is_one("far-start", law, 71, clock__duration=10.0)


def test_without_traction_there_is_none():
    """Wheels that spin take the robot where no bound of the guard admits it to go."""
    run = simulate("paper-simulation", "mb", guard=True, plant="mujoco", overrides=BOUNDED)
    assert run.monitor.rigid.slipped is not None
    assert run.monitor.bounds_left is not None
    assert run.monitor.violations > 0
