"""Monitor of both axes: finds motion of the robot that contradicts the guard's assumptions.

It runs after every law, with the guard on or off, and changes no torque.

While v > 0 at both ends of a sample, friction can only slow the robot.  So with every mass in
[M_min, M_max] and velocities known to +-nbar the mean disturbance was at least

    d_least = min over M of M (v_k - v_(k-1) - 2 nbar)/T  -  F,         F the force applied,

mirrored for v < 0, and 0 if nothing can be concluded (rest, a change of direction, the first
sample).  A d_least above dbar proves that one of the guard's assumptions does not hold; below it,
no assumption is refuted.  Slower motion than expected never counts: friction of any size explains
it.

If velocities are late or averaged, or only bounds of the acting force are known, `LateMotion`
replaces the formula above.  It finds motion that the possible forces, with the guard's weights and
without disturbance, cannot explain.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import ceil
from typing import TYPE_CHECKING

import casadi as ca

from wmr_ctrl.core.signals import GUARD_DIAGNOSTICS, Signal
from wmr_ctrl.world.model.dynamics import wheel_to_force
from wmr_ctrl.world.model.system import Output, Port, port

from .delay import Tails, moved_since
from .lateness import AT_ONCE, Since

if TYPE_CHECKING:
    from .guard import Bounds

OLD_VELOCITY = Signal("guard_v", "m/s, rad/s", "measured velocity of the previous sample", 2)
STARTED = Signal("guard_started", "1", "0 before the first sample, then 1")
SAMPLES = Signal("guard_samples", "1", "samples since the start, until what is counted is known")


@dataclass(frozen=True)
class GuardMemory:
    """State, its update, diagnostics and inputs that a part of the guard adds to a System."""

    state: tuple[Port, ...]
    update: ca.SX
    diagnostics: tuple[Output, ...] = ()
    inputs: tuple[Port, ...] = ()

    def and_more(self, other: GuardMemory) -> GuardMemory:
        """Both parts, the other one behind this one."""
        return GuardMemory(
            (*self.state, *other.state),
            ca.vertcat(self.update, other.update),
            (*self.diagnostics, *other.diagnostics),
            (*self.inputs, *other.inputs),
        )


def monitored(
    both: Bounds,
    v: ca.SX,
    applied: ca.SX,
    wheels: tuple[ca.SX, ca.SX],
    flags: tuple[ca.SX, ca.SX],
    late: LateMotion | None = None,
) -> GuardMemory:
    """Monitor ``both`` axes at velocity v (2,), for torques applied [N m], r and l [m].

    ``flags``: clip_active (2,) and feasible, from the guard or its substitute.  ``late``: the
    torque that was applied does not belong to the velocities.
    """
    old, started = port(OLD_VELOCITY), port(SAMPLES if late else STARTED)
    force = wheel_to_force(*wheels, applied)
    if late is None:
        least = [least_push(v[i], old.sym[i], force[i], both.axis(i)) for i in (0, 1)]
        known, begun = started.sym > 0, ca.SX(1)
    else:
        least = [late.least_push(i, v[i], old.sym[i], both.axis(i)) for i in (0, 1)]
        known, begun = started.sym >= late.begins, ca.fmin(started.sym + 1, late.begins)
    push = ca.vertcat(*(ca.if_else(known, item, 0) for item in least))
    tails = late.tails.state if late else ()
    values = (flags[0], push, flags[1])
    return GuardMemory(
        (old, started, *tails),
        ca.vertcat(v, begun, *([late.following(both)] if late else [])),
        tuple(Output(*pair) for pair in zip(GUARD_DIAGNOSTICS, values, strict=True)),
    )


class LateMotion:
    """Motion explained by the commands that may have acted since the previous sample."""

    def __init__(
        self, since: tuple[Since | None, Since | None], sent: Sequence[ca.SX], new: ca.SX
    ) -> None:
        """Create it for forces (2,) ``sent``, the latest first, and the ``new`` one."""
        self.since, self.sent, self.new = since, sent, new
        older = [item.older for item in since if item is not None]
        self.begins = 1 + ceil(max((item.most for item in older), default=0.0))
        lates = tuple(item.older if item else AT_ONCE for item in since)
        self.tails = Tails("guard_monitor_tail", (lates[0], lates[1]))

    def least_push(self, axis: int, v: ca.SX, old: ca.SX, b: Bounds) -> ca.SX:
        """d_least of one axis [N or N m], >= 0; 0 if the window is longer than a period."""
        since = self.since[axis]
        if since is None:
            return ca.SX(0)
        alone = _unpushed(b)
        mean, rest = moved_since(self.sent, since, axis, alone, self.tails)
        push = ca.SX(0)
        for way in (1, -1):
            moved, begun = way * (v - old) - 2 * b.nbar, way * v - b.nbar
            first = (moved - mean.ahead) / since.mean_time
            second = (begun - rest.ahead) / since.rest_time
            push = ca.fmax(push, b.M_min / b.period * ca.fmin(first, second))
            mean, rest = mean.mirrored, rest.mirrored
        return push

    def following(self, both: Bounds) -> ca.SX:
        """Next state of the tails."""
        return self.tails.following([self.new, *self.sent], _unpushed(both))


def _unpushed(b: Bounds) -> Bounds:
    """The bounds without disturbance and without certain friction."""
    return replace(b, dbar=0 * b.dbar, f_min=0 * b.f_min)


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
