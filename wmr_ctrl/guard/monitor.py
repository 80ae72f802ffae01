"""Does what the robot does contradict what a guard assumes?  One sampled filter of both axes.

It stands behind every law, with the guard on or off, and changes no torque.

While v > 0 at both ends of a sample, friction can only slow the robot, so with every mass in
[M_min, M_max] and velocities known to +-nbar the mean disturbance was at least

    d_least = min over M of M (v_k - v_(k-1) - 2 nbar)/T  -  F,         F the force applied,

mirrored for v < 0, and 0 where nothing can be told (rest, a change of direction, the first sample).
A d_least above dbar proves that one of the guard's assumptions does not hold; below it, none of
them is refuted.  Slower motion than expected never counts: friction of any size explains it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import casadi as ca

from wmr_ctrl.model.dynamics import wheel_to_force
from wmr_ctrl.model.system import Output, Port, port
from wmr_ctrl.signals import GUARD_DIAGNOSTICS, Signal

if TYPE_CHECKING:
    from wmr_ctrl.guard.guard import Bounds

OLD_VELOCITY = Signal("guard_v", "m/s, rad/s", "measured velocity of the previous sample", 2)
STARTED = Signal("guard_started", "1", "0 before the first sample, then 1")


class GuardMonitor:
    """State, update and diagnostics that watching brings into a System."""

    def __init__(
        self,
        both: Bounds,
        v: ca.SX,
        applied: ca.SX,
        wheels: tuple[ca.SX, ca.SX],
        flags: tuple[ca.SX, ca.SX],
    ) -> None:
        """Watch over ``both`` axes at velocity v (2,), for torques applied [N m], r and l [m].

        ``flags``: clip_active (2,) and feasible, as the guard or what stands in its place has them.
        """
        old, started = port(OLD_VELOCITY), port(STARTED)
        force = wheel_to_force(*wheels, applied)
        least = [least_push(v[i], old.sym[i], force[i], both.axis(i)) for i in (0, 1)]
        known = started.sym > 0
        push = ca.vertcat(*(ca.if_else(known, item, 0) for item in least))
        self.state: tuple[Port, ...] = (old, started)
        self.update: ca.SX = ca.vertcat(v, 1)
        values = (flags[0], push, flags[1])
        self.diagnostics: tuple[Output, ...] = tuple(
            Output(signal, value) for signal, value in zip(GUARD_DIAGNOSTICS, values, strict=True)
        )


def least_push(v: ca.SX, old: ca.SX, force: ca.SX, b: Bounds) -> ca.SX:
    """d_least of one axis [N or N m], >= 0."""
    ahead = _outward(v - old, force, b)
    back = _outward(old - v, -force, b)
    forward = ca.fmin(v, old) > b.nbar
    backward = ca.fmax(v, old) < -b.nbar
    return ca.if_else(forward, ahead, ca.if_else(backward, back, 0))


def _outward(gained: ca.SX, force: ca.SX, b: Bounds) -> ca.SX:
    rate = (gained - 2 * b.nbar) / b.period
    mass = ca.if_else(rate >= 0, b.M_min, b.M_max)
    return ca.fmax(mass * rate - force, 0)
