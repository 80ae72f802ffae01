"""Circle of Section V: x_d = R sin wt, y_d = R - R cos wt, theta_d = wt - pi/2."""

from __future__ import annotations

from collections.abc import Mapping

import casadi as ca

from wmr_ctrl.model.references.kinds import Parameters
from wmr_ctrl.scenario.reference import Circle
from wmr_ctrl.signals import Signal

RADIUS = Signal("ref_radius", "m", "radius of the desired circle")
RATE = Signal("ref_rate", "rad/s", "angular rate of the desired motion")


def parameters(reference: Circle) -> Parameters:
    """Return radius [m] and rate [rad/s]."""
    return ((RADIUS, (reference.radius,)), (RATE, (reference.rate,)))


def trajectory(t: ca.SX, p: Mapping[str, ca.SX]) -> ca.SX:
    """Return the reference (7, 1) at time ``t`` [s], in the order of ``signals.REFERENCE``."""
    radius, rate = p[RADIUS.name], p[RATE.name]
    angle = rate * t
    return ca.vertcat(
        radius * ca.sin(angle),
        radius - radius * ca.cos(angle),
        angle - ca.pi / 2,
        radius * rate,
        rate,
        0,
        0,
    )
