"""Grip: torques at which wheels spin and lift, and torques limited to what tyres can transmit."""

import pytest

from tests.simulation.physics.test_rigid import scenario
from wmr_ctrl import simulate
from wmr_ctrl.control.setup import settle
from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.simulation.physics.rigid import RigidBody
from wmr_ctrl.theory.checks import first_torques, grip_warnings
from wmr_ctrl.world.grip import grip
from wmr_ctrl.world.scenario import load_scenario, override

ROBOTS = (
    "", "body.tyre = 0.4", "body.height = 0.3", "body.caster = 0.15",
    "body.tyre = 0.3; body.height = 0.25; body.caster = 0.2", "robot.m = 65.0; robot.mu = 0.15",
    "body.wheel_mass = 4.0",
)  # fmt: skip


def pulled(case, torque, steps):
    """Largest slip [m/s] and tilt [rad] of a robot in the first 50 ms after its start."""
    body, slip, tilt = RigidBody(case), 0.0, 0.0
    for k in range(steps):
        share = min(1.0, k / 50)
        body.step((share * torque, share * torque, 0.0, 0.0, 0.0, 0.0))
        slip, tilt = max(slip, *map(abs, body.now.slip)), max(tilt, body.now.tilt)
    return slip, tilt


@pytest.mark.parametrize("robot", ROBOTS)
def test_wheels_spin_beyond_the_torque_that_is_named_and_not_below(robot):
    case = scenario(robot)
    seen = grip(case)
    assert 0 < seen.keep < seen.brake < seen.spin < seen.lift
    assert pulled(case, 0.95 * seen.spin, 400)[0] < 0.02
    assert pulled(case, 1.05 * seen.spin, 400)[0] > 1.0


@pytest.mark.parametrize("robot", ["body.tyre = 0.1", "body.tyre = 0.05; body.caster = 0.15"])
def test_wheels_that_spin_lift_off_beyond_the_torque_that_is_named(robot):
    case = scenario("body.grip = 0.1", robot)
    named = grip(case).lift
    assert pulled(case, 0.9 * named, 500)[1] < 0.1
    assert pulled(case, 1.1 * named, 500)[1] > 0.2


@pytest.mark.parametrize("name, law", [("paper-simulation", "mb"), ("far-start", "prox")])
@pytest.mark.slow_but("paper-simulation-mb")
def test_at_the_torque_that_is_kept_no_wheel_slides(name, law):
    case = load_scenario(name, {"clock.duration": 6.0, "disturbance.std": 0.0})
    limited = override(case, {"actuator.tau_max": 0.99 * grip(case).keep})
    assert grip_warnings(settle(limited, law)) == ()
    run = simulate(limited, law, plant="mujoco")
    assert run.monitor.rigid.max_slip < 0.05
    assert run.monitor.rigid.tipped is None


def test_spin_and_fall_are_foretold():
    setup = settle(load_scenario("paper-simulation"), "mb")
    seen, first = grip(setup.scenario), max(map(abs, first_torques(setup)))
    run = simulate(setup.scenario, "mb", plant="mujoco")
    (told,) = grip_warnings(setup)
    assert told.key == "actuator.tau_max"
    assert f"{first:.3g} N m" in told.sentence
    assert first > seen.spin
    assert run.monitor.rigid.slipped is not None
    assert run.outcome == "tipped"


def test_first_torques_are_those_of_the_run():
    case = load_scenario("paper-simulation-noise-free", {"clock.duration": 0.02})
    for law in ("mb", "prox"):
        run = simulate(case, law)
        logged = run["tau_right"][0], run["tau_left"][0]
        assert first_torques(settle(case, law)) == pytest.approx(logged, rel=1e-9)


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


@pytest.mark.parametrize("law", ["mb", "pid"])
@pytest.mark.slow
def test_the_guard_s_promise_on_a_rigid_body(law):
    short = {**GRIPPING, "clock.duration": 10.0}
    run = simulate("far-start", law, seed=71, guard=True, plant="mujoco", overrides=short)
    assert run.outcome == "completed"
    assert run.monitor.violations == 0
    assert run.monitor.bounds_left is run.monitor.rigid.slipped is None


def test_without_traction_there_is_none():
    """With spinning wheels the robot moves in a way that no bound of the guard admits."""
    run = simulate("paper-simulation", "mb", guard=True, plant="mujoco", overrides=BOUNDED)
    assert run.monitor.rigid.slipped is not None
    assert run.monitor.bounds_left is not None
    assert run.monitor.violations > 0
