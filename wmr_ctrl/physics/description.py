"""The robot of a scenario as an MJCF text, and the numbers of it that a run may change.

Body frame: origin in the axle's midpoint, x to the right wheel, y forward, z up, so that theta is
the rotation about z.  Contacts are named pairs, since MuJoCo would else take the larger friction
of two shapes; casters have none.  Coulomb friction of the scenario is that of the wheels' bearings,
mu m g r/2 each: it holds the robot like the plane model's at low speed, but brakes rotation too.
A wheel turns about -x, so that forward is positive.
"""

import math
from dataclasses import dataclass
from pathlib import Path

import jinja2

from wmr_ctrl.errors import ScenarioError
from wmr_ctrl.scenario import Scenario
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
            'slope.direction - pi/2 (slope.direction itself with frames = "rep103"), and leave '
            "slope.angle at 0."
        )
    if scenario.clock.plant > _STEP_MAX:
        raise ScenarioError(
            f"clock.plant = {scenario.clock.plant:g} s is too long for tyres on the ground; "
            f"MuJoCo takes at most {_STEP_MAX:g} s here, and 0.001 s is usual."
        )
    spin, across = wheel_inertia(scenario)
    text = Path(__file__).with_name("robot.xml.j2").read_text(encoding="utf-8")
    template = jinja2.Template(
        text, trim_blocks=True, keep_trailing_newline=True, undefined=jinja2.StrictUndefined
    )
    return template.render(
        robot=robot, body=body, own=loads(scenario, robot.m, robot.I, robot.mu),
        step=scenario.clock.plant, gravity=gravity(scenario), ground=GROUND, chassis=CHASSIS,
        thick=_THICK, casters=dict(zip(CASTERS, (body.caster, -body.caster), strict=True)),
        caster_radius=CASTER_RADIUS, rise=CASTER_RADIUS - robot.r + body.caster_gap,
        wheels={RIGHT: robot.l, LEFT: -robot.l}, spin=spin, across=across,
    )  # fmt: skip
