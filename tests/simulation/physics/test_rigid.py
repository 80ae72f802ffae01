"""The rigid body against mechanics in closed form."""

import math
from functools import partial

import mujoco
import numpy as np
import pytest

from tests.papers_robot import preset
from tests.tables import cases
from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.simulation.physics.rigid import RigidBody, description
from wmr_ctrl.world.scenario import Change

REST = "initial.pose = [0.0, 0.0, 0.0]; initial.velocity = [0.0, 0.0]"
scenario = partial(preset, "paper-simulation-nominal", REST)


def driven(body, right, left, steps, thrust=0.0, moment=0.0):
    for _ in range(steps):
        body.step((right, left, 0.0, 0.0, thrust, moment))
    return body


def rolling_mass(case):
    """Mass plus that of the rotating wheels: a disc's m r^2/2 over r^2, twice."""
    return case.robot.m + case.body.wheel_mass


@pytest.mark.parametrize("torque", [4.0, -8.0])
def test_acceleration_along_a_line(torque):
    case = scenario()
    robot, steps = case.robot, 200
    body = driven(RigidBody(case), torque, torque, steps)
    thrust = 2 * torque / robot.r - math.copysign(robot.mu * robot.m * robot.g, torque)
    expected = thrust / rolling_mass(case) * steps * case.clock.plant
    assert body.now.velocity[0] == pytest.approx(expected, rel=2e-2)
    assert body.now.velocity[1] == pytest.approx(0.0, abs=1e-9)
    assert body.now.path == pytest.approx(body.now.pose[1], rel=1e-2)


def test_acceleration_in_a_turn():
    case = scenario("robot.mu = 0.0")
    robot, steps = case.robot, 200
    body = driven(RigidBody(case), -2.0, 2.0, steps)
    inertia = robot.I + case.body.wheel_mass * robot.l**2
    moment = -4.0 * robot.l / robot.r
    assert body.now.velocity[1] == pytest.approx(
        moment / inertia * steps * case.clock.plant, rel=1e-2
    )
    assert body.now.pose[2] < 0


def test_a_line_of_contact_scrubs_where_a_point_does_not():
    point, line = (
        driven(RigidBody(scenario(f"robot.mu = 0.0; body.wheel = '{wheel}'")), 1.0, -1.0, 300)
        for wheel in ("sphere", "cylinder")
    )
    assert line.now.pose[2] < 0.8 * point.now.pose[2]


@pytest.mark.parametrize("tyre, torque", [(0.3, 15.0), (0.8, 35.0)])
def test_spinning_wheels_push_with_what_the_tyres_give(tyre, torque):
    """The torques' reaction shifts load from the wheels to the back caster; the thrust is mu N of
    the rest.
    """
    case, steps = scenario(f"body.tyre = {tyre}; body.caster = 2.0; body.grip = 0.1"), 300
    robot = case.robot
    net = 2 * (torque - robot.mu * robot.m * robot.g * robot.r / 2)
    lever = tyre * (case.body.height - robot.r) / case.body.caster
    thrust = tyre * (robot.m * robot.g - net / case.body.caster) / (1 + lever)
    body = driven(RigidBody(case), torque, torque, steps)
    assert min(body.now.slip) > 1.0
    gained = body.now.velocity[0] / (steps * case.clock.plant)
    assert gained == pytest.approx(thrust / robot.m, rel=0.1)


@pytest.mark.parametrize("slope, uphill", [(0.05, 0.0), (0.2, 1.0)])
def test_a_free_robot_rolls_downhill(slope, uphill):
    hill = f"body.slope = {slope}; body.uphill = {uphill}; initial.pose = [0.0, 0.0, {uphill}]"
    case = scenario("robot.mu = 0.0", hill)
    body = driven(RigidBody(case), 0.0, 0.0, 500)
    share = case.robot.m / rolling_mass(case)
    expected = -case.robot.g * math.sin(slope) * share * 0.5
    assert body.now.velocity[0] == pytest.approx(expected, rel=2e-2)
    assert body.now.velocity[1] == pytest.approx(0.0, abs=1e-6)


def test_push_acts_along_the_heading_and_about_the_vertical():
    case = scenario("robot.mu = 0.0; initial.pose = [0.0, 0.0, 2.0]")
    pushed = driven(RigidBody(case), 0.0, 0.0, 100, 50.0, 0.0)
    expected = 50.0 / rolling_mass(case) * 0.1
    assert pushed.now.velocity[0] == pytest.approx(expected, rel=1e-2)
    driven(pushed, 0.0, 0.0, 100)
    assert pushed.now.velocity[0] == pytest.approx(expected, rel=1e-2), "the push is over"
    turned = driven(RigidBody(case), 0.0, 0.0, 100, moment=5.0)
    inertia = case.robot.I + case.body.wheel_mass * case.robot.l**2
    assert turned.now.velocity[1] == pytest.approx(5.0 / inertia * 0.1, rel=2e-2)


def test_a_change_is_the_robot_of_the_new_numbers():
    body = RigidBody(scenario())
    body.change(Change(t=0.0, m=65.0, I=7.0, mu=0.15))
    heavy = RigidBody(scenario("robot.m = 65.0; robot.I = 7.0; robot.mu = 0.15"))
    for name in ("body_mass", "body_inertia", "body_ipos", "body_subtreemass",
                 "dof_frictionloss", "dof_invweight0", "body_invweight0"):  # fmt: skip
        changed, fresh = getattr(body.model, name), getattr(heavy.model, name)
        assert changed == pytest.approx(fresh, rel=1e-12, abs=1e-12), name


def test_parts_add_up_to_the_robot():
    case = scenario("robot.m = 65.0; robot.I = 7.0; body.height = 0.15")
    model = mujoco.MjModel.from_xml_string(description(case))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    assert sum(model.body_mass) == pytest.approx(65.0)
    assert data.subtree_com[1] == pytest.approx([0.0, 0.0, 0.15])
    spin, momentum = np.zeros(model.nv), np.zeros(model.nv)
    spin[5] = 1.0
    mujoco.mj_mulM(model, data, momentum, spin)
    assert momentum[5] == pytest.approx(7.0)


def test_load_centre_follows_the_acceleration():
    case = scenario()
    assert RigidBody(case).tip_margin == pytest.approx(1.0, abs=2e-3)
    body = driven(RigidBody(case), 8.0, 8.0, 300)
    ahead = (2 * 8.0 / case.robot.r - 39.24) / rolling_mass(case)
    moved = ahead / case.robot.g * case.body.height / case.body.caster
    assert 1.0 - body.tip_margin == pytest.approx(moved, rel=0.1)


@pytest.mark.parametrize(
    "told, key",
    cases("""
        body.wheel_mass = 30.0 | body.wheel_mass
        body.wheel_mass = 22.0; robot.I = 2.0 | body.wheel_mass
        slope.angle = 0.05 | body.slope
    """),
)
def test_an_impossible_body_is_refused(told, key):
    with pytest.raises(ScenarioError, match=key):
        RigidBody(scenario(told))
