"""The velocity guard: the smallest change of a law's force that keeps |v| <= v_u1 at every instant.

Source: a control barrier function for h = v_u1 -+ v in the worst case over mass, friction and
disturbance, valid for a force that is held over the whole control period.  The theorem with its
proof is in docs/explanation/guarantee.md.  The guard is not part of the paper.  Per axis, with the
measured velocity y:

    room(y) = v_u1 - max(y + nbar, f_speed),        net = dbar - f_min
    hi(y)   = max(slope room(y) - net, -brake),     slope = M_min alpha inside, M_max/T outside
    lo(y)   = -hi(-y),                              F = min(max(asked, lo), hi)

With late velocities or drives the room shrinks by the effect of commands in transit (see
`guard.delay`).

The guard contains no logarithm, no model of the friction, and no knowledge of the law.  Choose it
whenever the limit has to hold; its price is the speed that the bounds cost (see `usable_speed`).

Behind it a map turns the force into wheel torques within |tau| <= tau_max.  The wheels can exert
|F| + |N|/l <= phi = 2 tau_max/r.  Clipping each torque separately would change both F and N, and
could turn a braking force into a driving one.  The maps reduce one axis after the other, towards
the safe point: the force of least effort inside the guard's box, or zero without a guard.  If the
safe point is within reach, each map's result lies between the safe point and the requested force,
so it stays in the box.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import reduce

import casadi as ca

from wmr_ctrl.control.sides import sides
from wmr_ctrl.world.model.system import Parameters
from wmr_ctrl.world.scenario.sections import Limits

from .bounds import rounding
from .delay import InFlight, largest_force
from .lateness import Counting

TIMES = ("delay", "jitter", "mixed")
NUMBERS = ("M_min", "M_max", "dbar", "nbar", "alpha", "brake", "f_min", "f_speed")


@dataclass(frozen=True)
class Bounds:
    """Symbols (or numbers) of one axis in the guard's formula; SI units as in Guard.

    ``u1``: limit of the velocity.  ``back``: that of its negative, None if equal.  The times [s]
    are those for which the graph was built, None if absent: ``delay``, for which sent commands may
    matter; ``mixed``, in which one of two commands acts; ``jitter``, by which a delay varies.
    """

    u1: ca.SX
    period: ca.SX
    M_min: ca.SX
    M_max: ca.SX
    dbar: ca.SX
    nbar: ca.SX
    alpha: ca.SX
    brake: ca.SX
    f_min: ca.SX
    f_speed: ca.SX
    delay: ca.SX | None = None
    jitter: ca.SX | None = None
    mixed: ca.SX | None = None
    back: ca.SX | None = None

    @property
    def narrow(self) -> ca.SX:
        """The smaller limit of both directions, which caps braking and late commands.

        So braking in one direction never passes the other direction's limit.
        """
        return self.u1 if self.back is None else ca.fmin(self.u1, self.back)

    @property
    def mirrored(self) -> "Bounds":
        """The bounds of the velocity's negative."""
        return self if self.back is None else replace(self, u1=self.back, back=self.u1)

    @property
    def net(self) -> ca.SX:
        """Disturbance less the least friction [N or N m]."""
        return self.dbar - self.f_min

    @property
    def cap(self) -> ca.SX:
        """Largest braking force allowed by the limit; without delay also hi at rest."""
        reach = self.M_min * self.alpha * (self.narrow - self.f_speed)
        reach = reach if self.delay is None else reach / (1 + self.alpha * self.delay)
        if self.mixed is not None:
            reach = ca.fmin(reach, self.M_min * (self.narrow - 2 * self.nbar) / self.mixed)
        return reach - self.net

    @property
    def braking(self) -> ca.SX:
        """Largest braking force [N or N m]."""
        return ca.fmin(self.brake, self.cap)

    def axis(self, i: int) -> "Bounds":
        """The bounds of axis ``i``, from bounds of both axes."""

        def own(value: ca.SX) -> ca.SX:
            return value[i] if value.numel() > 1 else value

        read = {name: own(getattr(self, name)) for name in ("u1", "period", *NUMBERS)}
        times = {name: own(t) for name in TIMES if (t := getattr(self, name)) is not None}
        late = {name: time for name, time in times.items() if not time.is_zero()}
        return Bounds(**read, **late, back=None if self.back is None else own(self.back))


def bounds_of(p: Parameters, late: tuple[Counting, Counting], limits: Limits) -> Bounds:
    """Symbols of both axes' bounds with the guard's numbers; u1 is shrunk against rounding."""
    read = {name: p.take(f"guard.{name}") for name in NUMBERS}
    period = p.take("clock.control")
    u1, back = sides(limits, p, rounding(max(item.roundings for item in late)))
    return Bounds(
        u1=u1,
        period=period,
        delay=_times(period, [item.most for item in late]),
        jitter=_times(period, [item.jitter for item in late]),
        mixed=_times(period, [item.mixed for item in late]),
        back=back if limits.apart else None,
        **read,
    )


def _times(period: ca.SX, each: Sequence[float]) -> ca.SX | None:
    """Times of both axes from numbers of periods; a scalar if equal, None if all are 0."""
    if not any(each):
        return None
    return period * (each[0] if each[0] == each[1] else ca.SX(ca.DM(each)))


def room(y: ca.SX, b: Bounds, coming: InFlight | None = None) -> ca.SX:
    """Room of one axis up to its limit at the measured velocity y [m/s or rad/s]."""
    fastest = ca.fmax(y + b.nbar, b.f_speed)
    if coming is None:
        return b.u1 - fastest
    return coming.left(b.u1 - coming.reached(fastest, b), b)


def ceiling(y: ca.SX, b: Bounds, coming: InFlight | None = None) -> ca.SX:
    """hi(y) of one axis [N or N m]: largest safe force at the measured velocity y.

    ``coming`` is needed for bounds with a delay.
    """
    left = room(y, b, coming)
    slope = ca.if_else(left >= 0, b.M_min * b.alpha, b.M_max / b.period)
    hi = ca.fmax(slope * left - b.net, -b.braking)
    return hi if coming is None else ca.fmin(hi, largest_force(b))


def floor(y: ca.SX, b: Bounds, coming: InFlight | None = None) -> ca.SX:
    """lo(y) of one axis [N or N m]: smallest safe force."""
    return -ceiling(-y, b.mirrored, None if coming is None else coming.mirrored)


def clipped(asked: ca.SX, y: ca.SX, b: Bounds, coming: InFlight | None = None) -> ca.SX:
    """The nearest safe force of one axis, also for NaN."""
    return ca.fmin(ca.fmax(asked, floor(y, b, coming)), ceiling(y, b, coming))


def feasible(b: Bounds) -> ca.SX:
    """1 if lo <= hi for every y, so that a safe force always exists; else 0."""
    need = 2 * b.net if b.delay is None else 2 * b.net * (1 + b.alpha * b.delay)
    conditions = [
        need <= b.M_min * b.alpha * (b.narrow - b.f_speed),
        2 * b.nbar <= b.narrow,
        b.brake >= b.net,
        b.alpha * b.period <= 1,
        b.M_min <= b.M_max,
        b.f_speed < b.narrow,
    ]
    if b.mixed is not None:
        conditions.append(2 * b.net * b.mixed <= b.M_min * (b.narrow - 2 * b.nbar))
    return reduce(ca.logic_and, conditions)


@dataclass(frozen=True)
class Guarded:
    """Output of the guard: both axes' force, the safe point, whether it changed the force."""

    force: ca.SX
    safe: ca.SX
    active: ca.SX


def guarded(
    asked: ca.SX,
    v: ca.SX,
    both: Bounds,
    coming: tuple[InFlight | None, InFlight | None] = (None, None),
) -> Guarded:
    """Pass (thrust, moment) [N, N m] through both axes' guards at measured velocity (2,).

    ``coming``: effect of each axis' commands in transit, if any.
    """
    axes = [(v[i], both.axis(i), coming[i]) for i in (0, 1)]
    force = ca.vertcat(*(clipped(asked[i], *axis) for i, axis in enumerate(axes)))
    safe = ca.vertcat(*(clipped(ca.SX(0), *axis) for axis in axes))
    return Guarded(force, safe, force != asked)


def possible(both: Bounds, phi: ca.SX, half_track: ca.SX, built_for: Sequence[ca.SX] = ()) -> ca.SX:
    """1 if both axes' bounds can be met, also by the wheels (``phi`` = 2 tau_max/r [N]).

    0 also if the drives violate the conditions ``built_for`` on the graph's parameters.
    """
    axes = ca.logic_and(feasible(both.axis(0)), feasible(both.axis(1)))
    return reduce(ca.logic_and, [axes, within_reach(both, phi, half_track), *built_for])


def within_reach(both: Bounds, phi: ca.SX, half_track: ca.SX) -> ca.SX:
    """1 if the wheels can brake both axes at the same time, FB1 + FB2/l <= phi; else 0."""
    first, second = (b.braking for b in (both.axis(0), both.axis(1)))
    return first + second / half_track <= phi


def linear_first(force: ca.SX, phi: ca.SX, half_track: ca.SX, safe: ca.SX | None = None) -> ca.SX:
    """Force (N, N m) within the wheels' reach phi [N]: thrust first, then the moment.

    The thrust leaves room for the moment of the safe point (2,).
    """
    room = phi if safe is None else phi - ca.fabs(safe[1]) / half_track
    thrust = _clip(force[0], room)
    moment = _clip(force[1], half_track * (phi - ca.fabs(thrust)))
    return ca.vertcat(thrust, moment)


def rotation_first(force: ca.SX, phi: ca.SX, half_track: ca.SX, safe: ca.SX | None = None) -> ca.SX:
    """Force (N, N m) within the wheels' reach phi [N]: moment first, then the thrust."""
    room = phi if safe is None else phi - ca.fabs(safe[0])
    moment = _clip(force[1], half_track * room)
    thrust = _clip(force[0], phi - ca.fabs(moment) / half_track)
    return ca.vertcat(thrust, moment)


MAPS = {"linear-first": linear_first, "rotation-first": rotation_first}
"""Maps from force to wheel torques, by the value of guard.map."""


def _clip(value: ca.SX, bound: ca.SX) -> ca.SX:
    return ca.fmax(-bound, ca.fmin(bound, value))
