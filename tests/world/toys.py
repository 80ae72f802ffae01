"""Toy effects and a toy reference, as another package would write them: one of every kind.

Each is a section, a graph, and the bound that the guard may rely on.  `docs/extending.md` shows
them.
"""

from __future__ import annotations

import math

import casadi as ca

from wmr_ctrl.core.fields.section import Section, quantity
from wmr_ctrl.core.signals import (
    BODY_FORCE,
    MEASURED_VELOCITY,
    PLANT_STATE,
    REFERENCE,
    TIME,
    TORQUE,
    TORQUE_NOISE,
    Signal,
)
from wmr_ctrl.world.effect import Bound, Effect, EffectRole, Rate
from wmr_ctrl.world.model.system import (
    NORMAL,
    UNIFORM,
    Output,
    Parameters,
    System,
    draw,
    outputs,
    port,
    ports,
    stack,
)
from wmr_ctrl.world.references.kind import Reference, ReferenceKind

OMEGA = MEASURED_VELOCITY[1]
THETA = PLANT_STATE[2]


# A sensor with state and draws: a gyro whose bias walks.


class ToyGyro(Section, key="toy_gyro"):
    """Rate at which the bias walks."""

    walk: float = quantity(0.0, unit="rad/s", doc="largest step of the bias in a sample", minimum=0)


def gyro(scenario):
    """Measured omega with a bias that moves by walk times a uniform number in each sample."""
    omega, p = port(OMEGA), Parameters(scenario)
    bias = port(Signal("toy_bias", "rad/s", "bias of the toy gyro"))
    step = draw(Signal("toy_gyro", "1", "uniform numbers", 2), UNIFORM, p.take("toy_gyro.walk") > 0)
    following = 0.99 * bias.sym + p.take("toy_gyro.walk") * step.port.sym[0]
    return System(
        "toy_gyro",
        "walking bias",
        inputs=(omega,),
        state=(bias,),
        params=p.ports,
        update=following,
        outputs=(Output(OMEGA, omega.sym + following),),
        diagnostics=(Output(Signal("toy_bias_now", "rad/s", "bias of this sample"), following),),
        draws=(step,),
    )


GYRO = Effect(
    "toy gyro",
    EffectRole.SENSOR,
    ToyGyro,
    gyro,
    lambda scenario: Bound(nbar=(0.0, 100.0 * scenario.section(ToyGyro).walk)),
)


# A drive with state: a torque that cannot jump.


class ToyRamp(Section, key="toy_ramp"):
    """Rate at which the torque may change."""

    rate: float = quantity(0.0, unit="N.m/s", doc="largest rate; 0: the torque jumps", minimum=0)


def ramp(scenario):
    """Torque that approaches the arriving one by at most rate h in a plant step."""
    torque, p = ports(TORQUE), Parameters(scenario)
    old = port(Signal("toy_torque", "N.m", "torque of the previous plant step", 2))
    most = p.take("toy_ramp.rate") * p.take("clock.plant")
    moved = ca.fmax(-most, ca.fmin(most, stack(item.sym for item in torque) - old.sym))
    following = old.sym + moved
    return System(
        "toy_ramp",
        "limited rate",
        inputs=torque,
        state=(old,),
        params=p.ports,
        update=following,
        outputs=outputs(TORQUE, following),
    )


RAMP = Effect("toy ramp", EffectRole.DRIVE, ToyRamp, ramp, rate=Rate.STEP)
"""A drive that states no bound."""


# A force on the body, in each plant step.


class ToySlope(Section, key="toy_slope"):
    """Slope of the ground."""

    angle: float = quantity(0.0, unit="rad", doc="rise of the ground along +X", minimum=0)


def slope(scenario):
    """Gravity along the heading, -m g sin(angle) times the cosine of the heading from uphill."""
    theta, p = port(THETA), Parameters(scenario)
    pull = p.take("robot.m") * p.take("robot.g") * ca.sin(p.take("toy_slope.angle"))
    return System(
        "toy_slope",
        "slope along X",
        inputs=(theta,),
        params=p.ports,
        outputs=(Output(BODY_FORCE[0], pull * ca.sin(theta.sym)),),
    )


def slope_bound(scenario):
    """Pull on the heaviest robot straight downhill."""
    heaviest = max((scenario.robot.m, *(c.m for c in scenario.changes if c.m)))
    pull = heaviest * scenario.robot.g * math.sin(scenario.section(ToySlope).angle)
    return Bound(dbar=(pull, 0.0))


SLOPE = Effect("toy slope", EffectRole.DISTURBANCE, ToySlope, slope, slope_bound, rate=Rate.STEP)


# A disturbance with state and draws of its own in each plant step: gusts.


class ToyGust(Section, key="toy_gust"):
    """Strength of the gusts."""

    torque: float = quantity(0.0, unit="N.m", doc="standard deviation of a step's kick", minimum=0)


def gust(scenario):
    """Filtered noise on both wheels, the difference of two pairs, drawn anew in each plant step."""
    p, state = Parameters(scenario), port(Signal("toy_gust", "N.m", "filtered noise", 2))
    kick = draw(Signal("toy_gust", "1", "numbers", 4), NORMAL, p.take("toy_gust.torque") > 0, 3.0)
    first, other = ca.vertsplit(kick.port.sym, 2)
    following = 0.9 * state.sym + p.take("toy_gust.torque") * (first - other)
    return System(
        "toy_gust",
        "gusts",
        state=(state,),
        params=p.ports,
        update=following,
        outputs=outputs(TORQUE_NOISE, following),
        draws=(kick,),
    )


GUST = Effect(
    "toy gust",
    EffectRole.DISTURBANCE,
    ToyGust,
    gust,
    lambda scenario: Bound(dbar=(1200.0 * scenario.section(ToyGust).torque,) * 2),
    rate=Rate.STEP,
)


# A reference with state: a clothoid, integrated.


class ToyClothoid(Reference):
    """A curve whose curvature grows with the path length."""

    speed: float = quantity(0.3, unit="m/s", doc="speed", above=0)
    growth: float = quantity(0.2, unit="1/m2", doc="growth of the curvature over the way")


def clothoid(scenario):
    """Position by Simpson's rule from sample to sample; orientation and rates in closed form."""
    time, p = port(TIME), Parameters(scenario)
    v, growth, T = p.take("ref_speed"), p.take("ref_growth"), p.take("clock.control")
    place = port(Signal("ref_place", "m", "desired position", 2))

    def angle(t):
        return growth * (v * t) ** 2 / 2

    def velocity(t):
        return v * ca.vertcat(-ca.sin(angle(t)), ca.cos(angle(t)))

    t = time.sym
    following = place.sym + T / 6 * (velocity(t) + 4 * velocity(t + T / 2) + velocity(t + T))
    path = ca.vertcat(place.sym, angle(t), v, growth * v * v * t, 0, growth * v * v)
    return System(
        "reference",
        "clothoid",
        inputs=(time,),
        state=(place,),
        params=p.ports,
        update=following,
        outputs=outputs(REFERENCE, path),
        period=scenario.clock.control,
    )


CLOTHOID = ReferenceKind("toy-clothoid", ToyClothoid, clothoid)
EFFECTS = (GYRO, RAMP, SLOPE, GUST)
