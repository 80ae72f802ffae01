"""Generalised force to wheel torques within |tau| <= tau_max, never by a clip per wheel.

The wheels can give |F| + |N|/l <= phi = 2 tau_max/r.  Clipping each torque by itself changes F and
N at once; behind a guard it can turn a braking force into a driving one.  The maps here reduce one
axis after the other.  What they reduce it towards is the safe point: the force of least effort
inside the guard's box, zero without a guard.  Where the safe point is within reach, each map's
result lies between the safe point and what was asked, so it stays in the box.
"""

from __future__ import annotations

import casadi as ca


def linear_first(force: ca.SX, phi: ca.SX, half_track: ca.SX, safe: ca.SX | None = None) -> ca.SX:
    """Force (N, N m) within the wheels' reach phi [N]: thrust first, the moment takes the rest.

    The thrust leaves what the moment of the safe point (2,) needs.
    """
    room = phi if safe is None else phi - ca.fabs(safe[1]) / half_track
    thrust = _clip(force[0], room)
    moment = _clip(force[1], half_track * (phi - ca.fabs(thrust)))
    return ca.vertcat(thrust, moment)


def rotation_first(force: ca.SX, phi: ca.SX, half_track: ca.SX, safe: ca.SX | None = None) -> ca.SX:
    """The same with the axes' order exchanged: the moment first, the thrust takes the rest."""
    room = phi if safe is None else phi - ca.fabs(safe[0])
    moment = _clip(force[1], half_track * room)
    thrust = _clip(force[0], phi - ca.fabs(moment) / half_track)
    return ca.vertcat(thrust, moment)


MAPS = {"linear-first": linear_first, "rotation-first": rotation_first}
"""By the value of guard.map."""


def _clip(value: ca.SX, bound: ca.SX) -> ca.SX:
    return ca.fmax(-bound, ca.fmin(bound, value))
