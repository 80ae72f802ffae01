"""The robot as a rigid body on tyres: what the plane model of `Robot` has no word for."""

from __future__ import annotations

import math

from wmr_ctrl.fields.section import Section, quantity

WHEELS = ("sphere", "cylinder")


class Body(Section, key="body"):
    """What a rigid body needs beside mass, inertia, friction, wheels and track of [robot].

    The plane model does not read it.  Casters slide without friction.
    """

    tyre: float = quantity(0.8, unit="1", doc="friction between tyre and ground", above=0)
    grip: float = quantity(
        0.02, unit="s", doc="time in which a tread that slides is stopped", minimum=0.005
    )
    height: float = quantity(0.12, unit="m", doc="centre of mass above the ground", above=0)
    caster: float = quantity(0.3, unit="m", doc="axle to the casters in front and behind", above=0)
    caster_gap: float = quantity(5e-4, unit="m", doc="casters above the ground", minimum=0)
    flatness: float = quantity(
        0.55, unit="1", doc="inertia in pitch and in roll over that in yaw", minimum=0.5
    )
    wheel: str = quantity(
        "sphere", unit="1", doc="tyre: touches in a point, or in a line that scrubs", options=WHEELS
    )
    wheel_width: float = quantity(0.04, unit="m", doc="width of a cylinder's tread", above=0)
    wheel_mass: float = quantity(1.5, unit="kg", doc="mass of each wheel, part of robot.m", above=0)
    slope: float = quantity(
        0.0,
        unit="rad",
        doc="rise of the ground; the plane model has slope.angle",
        minimum=0,
        maximum=math.pi / 4,
    )
    uphill: float = quantity(0.0, unit="rad", doc="orientation theta that looks uphill")
    slip_max: float = quantity(
        0.1, unit="m/s", doc="tread over ground; beyond, the robot has slipped", above=0
    )
    tilt_max: float = quantity(
        0.5, unit="rad", doc="axis from the ground's normal; beyond, it has tipped", above=0,
        maximum=math.pi / 2,
    )  # fmt: skip
