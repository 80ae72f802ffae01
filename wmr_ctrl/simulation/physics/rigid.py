"""The rigid body as a plant: its MJCF text, and the plane plant's state from it, step by step.

It takes torques and forces.  ``description`` is a scenario's robot as a text, with the numbers that
a run may change.

Body frame: origin in the axle's midpoint, x to the right wheel, y forward, z up, so that theta is
the rotation about z. Contacts are named pairs, since MuJoCo would otherwise use the larger friction
of two shapes; casters have none. Coulomb friction of the scenario is that of the wheels' bearings,
mu m g r/2 each: it acts like the plane model's at low speed, but also brakes rotation. A wheel
turns about -x, so that forward is positive.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from importlib import import_module
from pathlib import Path
from types import ModuleType

import numpy as np

from wmr_ctrl.core.errors import ArgumentError, MissingExtraError, ScenarioError, install
from wmr_ctrl.world.scenario import (
    Change,
    MissingKeysError,
    Robot,
    Scenario,
    missing_text,
    sections,
    unknown_keys,
)
from wmr_ctrl.world.slope import Slope

CHASSIS, RIGHT, LEFT = "chassis", "right", "left"
GROUND = "ground"
CASTERS = ("front", "back")
CASTER_RADIUS = 0.04
_THICK = 0.06
"""Half the height of the drawn chassis [m]."""
_STEP_MAX = 0.005


@dataclass(frozen=True)
class Loads:
    """Mass distribution and bearing friction, from the robot's mass, inertia and friction.

    ``mass`` of the chassis [kg]; ``lift``: its centre of mass above the axle [m]; ``inertia`` of
    the chassis about it (pitch, roll, yaw) [kg m2]; ``drag`` of each wheel's bearing [N m].
    """

    mass: float
    lift: float
    inertia: tuple[float, float, float]
    drag: float


def loads(scenario: Scenario, robot: Robot) -> Loads:
    """The mass distribution of a robot; raises ScenarioError if the wheels alone outweigh it."""
    m, body = robot.m, scenario.body
    _, across = wheel_inertia(scenario)
    chassis = m - 2 * body.wheel_mass
    yaw = robot.I - 2 * (body.wheel_mass * robot.l**2 + across)
    if chassis <= 0 or yaw <= 0:
        raise ScenarioError(
            f"body.wheel_mass = {body.wheel_mass:g} kg at robot.l = {robot.l:g} m leaves "
            f"{chassis:.3g} kg and {yaw:.3g} kg m2 to the chassis of a robot of {m:g} kg and "
            f"{robot.I:g} kg m2. State lighter wheels."
        )
    lift = (m * body.height - 2 * body.wheel_mass * robot.r) / chassis - robot.r
    flat = body.flatness * yaw
    return Loads(chassis, lift, (flat, flat, yaw), robot.mu * m * robot.g * robot.r / 2)


def wheel_inertia(scenario: Scenario) -> tuple[float, float]:
    """Inertia of a wheel about its axle, and about a diameter [kg m2]: a disc's."""
    share = scenario.body.wheel_mass * scenario.robot.r**2 / 4
    return 2 * share, share


def gravity(scenario: Scenario) -> tuple[float, float, float]:
    """Gravity [m/s2] in the ground's frame, in which the ground is level and gravity inclined."""
    g, slope, uphill = scenario.robot.g, scenario.body.slope, scenario.body.uphill
    along = -g * math.sin(slope)
    return -along * math.sin(uphill), along * math.cos(uphill), -g * math.cos(slope)


def description(scenario: Scenario) -> str:
    """The robot on its ground as MJCF, at rest over the origin and looking along +Y.

    Raises ScenarioError for numbers that are impossible for a rigid body or unstated, a step that
    is too long for one, or the plane model's slope, which would pull on level ground.
    """
    if unknown := unknown_keys(scenario):
        raise MissingKeysError(f"the rigid body: {missing_text(unknown, sections())}")
    robot, body, steep = scenario.robot, scenario.body, scenario.section(Slope).angle
    if steep:
        raise ScenarioError(
            f"slope.angle = {steep:g} rad is a pull on the plane model; under the rigid body the "
            "ground itself is inclined. State body.slope instead, and body.uphill, which is "
            'slope.direction - pi/2 (slope.direction itself with frames = "rep103"), and leave '
            "slope.angle at 0."
        )
    if scenario.clock.plant > _STEP_MAX:
        raise ScenarioError(
            f"clock.plant = {scenario.clock.plant:g} s is too long for tyres on the ground; "
            f"MuJoCo takes at most {_STEP_MAX:g} s here, and 0.001 s is usual."
        )
    import jinja2  # slow to import, and runs in the plane need none

    spin, across = wheel_inertia(scenario)
    text = Path(__file__).with_name("robot.xml.j2").read_text(encoding="utf-8")
    template = jinja2.Template(
        text, trim_blocks=True, keep_trailing_newline=True, undefined=jinja2.StrictUndefined
    )
    return template.render(
        robot=robot, body=body, own=loads(scenario, robot),
        step=scenario.clock.plant, gravity=gravity(scenario), ground=GROUND, chassis=CHASSIS,
        thick=_THICK, casters=dict(zip(CASTERS, (body.caster, -body.caster), strict=True)),
        caster_radius=CASTER_RADIUS, rise=CASTER_RADIUS - robot.r + body.caster_gap,
        wheels={RIGHT: robot.l, LEFT: -robot.l}, spin=spin, across=across,
    )  # fmt: skip


_SETTLING = 0.5
"""Time [s] that the robot is given to sink into its tyres before a run."""


def mujoco() -> ModuleType:
    """The package `mujoco`; MissingExtraError without it, ArgumentError if it cannot be loaded."""
    try:
        return import_module("mujoco")
    except RuntimeError as error:
        raise ArgumentError(f"MuJoCo does not load: {error}. Correct or clear MUJOCO_GL.") from None
    except ImportError as error:
        raise MissingExtraError(
            'the plant "mujoco" needs the package mujoco-core, which is not installed: '
            f"{install('physics')}."
        ) from error


@dataclass(frozen=True)
class BodyMotion:
    """Motion of a rigid body at one instant.

    ``pose`` x, y [m] of the axle's midpoint, theta [rad], continuous; ``velocity`` v1 [m/s] along
    the heading, omega [rad/s]; ``path`` [m], the mean distance that both wheels rolled, and
    ``turned`` [rad], theta computed from their rolling, for any motion of the body; ``wheels``:
    speed (right, left) [rad/s]; ``slip`` (2,): tread over ground [m/s], forward on a wheel that
    spins; ``tilt`` [rad] between the robot's axis and the ground's normal.
    """

    pose: tuple[float, float, float]
    velocity: tuple[float, float]
    path: float
    turned: float
    wheels: tuple[float, float]
    slip: tuple[float, float]
    tilt: float

    @property
    def plane_state(self) -> tuple[float, ...]:
        """State of the plane plant, then further outputs for wheel sensors: PATH and SKID."""
        return *self.pose, *self.velocity, self.path, self.turned - self.pose[2]


class RigidBody:
    """A scenario's robot on its tyres, at the scenario's start; ``now``: its motion.

    Two bodies with the same inputs move alike, to the bit, on one machine.
    """

    def __init__(self, scenario: Scenario) -> None:
        """Place the body, sunk into its tyres, with the scenario's initial motion.

        Raises MissingExtraError, or ScenarioError as `description` does.
        """
        self._mujoco, self.scenario = mujoco(), scenario
        self.model = self._mujoco.MjModel.from_xml_string(description(scenario))
        self.data = self._mujoco.MjData(self.model)
        self._robot, self._step = scenario.robot, scenario.clock.plant
        self._geoms = {self._id("GEOM", name): name for name in (RIGHT, LEFT, *CASTERS)}
        self._ground = self._id("GEOM", GROUND)
        self._chassis = self._id("BODY", CHASSIS)
        self._push = self.data.xfrc_applied[self._chassis]
        self._pushed = False
        self._settle()
        self._place()
        self.now = self._read(scenario.initial.pose[2])

    def _id(self, kind: str, name: str) -> int:
        kinds = self._mujoco.mjtObj
        number: int = self._mujoco.mj_name2id(self.model, getattr(kinds, f"mjOBJ_{kind}"), name)
        return number

    def _settle(self) -> None:
        """Let the body sink under the gravity component that presses it to the ground."""
        self.model.opt.gravity[:] = (0.0, 0.0, gravity(self.scenario)[2])
        for _ in range(round(_SETTLING / self._step)):
            self._mujoco.mj_step(self.model, self.data)
        self.model.opt.gravity[:] = gravity(self.scenario)
        self.data.time = 0.0

    def _place(self) -> None:
        """Set the scenario's initial pose and velocity, with rolling wheels."""
        (x, y, theta), (v1, omega) = self.scenario.initial.pose, self.scenario.initial.velocity
        turned, stands = np.zeros(4), self.data.qpos[3:7].copy()
        yaw = np.array([math.cos(theta / 2), 0.0, 0.0, math.sin(theta / 2)])
        self._mujoco.mju_mulQuat(turned, yaw, stands)
        self.data.qpos[:2], self.data.qpos[3:7] = (x, y), turned
        r, half_track = self._robot.r, self._robot.l
        along = (-math.sin(theta) * v1, math.cos(theta) * v1, 0.0)
        rolling = (v1 + half_track * omega) / r, (v1 - half_track * omega) / r
        self.data.qvel[:] = (*along, 0.0, 0.0, omega, *rolling)
        self.data.qpos[7:9] = 0.0
        self._mujoco.mj_forward(self.model, self.data)

    def _read(self, before: float) -> BodyMotion:
        """The motion in MuJoCo; theta is continued from its value ``before``."""
        x, y, _, w, qx, qy, qz, *rolled = self.data.qpos.tolist()
        vx, vy, _, *spin, right, left = self.data.qvel.tolist()
        ahead = 2 * (qx * qy - w * qz), 1 - 2 * (qx * qx + qz * qz)
        up = 2 * (qx * qz - w * qy), 2 * (qy * qz + w * qx), 1 - 2 * (qx * qx + qy * qy)
        facing = math.atan2(-ahead[0], ahead[1])
        theta = before + math.remainder(facing - before, 2 * math.pi)
        v1 = math.cos(theta) * vy - math.sin(theta) * vx
        omega = up[0] * spin[0] + up[1] * spin[1] + up[2] * spin[2]
        r, half_track = self._robot.r, self._robot.l
        turning = half_track * omega
        return BodyMotion(
            pose=(x, y, theta),
            velocity=(v1, omega),
            path=r * sum(rolled) / 2,
            turned=self.scenario.initial.pose[2] + r * (rolled[0] - rolled[1]) / (2 * half_track),
            wheels=(right, left),
            slip=(r * right - v1 - turning, r * left - v1 + turning),
            tilt=math.acos(max(-1.0, min(1.0, up[2]))),
        )

    def step(self, acting: Sequence[float]) -> None:
        """One plant step under wheel torques, disturbing torques (2 each), thrust and moment.

        In the order of `signals.TORQUE`, `TORQUE_NOISE`, `BODY_FORCE`; the force acts at the
        chassis' centre of mass, along the heading.
        """
        right, left, noise_right, noise_left, thrust, moment = acting
        theta = self.now.pose[2]
        self.data.ctrl[:] = (right + noise_right, left + noise_left)
        if thrust or moment or self._pushed:
            s, c = math.sin(theta), math.cos(theta)
            self._push[:] = (-s * thrust, c * thrust, 0.0, 0.0, 0.0, moment)
            self._pushed = bool(thrust or moment)
        self._mujoco.mj_step(self.model, self.data)
        self.now = self._read(theta)

    def change(self, change: Change) -> None:
        """Set new mass, inertia and friction; numbers that the change omits stay."""
        self._robot = robot = replace(self._robot, **change.values())
        own = loads(self.scenario, robot)
        self.model.body_mass[self._chassis] = own.mass
        self.model.body_inertia[self._chassis] = own.inertia
        self.model.body_ipos[self._chassis] = (0.0, 0.0, own.lift)
        self.model.dof_frictionloss[6:8] = own.drag
        self._mujoco.mj_setConst(self.model, self._mujoco.MjData(self.model))

    @property
    def tip_margin(self) -> float:
        """Distance of the load's centre from the support's edge: 1 for the axle's midpoint.

        1 - |p_x|/l - |p_y|/caster for the centre of pressure p of the last step; 0 if the robot
        rests on one edge of the rhombus of wheels and casters, or has no contact.
        """
        load, force = dict.fromkeys(self._geoms.values(), 0.0), np.zeros(6)
        for i, (one, other) in enumerate(self.data.contact.geom.tolist()):
            name = self._geoms.get(other if one == self._ground else one)
            if name is not None:
                self._mujoco.mj_contactForce(self.model, self.data, i, force)
                load[name] += float(force[0])
        total = sum(load.values())
        if not total > 0:
            return 0.0
        front, back = (load[name] for name in CASTERS)
        return 1.0 - (abs(load[RIGHT] - load[LEFT]) + abs(front - back)) / total
