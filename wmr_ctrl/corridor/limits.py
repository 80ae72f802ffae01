"""Limits of guard and wheels on the force that a law asks for, over cells of states."""

from dataclasses import dataclass

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from wmr_ctrl.checks.world import COMMAND, ROBOT, Floats
from wmr_ctrl.control.setup import Setup
from wmr_ctrl.corridor.affine import AffineGraph
from wmr_ctrl.corridor.certificate import Certifier
from wmr_ctrl.corridor.inputs import NoCorridorError, conditions
from wmr_ctrl.corridor.zonotopes import COARSE, SUMS, Ends, Rows, linear, with_errors
from wmr_ctrl.guard.guard import linear_first
from wmr_ctrl.model.dynamics import full_thrust

FAR_START = "a start so far off, from which limits act,"
"""Begin of what is said where such a start is not covered."""
SHARES = (0.0, 0.125, 0.25, 0.5)
"""Of what the proximal map is given, in bounds of what it gives: the rest is its ends'."""
BEYOND = 1e9
"""A force that is more than any wheels can give."""


@dataclass(frozen=True)
class AskedForce:
    """The force that a law asks for: ``rest`` + ``through`` x, x the velocity that it aims at.

    x is between the ends of ``reach``, and above min(m, u2) and below max(m, -u2) of what its
    barrier's map is given, m = ``wanted``.  ``by``: slopes of ``rest`` by the velocity ``v``, which
    is between the ends of ``known``.
    """

    force: Rows
    rest: Rows
    through: Floats
    wanted: Rows
    reach: Ends
    v: Rows
    by: Floats
    known: Ends

    def span(self, kink: Floats) -> Ends:
        """Ends of it, for v_u2 = ``kink`` (2)."""
        low, high = self.rest.plus(self.wanted, self.through).between(self.v, self.by, self.known)
        least, most = self.rest.between(self.v, self.by, self.known)
        low = np.minimum(low, least + self.through * kink)
        high = np.maximum(high, most - self.through * kink)
        own = self.force.ends
        return np.maximum(low, own[0]), np.minimum(high, own[1])

    def moved(self, gain: Floats, drift: Rows, spare: Floats) -> Ends:
        """Ends of v + gain * sent + drift, for what is sent of it.

        That is all, or something of the same sign that is at least ``spare``.
        """
        low, high = self.v.plus(self.rest, gain).ends
        ways = gain * self.through * self.reach[0], gain * self.through * self.reach[1]
        low, high = low + np.minimum(*ways), high + np.maximum(*ways)
        least, most = drift.ends
        low = np.minimum(low, self.known[0] + gain * spare) + least - COARSE
        high = np.maximum(high, self.known[1] - gain * spare) + most + COARSE
        return np.where(gain > 0, low, -np.inf), np.where(gain > 0, high, np.inf)


class ForceLimits:
    """The guard of a setup, which has to pass all, and its wheels' limit, which may act."""

    def __init__(self, setup: Setup) -> None:
        """NoCorridorError for another order than thrust first, and without a limit of torque."""
        scenario, robot = setup.scenario, setup.scenario.robot
        if scenario.guard.enabled and scenario.guard.map != "linear-first":
            raise NoCorridorError(f"{FAR_START} is covered for guard.map linear-first alone")
        if not np.isfinite(setup.tau_max):
            raise NoCorridorError(f"{FAR_START} is covered with a limit of torque alone")
        asked, v = ca.SX.sym("asked", 2), ca.SX.sym("v", 2)
        phi = full_thrust(ca.SX(robot.r), ca.SX(setup.tau_max))
        alone = linear_first(ca.vertcat(asked[0], BEYOND), phi, ca.SX(robot.l))
        self.thrust = AffineGraph(asked[0], alone)
        self.wheels = ca.Function("wheels", [asked], [linear_first(asked, phi, ca.SX(robot.l))])
        guarded = [item for item in conditions(setup, asked, v) if "guard" in item.name]
        value = ca.vertcat(ca.SX(0, 1), *(item.value for item in guarded))
        slope = ca.evalf(ca.jacobian(value, ca.vertcat(asked, v)))
        self.guarded = np.asarray(slope, dtype=float).reshape(-1, 2 * COMMAND)
        self.passed = np.array([float(ca.evalf(item.most)) for item in guarded]) * (1 - COARSE)
        self.kink = np.array(scenario.limits.v_u2)

    def guard_acts(self, asked: AskedForce) -> NDArray[np.bool_]:
        """Which cells may break a condition with which the guard passes the force."""
        lost = (asked.through < 0).any(axis=1)
        for slope, most in zip(self.guarded, self.passed, strict=True):
            by = slope[:COMMAND] * asked.through
            value = asked.rest.times(slope[:COMMAND]).plus(asked.v, slope[COMMAND:])
            speed = slope[COMMAND:] + np.zeros_like(by)
            low, high = value.between(asked.v, speed, asked.known)
            low, high = low + by * self.kink, high - by * self.kink
            least, top = np.full_like(low, -np.inf), np.full_like(high, np.inf)
            for share in SHARES:
                left, right = value.plus(asked.wanted, share * by).between(
                    asked.v, speed, asked.known
                )
                least = np.maximum(least, left + (1 - share) * by * asked.reach[0])
                top = np.minimum(top, right + (1 - share) * by * asked.reach[1])
            size = np.maximum(-np.minimum(least, low), np.maximum(top, high))
            lost |= (by < 0).any(axis=1) | ~(size.sum(axis=1) + COARSE <= most)
        return np.asarray(lost)

    def sent(self, asked: AskedForce) -> tuple[Rows, Floats]:
        """Force within the wheels' reach; what is sure to be within it on each axis (C, 2)."""
        low, high = asked.span(self.kink)
        size = np.maximum(np.abs(low), np.abs(high))[:, 0]
        near = np.maximum(np.maximum(low, -high), 0.0)[:, 0]
        spare, most = self._reach(size) * (1 - COARSE), self._reach(near) * (1 + COARSE)
        force = asked.force
        thrust, room = self._by_thrust(force.of_axis(0))
        moment = _clipped(
            force.of_axis(1), room, (low[:, 1:], high[:, 1:]), (spare[:, 1:], most[:, 1:])
        )
        both = [thrust, moment]
        c, rows, error = (
            np.concatenate(parts, axis=1)
            for parts in zip(*((item.c, item.rows, item.error) for item in both), strict=True)
        )
        return Rows.of(c, with_errors(rows, error)), spare

    def _by_thrust(self, force: Rows) -> tuple[Rows, Rows]:
        """The thrust that is sent of one that is asked, and room for a moment beside it."""
        radius = (np.abs(force.rows).sum(axis=2) + force.error) * SUMS
        c, slope, error = linear(self.thrust(force.c, radius), radius)
        rows = slope * force.rows
        error = error + np.abs(slope[:, :, 0]) * force.error + COARSE * np.abs(rows).sum(axis=2)
        both = Rows(c, rows, error)
        return both.of_axis(0), both.of_axis(1)

    def _reach(self, thrust: Floats) -> Floats:
        """Largest force (C, 2) beside an asked thrust of such a size."""
        most = np.full_like(thrust, BEYOND)
        first = np.asarray(self.wheels(np.array([most, 0 * most])))[0]
        second = np.asarray(self.wheels(np.array([thrust, most])))[1]
        return np.stack([first, second], axis=1)


def _clipped(force: Rows, bound: Rows, span: Ends, between: Ends) -> Rows:
    """A force within its ends ``span``, cut off at +- a bound within ``between``.

    That is F - max(F - b, 0) + max(-F - b, 0); between the ends of D max(D, 0) is a share of D and
    what the share leaves at the ends, at least 0.
    """
    cut = force
    for sign in (1.0, -1.0):
        over = force.times(np.full_like(force.c, sign)).plus(bound, -1.0)
        least, top = over.ends
        ends = span if sign > 0 else (-span[1], -span[0])
        rounding = COARSE * (np.abs(ends[0]) + np.abs(ends[1]) + between[1])
        least = np.maximum(least, ends[0] - between[1] - rounding)
        top = np.minimum(top, ends[1] - between[0] + rounding)
        apart = np.where(top > least, top - least, 1.0)
        share = np.where(least >= 0, 1.0, np.where(top <= 0, 0.0, np.clip(top / apart, 0.0, 1.0)))
        left = np.maximum(np.maximum(-share * least, (1 - share) * top), 0.0) / 2
        cut = cut.plus(over, -sign * share)
        cut = Rows(cut.c - sign * left, cut.rows, cut.error + left * SUMS + rounding)
    return cut


def uncovered(certifier: Certifier) -> dict[str, bool]:
    """Properties of a loop, in words, with which no far start is covered; True where it has one."""
    loop, inputs, setup = certifier.loop, certifier.inputs, certifier.loop.setup
    return {
        "a base that takes velocities": setup.takes_velocity,
        "a law that predicts": setup.predicted > 0,
        "jitter of the drives": loop.overlap.steps > 0 and not setup.takes_velocity,
        "a delay of drives or commands": loop.queue > 1 or loop.late > 0,
        "a lag of the drives": len(loop.names) > ROBOT and not setup.takes_velocity,
        "poses that are corrected in part": loop.filter > 0,
        "poses that are rare or lost": inputs.missing > 0,
        "errors of measurements": inputs.pose > 0 or bool(inputs.velocity.any()),
    }
