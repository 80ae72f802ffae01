"""Straight line at constant speed along (-sin heading, cos heading)."""

from __future__ import annotations

from collections.abc import Mapping

import casadi as ca

from wmr_ctrl.model.references.kinds import Parameters
from wmr_ctrl.scenario.reference import Line
from wmr_ctrl.signals import Signal

SPEED = Signal("ref_speed", "m/s", "speed of the desired motion")
HEADING = Signal("ref_heading", "rad", "orientation of the desired line, 0 along +Y")
ORIGIN = Signal("ref_origin", "m", "desired position at t = 0", 2)


def parameters(reference: Line) -> Parameters:
    """Return speed [m/s], heading [rad] and origin [m]."""
    return (
        (SPEED, (reference.speed,)),
        (HEADING, (reference.heading,)),
        (ORIGIN, reference.origin),
    )


def trajectory(t: ca.SX, p: Mapping[str, ca.SX]) -> ca.SX:
    """Return the reference (7, 1) at time ``t`` [s], in the order of ``signals.REFERENCE``."""
    speed, heading, origin = p[SPEED.name], p[HEADING.name], p[ORIGIN.name]
    x = origin[0] - ca.sin(heading) * speed * t
    y = origin[1] + ca.cos(heading) * speed * t
    return ca.vertcat(x, y, heading, speed, 0, 0, 0)
