"""The robot of a scenario as an MJCF text, and the numbers of it that a run may change.

Body frame: origin in the axle's midpoint, x to the right wheel, y forward, z up, so that theta is
the rotation about z.  Contacts are named pairs, since MuJoCo would else take the larger friction
of two shapes; casters have none.  Coulomb friction of the scenario is that of the wheels' bearings,
mu m g r/2 each: it holds the robot like the plane model's at low speed, but brakes rotation too.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from wmr_ctrl.errors import ScenarioError
from wmr_ctrl.scenario import Scenario
from wmr_ctrl.scenario.sections import Body
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
    """The parts' loads, from the robot's mass, inertia and friction.

    ``mass`` of the chassis [kg]; ``lift``: its centre of mass above the axle [m]; ``inertia`` of
    the chassis about it (pitch, roll, yaw) [kg m2]; ``drag`` of each wheel's bearing [N m].
    """

    mass: float
    lift: float
    inertia: tuple[float, float, float]
    drag: float


def loads(scenario: Scenario, m: float, inertia: float, mu: float) -> Loads:
    """The parts of a robot of mass m [kg], inertia [kg m2] and friction mu in all.

    Raises ScenarioError where the wheels alone have more.
    """
    robot, body = scenario.robot, scenario.body
    _, across = wheel_inertia(scenario)
    chassis = m - 2 * body.wheel_mass
    yaw = inertia - 2 * (body.wheel_mass * robot.l**2 + across)
    if chassis <= 0 or yaw <= 0:
        raise ScenarioError(
            f"body.wheel_mass = {body.wheel_mass:g} kg at robot.l = {robot.l:g} m leaves "
            f"{chassis:.3g} kg and {yaw:.3g} kg m2 to the chassis of a robot of {m:g} kg and "
            f"{inertia:g} kg m2. State lighter wheels."
        )
    lift = (m * body.height - 2 * body.wheel_mass * robot.r) / chassis - robot.r
    flat = body.flatness * yaw
    return Loads(chassis, lift, (flat, flat, yaw), mu * m * robot.g * robot.r / 2)


def wheel_inertia(scenario: Scenario) -> tuple[float, float]:
    """Inertia of a wheel about its axle, and about a diameter [kg m2]: a disc's."""
    share = scenario.body.wheel_mass * scenario.robot.r**2 / 4
    return 2 * share, share


def gravity(scenario: Scenario) -> tuple[float, float, float]:
    """Gravity [m/s2] in the ground's frame: the ground is level there, and gravity inclined."""
    g, slope, uphill = scenario.robot.g, scenario.body.slope, scenario.body.uphill
    along = -g * math.sin(slope)
    return -along * math.sin(uphill), along * math.cos(uphill), -g * math.cos(slope)


def description(scenario: Scenario) -> str:
    """The robot on its ground as MJCF, at rest over the origin and looking along +Y.

    Raises ScenarioError for numbers that no rigid body has, a step that is too long for one, or the
    plane model's slope, which would pull on level ground.
    """
    robot, body, steep = scenario.robot, scenario.body, scenario.section(Slope).angle
    if steep:
        raise ScenarioError(
            f"slope.angle = {steep:g} rad is a pull on the plane model; under the rigid body the "
            "ground itself is inclined. State body.slope instead, and body.uphill, which is "
            "slope.direction - pi/2, and leave slope.angle at 0."
        )
    if scenario.clock.plant > _STEP_MAX:
        raise ScenarioError(
            f"clock.plant = {scenario.clock.plant:g} s is too long for tyres on the ground; "
            f"MuJoCo takes at most {_STEP_MAX:g} s here, and 0.001 s is usual."
        )
    own = loads(scenario, robot.m, robot.I, robot.mu)
    wheels = "\n".join(
        _wheel(scenario, name, side, own.drag)
        for name, side in ((RIGHT, robot.l), (LEFT, -robot.l))
    )
    return f"""<mujoco model="wheeled robot">
  <compiler angle="radian" autolimits="true"/>
  <option timestep="{scenario.clock.plant!r}"
          integrator="implicitfast" cone="elliptic" impratio="10"
          gravity="{" ".join(map(repr, gravity(scenario)))}"><flag autoreset="disable"/></option>
  <default><geom contype="0" conaffinity="0" mass="0"/></default>
{_SCENERY}
  <worldbody>
    <light pos="0 0 6" dir="0 0 -1" directional="true"/>
    <geom name="{GROUND}" type="plane" size="0 0 1" material="grid"/>
    <body name="{CHASSIS}" pos="0 0 {robot.r}">
      <freejoint/>
      <inertial pos="0 0 {own.lift!r}" mass="{own.mass!r}"
                diaginertia="{" ".join(map(repr, own.inertia))}"/>
{_hull(scenario)}
{wheels}
    </body>
  </worldbody>
  <contact>
{_contacts(body)}
  </contact>
  <actuator>
    <motor name="{RIGHT}" joint="{RIGHT}"/>
    <motor name="{LEFT}" joint="{LEFT}"/>
  </actuator>
</mujoco>
"""


_SCENERY = """  <visual>
    <global offwidth="1280" offheight="960"/>
    <quality offsamples="0" shadowsize="1024"/>
  </visual>
  <asset>
    <texture name="grid" type="2d" builtin="checker" width="256" height="256"
             rgb1=".92 .93 .95" rgb2=".84 .86 .89"/>
    <texture name="sky" type="skybox" builtin="gradient" width="64" height="64"
             rgb1=".62 .74 .86" rgb2=".95 .96 .97"/>
    <material name="grid" texture="grid" texrepeat="1 1" texuniform="true"/>
  </asset>"""


def _hull(scenario: Scenario) -> str:
    """Geoms of the chassis and casters."""
    body, half = scenario.body, 0.75 * scenario.robot.l
    rise = CASTER_RADIUS - scenario.robot.r + body.caster_gap
    casters = "\n".join(
        f'      <geom name="{name}" size="{CASTER_RADIUS}" pos="0 {side * body.caster} {rise}"/>'
        for name, side in zip(CASTERS, (1, -1), strict=True)
    )
    return f"""      <geom name="hull" type="box" size="{half} {body.caster} {_THICK}"
            pos="0 0 {_THICK}" rgba=".16 .38 .62 1"/>
      <geom name="nose" type="box" size=".03 .03 .02" pos="0 {body.caster} {2 * _THICK}"
            rgba=".85 .33 .10 1"/>
{casters}"""


def _contacts(body: Body) -> str:
    """Ground contacts and their friction."""
    friction = " ".join(map(str, (body.tyre, body.tyre, 0.0, 0.0, 0.0)))
    grip = f'condim="3" friction="{friction}" solreffriction="{body.grip!r} 1"'
    kinds = {
        **dict.fromkeys((RIGHT, LEFT), grip),
        **dict.fromkeys(CASTERS, 'condim="1"'),
        "hull": 'condim="3" friction="0.5 0.5 0 0 0"',
    }
    return "\n".join(
        f'    <pair geom1="{GROUND}" geom2="{name}" {contact}/>' for name, contact in kinds.items()
    )


def _wheel(scenario: Scenario, name: str, side: float, drag: float) -> str:
    """A wheel that turns about -x, so that forward is positive."""
    robot, body = scenario.robot, scenario.body
    spin, across = wheel_inertia(scenario)
    shape = f'type="sphere" size="{robot.r!r}"'
    if body.wheel == "cylinder":
        shape = f'type="cylinder" size="{robot.r!r} {body.wheel_width / 2!r}" zaxis="1 0 0"'
    return f"""      <body name="{name}" pos="{side} 0 0">
        <joint name="{name}" axis="-1 0 0" frictionloss="{drag!r}"/>
        <inertial pos="0 0 0" mass="{body.wheel_mass!r}"
                  diaginertia="{spin!r} {across!r} {across!r}"/>
        <geom name="{name}" {shape} rgba=".15 .15 .17 1"/>
      </body>"""
