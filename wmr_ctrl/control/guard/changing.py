"""Limits of the velocity guard that change while the robot drives.

A limit falls by at most what the guard surely brakes in a period T, so that the robot stays within
the limit in force at every instant (`guard.falling`):

    fall <= T (braking - net)/M_max,      braking = min(brake, M_min alpha (u1 - f_speed) - net)

with u1 the smaller limit of both directions after the fall. No limit in force is below

    f_speed + 2 net/(M_min alpha)        and 2 nbar,

where the guard has no force left to give. A rise acts at once.
"""

from dataclasses import replace

import casadi as ca

from wmr_ctrl.control.sides import is_number, limits_port
from wmr_ctrl.core.signals import Signal
from wmr_ctrl.world.model.system import Output, Parameters, port
from wmr_ctrl.world.scenario import Scenario

from .guard import Bounds
from .monitor import GuardMemory

IN_FORCE = Signal(
    "limits_in_force", "m/s, m/s, rad/s, rad/s", "limits that the guard keeps: v, then omega", 4
)
BEHIND = Signal("limits_behind", "1", "1: a limit in force is still wider than the one told")


def changing_limits(scenario: Scenario, p: Parameters, both: Bounds) -> tuple[Bounds, GuardMemory]:
    """Both axes' bounds with the limits in force, which fall slowly enough, and their memory."""
    told = limits_port(scenario)
    before = port(IN_FORCE, told.value)
    falling = scenario.guard.falling
    slower = None if falling is None else p.take("guard.falling")
    limits, behind = list[ca.SX](), ca.SX(0)
    for i in (0, 1):
        b = both.axis(i)
        widest = b.mirrored.u1, b.u1  # backwards, forwards
        fall = largest_fall(b, [way * before.sym[2 * i + k] for k, way in _SIDES], [
            _usable(way * told.sym[2 * i + k], widest[k], b) for k, way in _SIDES
        ])  # fmt: skip
        if slower is not None:
            fall = ca.fmin(fall, slower[i] * b.period)
        for k, way in _SIDES:
            wanted = _usable(way * told.sym[2 * i + k], widest[k], b)
            limit = ca.fmax(wanted, way * before.sym[2 * i + k] - fall)
            limit = ca.fmin(limit, widest[k])
            behind = ca.logic_or(behind, limit > way * told.sym[2 * i + k])
            limits.append(limit)
    update = ca.vertcat(-limits[0], limits[1], -limits[2], limits[3])
    ahead, back = ca.vertcat(limits[1], limits[3]), ca.vertcat(limits[0], limits[2])
    memory = GuardMemory((before,), update, (Output(BEHIND, behind),), (told,))
    return replace(both, u1=ahead, back=back), memory


_SIDES = ((0, -1), (1, 1))
"""Place of a limit in its axis' pair, and the direction that it limits."""


def _usable(limit: ca.SX, widest: ca.SX, b: Bounds) -> ca.SX:
    """The limit nearest to the received one (NaN as 0) that the guard can keep."""
    least = ca.fmax(b.f_speed + 2 * ca.fmax(b.net, 0) / (b.M_min * b.alpha), 2 * b.nbar)
    return ca.fmin(ca.fmax(ca.if_else(is_number(limit), limit, 0), least), widest)


def largest_fall(b: Bounds, before: list[ca.SX], wanted: list[ca.SX]) -> ca.SX:
    """Largest fall of both directions' limits in a period."""
    narrow, stiff = ca.fmin(*before), b.period * b.M_min * b.alpha / b.M_max
    least = (narrow + stiff * b.f_speed + 2 * b.period * b.net / b.M_max) / (1 + stiff)
    reached = ca.fmax(ca.fmin(*wanted), least)
    braking = ca.fmin(b.brake, b.M_min * b.alpha * (reached - b.f_speed) - b.net)
    return b.period * ca.fmax(braking - b.net, 0) / b.M_max
