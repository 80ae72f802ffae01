"""The velocity guard: the smallest change of a law's force that keeps |v| <= v_u1 at every instant.

Source: a control barrier function for h = v_u1 -+ v in the worst case over mass, friction and
disturbance, valid for a force that is held over the whole control period; the theorem with its
proof is in docs/guarantee.md.  It is no part of the paper.  Per axis, with the measured velocity y:

    room(y) = v_u1 - max(y + nbar, f_speed),        net = dbar - f_min
    hi(y)   = max(slope room(y) - net, -brake),     slope = M_min alpha inside, M_max/T outside
    lo(y)   = -hi(-y),                              F = min(max(asked, lo), hi)

No logarithm, no model of the friction, nothing that the law knows.  Choose it whenever the limit
has to hold; its price is the speed that the bounds cost (see `usable_speed`).
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import casadi as ca

from wmr_ctrl.laws.applied import Applied
from wmr_ctrl.laws.guard_bounds import ROUNDING, settled_guard, wheel_limit
from wmr_ctrl.laws.guard_monitor import Monitor
from wmr_ctrl.laws.wheel_map import MAPS
from wmr_ctrl.model.dynamics import force_to_wheel
from wmr_ctrl.model.parameters import Parameters
from wmr_ctrl.model.system import Output, System, port, ports, stack
from wmr_ctrl.scenario import Scenario
from wmr_ctrl.signals import FORCE, TORQUE, VELOCITY

NUMBERS = ("M_min", "M_max", "dbar", "nbar", "alpha", "brake", "f_min", "f_speed")


@dataclass(frozen=True)
class Bounds:
    """Symbols (or numbers) of one axis that the guard's formula reads; SI units as in Guard."""

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

    @property
    def net(self) -> ca.SX:
        """Disturbance less the friction that is sure to act [N or N m]."""
        return self.dbar - self.f_min

    @property
    def cap(self) -> ca.SX:
        """Largest force away from rest: what hi is at rest, and at most what it brakes with."""
        return self.M_min * self.alpha * (self.u1 - self.f_speed) - self.net

    def axis(self, i: int) -> Bounds:
        """The bounds of axis ``i``, for bounds that hold both."""
        parts = {item.name: getattr(self, item.name) for item in fields(self)}
        return Bounds(**{key: v[i] if v.numel() > 1 else v for key, v in parts.items()})


def bounds_of(scenario: Scenario, p: Parameters, tau_max: float) -> Bounds:
    """Symbols of both axes' bounds, valued by `settled_guard`; u1 is shrunk against rounding."""
    settled = settled_guard(scenario, tau_max)
    read = {name: p.field(f"guard.{name}", settled, name) for name in NUMBERS}
    u1 = p.take("limits.v_u1") * (1 - ROUNDING)
    return Bounds(u1=u1, period=p.take("clock.control"), **read)


def ceiling(y: ca.SX, b: Bounds) -> ca.SX:
    """hi(y) of one axis [N or N m]: largest force that is safe at the measured velocity y."""
    room = b.u1 - ca.fmax(y + b.nbar, b.f_speed)
    slope = ca.if_else(room >= 0, b.M_min * b.alpha, b.M_max / b.period)
    return ca.fmax(slope * room - b.net, -ca.fmin(b.brake, b.cap))


def floor(y: ca.SX, b: Bounds) -> ca.SX:
    """lo(y) of one axis [N or N m]: smallest force that is safe."""
    return -ceiling(-y, b)


def clipped(asked: ca.SX, y: ca.SX, b: Bounds) -> ca.SX:
    """The nearest safe force of one axis; a force that is not a number becomes a safe one."""
    return ca.fmin(ca.fmax(asked, floor(y, b)), ceiling(y, b))


def feasible(b: Bounds) -> ca.SX:
    """1 where lo <= hi for every y, hence where there is always a safe force; else 0."""
    conditions = (
        2 * b.net <= b.M_min * b.alpha * (b.u1 - b.f_speed),
        2 * b.nbar <= b.u1,
        b.brake >= b.net,
        b.alpha * b.period <= 1 + ROUNDING,
        b.M_min <= b.M_max,
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
    feasible: ca.SX


def guarded(asked: ca.SX, v: ca.SX, both: Bounds) -> Guarded:
    """Pass (thrust, moment) [N, N m] through both axes' guards at measured velocity (2,)."""
    axes = [both.axis(i) for i in (0, 1)]
    force = ca.vertcat(*(clipped(asked[i], v[i], b) for i, b in enumerate(axes)))
    safe = ca.vertcat(*(clipped(ca.SX(0), v[i], b) for i, b in enumerate(axes)))
    possible = ca.logic_and(feasible(axes[0]), feasible(axes[1]))
    return Guarded(force, safe, force != asked, possible)


def guard(scenario: Scenario) -> System:
    """The guard by itself: asked force and measured velocity to wheel torques within tau_max.

    Raises ScenarioError where its settings cannot be met.
    """
    asked, velocity = port(FORCE), ports(VELOCITY)
    p = Parameters(scenario)
    applied, v = Applied(scenario, p), stack(item.sym for item in velocity)
    torque, monitor = guarded_torque(scenario, p, asked.sym, v, applied.value, None)
    return System(
        "guard",
        "velocity guard",
        (asked, *velocity),
        (*applied.state, *monitor.state),
        p.ports,
        ca.vertcat(*applied.following(torque), monitor.update),
        tuple(Output(signal, torque[i]) for i, signal in enumerate(TORQUE)),
        monitor.diagnostics,
        scenario.clock.control,
    )


def guarded_torque(
    scenario: Scenario, p: Parameters, asked: ca.SX, v: ca.SX, applied: ca.SX, law: str | None
) -> tuple[ca.SX, Monitor]:
    """Wheel torques (2,) [N m] of a guarded force, and what watches over the guard's bounds."""
    r, half_track, tau_max = p.take("robot.r"), p.take("robot.l"), wheel_limit(scenario, p, law)
    both, phi = bounds_of(scenario, p, tau_max.number), 2 * tau_max.sym / r
    held = guarded(asked, v, both)
    torque = force_to_wheel(
        r, half_track, MAPS[scenario.guard.map](held.force, phi, half_track, held.safe)
    )
    possible = ca.logic_and(held.feasible, within_reach(both, phi, half_track))
    return torque, Monitor(both, v, applied, (r, half_track), (held.active, possible))


def within_reach(both: Bounds, phi: ca.SX, half_track: ca.SX) -> ca.SX:
    """1 where the wheels can brake both axes at once, FB1 + FB2/l <= phi; else 0."""
    first, second = (ca.fmin(b.brake, b.cap) for b in (both.axis(0), both.axis(1)))
    return first + second / half_track <= phi * (1 + ROUNDING)
