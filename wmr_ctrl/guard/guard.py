"""The velocity guard: the smallest change of a law's force that keeps |v| <= v_u1 at every instant.

Source: a control barrier function for h = v_u1 -+ v in the worst case over mass, friction and
disturbance, valid for a force that is held over the whole control period; the theorem with its
proof is in docs/guarantee.md.  It is no part of the paper.  Per axis, with the measured velocity y:

    room(y) = v_u1 - max(y + nbar, f_speed),        net = dbar - f_min
    hi(y)   = max(slope room(y) - net, -brake),     slope = M_min alpha inside, M_max/T outside
    lo(y)   = -hi(-y),                              F = min(max(asked, lo), hi)

Behind drives with a delay the room shrinks by what is under way (see `guard_delay`).

No logarithm, no model of the friction, nothing that the law knows.  Choose it whenever the limit
has to hold; its price is the speed that the bounds cost (see `usable_speed`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields

import casadi as ca

from wmr_ctrl.guard.bounds import ROUNDING, rounding
from wmr_ctrl.guard.delay import UnderWay, largest_force, under_way
from wmr_ctrl.model.parameters import Parameters

NUMBERS = ("M_min", "M_max", "dbar", "nbar", "alpha", "brake", "f_min", "f_speed")


@dataclass(frozen=True)
class Bounds:
    """Symbols (or numbers) of one axis that the guard's formula reads; SI units as in Guard.

    ``delay`` [s] is what the graph was built for; None without delay.
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

    @property
    def net(self) -> ca.SX:
        """Disturbance less the friction that is sure to act [N or N m]."""
        return self.dbar - self.f_min

    @property
    def cap(self) -> ca.SX:
        """Most that it may brake with; without delay also what hi is at rest."""
        reach = self.M_min * self.alpha * (self.u1 - self.f_speed)
        return (reach if self.delay is None else reach / (1 + self.alpha * self.delay)) - self.net

    @property
    def braking(self) -> ca.SX:
        """Largest force with which it brakes [N or N m]."""
        return ca.fmin(self.brake, self.cap)

    def axis(self, i: int) -> Bounds:
        """The bounds of axis ``i``, for bounds that hold both."""
        parts = {item.name: getattr(self, item.name) for item in fields(self)}
        return Bounds(**{key: v[i] if v is not None and v.numel() > 1 else v
                         for key, v in parts.items()})  # fmt: skip


def bounds_of(p: Parameters, sent: Sequence[tuple[ca.SX, float]]) -> Bounds:
    """Symbols of both axes' bounds with the guard's numbers; u1 is shrunk against rounding.

    ``sent``: commands under way, and for how many periods from now on each will act.
    """
    read = {name: p.take(f"guard.{name}") for name in NUMBERS}
    period = p.take("clock.control")
    u1 = p.take("limits.v_u1") * (1 - rounding(len(sent)))
    delay = period * sum(share for _, share in sent) if sent else None
    return Bounds(u1=u1, period=period, delay=delay, **read)


def ceiling(y: ca.SX, b: Bounds, coming: UnderWay | None = None) -> ca.SX:
    """hi(y) of one axis [N or N m]: largest force that is safe at the measured velocity y.

    ``coming`` goes with bounds that have a delay.
    """
    fastest = ca.fmax(y + b.nbar, b.f_speed)
    room = b.u1 - (fastest if coming is None else fastest + coming.ahead)
    slope = ca.if_else(room >= 0, b.M_min * b.alpha, b.M_max / b.period)
    hi = ca.fmax(slope * room - b.net, -b.braking)
    return hi if coming is None else ca.fmin(hi, largest_force(b))


def floor(y: ca.SX, b: Bounds, coming: UnderWay | None = None) -> ca.SX:
    """lo(y) of one axis [N or N m]: smallest force that is safe."""
    return -ceiling(-y, b, None if coming is None else coming.mirrored)


def clipped(asked: ca.SX, y: ca.SX, b: Bounds, coming: UnderWay | None = None) -> ca.SX:
    """The nearest safe force of one axis; a force that is not a number becomes a safe one."""
    return ca.fmin(ca.fmax(asked, floor(y, b, coming)), ceiling(y, b, coming))


def feasible(b: Bounds) -> ca.SX:
    """1 where lo <= hi for every y, hence where there is always a safe force; else 0."""
    need = 2 * b.net if b.delay is None else 2 * b.net * (1 + b.alpha * b.delay)
    conditions = (
        need <= b.M_min * b.alpha * (b.u1 - b.f_speed),
        2 * b.nbar <= b.u1,
        b.brake >= b.net,
        b.alpha * b.period <= 1 + ROUNDING,
        b.M_min <= b.M_max,
        b.f_speed < b.u1,
    )
    result = conditions[0]
    for condition in conditions[1:]:
        result = ca.logic_and(result, condition)
    return result


@dataclass(frozen=True)
class Guarded:
    """What the guard makes of a force: both axes' force, the safe point, whether it acted."""

    force: ca.SX
    safe: ca.SX
    active: ca.SX


def guarded(
    asked: ca.SX, v: ca.SX, both: Bounds, sent: Sequence[tuple[ca.SX, float]] = ()
) -> Guarded:
    """Pass (thrust, moment) [N, N m] through both axes' guards at measured velocity (2,).

    ``sent``: forces (2,) under way, and for how many periods from now on each will act.
    """
    axes = [
        (v[i], b, under_way(sent, i, b) if sent else None)
        for i, b in enumerate(map(both.axis, (0, 1)))
    ]
    force = ca.vertcat(*(clipped(asked[i], *axis) for i, axis in enumerate(axes)))
    safe = ca.vertcat(*(clipped(ca.SX(0), *axis) for axis in axes))
    return Guarded(force, safe, force != asked)


def possible(p: Parameters, both: Bounds, phi: ca.SX, half_track: ca.SX) -> ca.SX:
    """1 where both axes' bounds can be met, by the wheels too (``phi`` = 2 tau_max/r [N]).

    With a delay, 0 as well where the parameter actuator.delay is longer than the graph allows for.
    """
    axes = ca.logic_and(feasible(both.axis(0)), feasible(both.axis(1)))
    met = ca.logic_and(axes, within_reach(both, phi, half_track))
    if both.delay is None:
        return met
    return ca.logic_and(met, p.take("actuator.delay") <= both.delay * (1 + ROUNDING))


def within_reach(both: Bounds, phi: ca.SX, half_track: ca.SX) -> ca.SX:
    """1 where the wheels can brake both axes at once, FB1 + FB2/l <= phi; else 0."""
    first, second = (b.braking for b in (both.axis(0), both.axis(1)))
    return first + second / half_track <= phi * (1 + ROUNDING)
