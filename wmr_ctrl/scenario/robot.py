"""The robot's physical parameters, and what the control laws believe about them."""

from __future__ import annotations

from wmr_ctrl.fields.section import Section, quantity


class Robot(Section, key="robot"):
    """Parameters of the plant, Eqs. (1)-(6): a two-wheeled robot with its mass on the axle."""

    m: float = quantity(50.0, unit="kg", doc="mass", above=0, usual=(0.02, 5000))
    I: float = quantity(5.4, unit="kg.m2", doc="moment of inertia about the vertical", above=0)
    mu: float = quantity(
        0.08, unit="1", doc="coefficient of Coulomb friction", minimum=0, usual=(0, 1)
    )
    r: float = quantity(
        0.1, unit="m", doc="radius of the driving wheels", above=0, usual=(0.003, 1)
    )
    l: float = quantity(
        0.25, unit="m", doc="half the track: axle's midpoint to wheel", above=0, usual=(0.005, 3)
    )
    g: float = quantity(9.81, unit="m/s2", doc="gravity", above=0)
    v_s: float = quantity(
        0.01, unit="m/s", doc="speed that smooths friction, mu m g tanh(v1/v_s)", above=0
    )


class Model(Section, key="model"):
    """What the laws believe; a field that is left out is the robot's, before any change."""

    m: float | None = quantity(
        None, unit="kg", doc="mass that the laws believe; left out: robot.m", above=0
    )
    I: float | None = quantity(
        None, unit="kg.m2", doc="inertia that the laws believe; left out: robot.I", above=0
    )
    mu: float | None = quantity(
        None, unit="1", doc="friction that the laws believe; left out: robot.mu", minimum=0
    )
