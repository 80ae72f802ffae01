"""Wheels that differ from the laws' model: radius of each, and half the track.

Laws, guard and map assume robot.r and robot.l; these shares are the robot's deviations. A wheel of
radius r_i turns a torque into the force tau_i/r_i, and the encoder on it counts v_i/r_i; half the
true track l' is the arm of both. Source: geometry; tyres wear and lose pressure. Noise and push are
torques at wheels of the believed size.
"""

import math

from wmr_ctrl.core.fields.section import Section, quantity
from wmr_ctrl.core.signals import TORQUE
from wmr_ctrl.core.symbolic import ca

from .effect import Bound, Effect, EffectRole, Pair, Rate, Scenario
from .model.dynamics import force_to_wheel
from .model.system import Number, Parameters, System, outputs, ports
from .motor import largest_torque


class Wheels(Section, key="wheels"):
    """Relative errors of wheel radii and track; the defaults are none."""

    radius: tuple[float, float] = quantity(
        (0.0, 0.0),
        "1",
        "share by which the right, left wheel's radius exceeds robot.r",
        minimum=-0.5,
        maximum=0.5,
    )
    track: float = quantity(
        0.0, "1", "share by which the track exceeds robot.l", minimum=-0.5, maximum=0.5
    )

    @property
    def believed(self) -> bool:
        """True if the wheels equal the laws' model."""
        return self.radius == (0.0, 0.0) and self.track == 0.0


def build(scenario: Scenario) -> System:
    """Plant-rate System: from torques at true wheels to equivalent ones at believed wheels.

    Thrust tau_r/r_r + tau_l/r_l and moment l' (tau_r/r_r - tau_l/r_l) are those of the true ones.
    """
    torque, p = ports(TORQUE), Parameters(scenario)
    r, half_track = p.take("robot.r"), p.take("robot.l")
    radius, arm = true_wheels(p)
    right, left = torque[0].sym / radius[0], torque[1].sym / radius[1]
    acting = force_to_wheel(r, half_track, ca.vertcat(right + left, arm * (right - left)))
    title, shown = "wheels of another size than believed", outputs(TORQUE, acting)
    return System("wheels", title, inputs=torque, params=p.ports, outputs=shown)


def true_wheels(p: Parameters) -> "tuple[ca.SX, ca.SX]":
    """Radii (2,) and half the track [m], for parameters that include those of this effect."""
    radius = p.take("robot.r") * (1 + p.take("wheels.radius"))
    return radius, p.take("robot.l") * (1 + p.take("wheels.track"))


def bound(scenario: Scenario) -> Bound:
    """Force error of torques up to the limit, for wheels of another size.

    Without a torque limit there is no bound.
    """
    wheels, robot, most = scenario.section(Wheels), scenario.robot, largest_torque(scenario)
    if math.isinf(most):
        return Bound(
            void="actuator.tau_max = inf: wheels of another size than believed ([wheels]) are off "
            "by a share of the torque, which nothing bounds here."
        )
    return Bound(dbar=misdriven_by(wheels.radius, wheels.track, (robot.r, robot.l), most))


def misdriven_by(
    radius: tuple[Number, Number], track: Number, believed: tuple[Number, Number], most: Number
) -> tuple[Number, Number]:
    """Errors of thrust [N] and moment [N m], for torques of at most ``most`` [N m].

    With a_i = 1/(1 + radius_i) and k = 1 + track the errors are sum (a_i - 1) tau_i/r and l sum
    +-(k a_i - 1) tau_i/r, so at most tau sum |a_i - 1|/r and l tau sum |k a_i - 1|/r (ledger:
    world.wheels.*).  Shares and the ``believed`` (r, l) [m] are numbers or symbols.
    """
    (right, left), (r, half_track) = (1.0 / (1.0 + item) for item in radius), believed
    wider = 1.0 + track
    thrust = most / r * (abs(right - 1.0) + abs(left - 1.0))
    moment = most / r * (abs(wider * right - 1.0) + abs(wider * left - 1.0))
    return thrust, half_track * moment


def misread(scenario: Scenario) -> Pair:
    """Errors of v1 and omega computed from wheel speeds with the believed wheels.

    With c = (a_r + a_l)/2 and d = (a_r - a_l)/2 the computed values are c v1 + d l' omega and (d v1
    + c l' omega)/l.  Their errors are at most |c - 1| u1 + |d| l' u2 [m/s] and |c l'/l - 1| u2 +
    |d| u1/l [rad/s] within the limits u1, u2 (ledger: world.wheels.misread*).
    """
    wheels = scenario.section(Wheels)
    return misread_by(wheels.radius, wheels.track, scenario.robot.l, scenario.limits.v_u1)


def misread_by(
    radius: tuple[Number, Number], track: Number, half_track: Number, most: tuple[Number, Number]
) -> tuple[Number, Number]:
    """`misread` for shares of the ``radius`` and the ``track``, numbers or symbols.

    ``half_track`` [m] is the believed l, ``most`` [m/s, rad/s] the limits (u1, u2).
    """
    right, left = (1.0 / (1.0 + item) for item in radius)
    mean, half, wider = (right + left) / 2.0, abs(right - left) / 2.0, 1.0 + track
    u1, u2 = most
    return (
        abs(mean - 1.0) * u1 + half * wider * half_track * u2,
        abs(mean * wider - 1.0) * u2 + half * u1 / half_track,
    )


WHEELS = Effect("wheels", EffectRole.DRIVE, Wheels, build, bound, rate=Rate.STEP)
