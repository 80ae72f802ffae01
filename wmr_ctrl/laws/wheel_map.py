"""Generalised force to wheel torques within |tau| <= tau_max, never by a clip per wheel.

The wheels can give |F| + |N|/l <= Phi = 2 tau_max/r.  Clipping each torque by itself changes F and
N at once; here the moment keeps what the thrust leaves, so each stays a fraction of what was asked.
"""

from __future__ import annotations

import casadi as ca


def linear_first(force: ca.SX, phi: ca.SX, half_track: ca.SX) -> ca.SX:
    """Force (N, N m) within the wheels' reach phi [N]: thrust first, the moment takes the rest."""
    thrust = _clip(force[0], phi)
    moment = _clip(force[1], half_track * (phi - ca.fabs(thrust)))
    return ca.vertcat(thrust, moment)


def _clip(value: ca.SX, bound: ca.SX) -> ca.SX:
    return ca.fmax(-bound, ca.fmin(bound, value))
