"""The robot behind its drives and sensors from one control sample to the next: linear, and exact.

Between two samples the motion is that of a held force that changes once, where a delay ends within
the period; matrix exponentials over the pieces give it without approximation.  Delay, age and
window may be any multiple or fraction of the period.  What the drives have not yet passed on and
the sensors not yet shown is part of the state.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from itertools import pairwise

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from wmr_ctrl.checks.lateness import Lateness
from wmr_ctrl.model.dynamics import acceleration, friction, reduced_mass
from wmr_ctrl.model.tracking import error_rate
from wmr_ctrl.scenario import Robot

Floats = NDArray[np.float64]

GRID = 1e-9
"""Share of a period within which an instant counts as one of its ends."""
VELOCITIES = slice(3, 5)
"""Where v1 and omega stand behind the tracking error."""


@dataclass(frozen=True)
class SampledPlant:
    """x_next = moved x + forced u + pushed d for the command u and a disturbance d [N, N m].

    ``measured`` x is tracking error and velocity as the sensors show them (5), ``applied`` x the
    mean force of the period that has ended, behind delay and lag (2), ``sent`` x the commands that
    are remembered, the latest first.  The first elements of x are those of the robot; ``names`` has
    one for each element behind them.
    """

    moved: Floats
    forced: Floats
    pushed: Floats
    measured: Floats
    applied: Floats
    sent: Floats
    names: tuple[str, ...]


def sampled_plant(
    rates: Floats,
    push: Floats,
    period: float,
    late: Lateness,
    *,
    mean: bool = False,
    remembered: int = 0,
) -> SampledPlant:
    """The plant s' = rates s + push F, sampled every ``period`` [s] with a command held.

    ``applied`` has rows only with ``mean``, ``sent`` two for each command ``remembered``.  Both are
    what the law takes for them: where a part of the delay is untold, those of other drives.
    """
    if late.untold == 0 or not (mean or remembered):
        return _Assembly(rates, push, period, late, mean=mean, remembered=remembered).plant
    behind = _Assembly(rates, push, period, late, mean=False, remembered=0).plant
    return _beside(behind, drives(period, late, remembered), mean)


def drives(period: float, late: Lateness, remembered: int = 0) -> SampledPlant:
    """The drives alone: commands to the mean force that acted, as the observer knows them."""
    nothing, push = np.zeros((0, 0)), np.zeros((0, 2))
    return _Assembly(nothing, push, period, late.told, mean=True, remembered=remembered).plant


def _beside(plant: SampledPlant, believed: SampledPlant, mean: bool) -> SampledPlant:
    """The plant, and drives that get the same commands and tell what was applied and sent."""
    n, more = len(plant.moved), len(believed.moved)
    moved = np.zeros((n + more, n + more))
    moved[:n, :n], moved[n:, n:] = plant.moved, believed.moved
    applied = believed.applied if mean else believed.applied[:0]
    return SampledPlant(
        moved,
        np.vstack((plant.forced, believed.forced)),
        np.vstack((plant.pushed, believed.pushed)),
        np.hstack((plant.measured, np.zeros((len(plant.measured), more)))),
        np.hstack((np.zeros((len(applied), n)), applied)),
        np.hstack((np.zeros((len(believed.sent), n)), believed.sent)),
        (*plant.names, *(f"believed.{name}" for name in believed.names)),
    )


@dataclass(frozen=True)
class _Look:
    """One number a period that a sensor goes back to: v of ``axis`` at ``until`` [s] from the
    period's start, or its integral since ``since`` where that is given.
    """

    axis: int
    until: float
    since: float | None = None


class _Assembly:
    """Rows of a SampledPlant, block by block; a row of ``flow`` tells what a value depends on."""

    def __init__(
        self,
        rates: Floats,
        push: Floats,
        period: float,
        late: Lateness,
        *,
        mean: bool,
        remembered: int,
    ) -> None:
        self.period, self.late, self.mean = period, late, 2 * mean
        self.robot, self.lag = len(rates), 2 * (late.lag > 0)
        self.whole, self.part = _divided(late.delay, period)
        self.asked = 2 * remembered
        self.sent = max(self.whole + (self.part > 0), remembered)
        self.looks = [(look, back, weight) for axis in (0, 1) if self.robot
                      for look, back, weight in _looks(axis, late, period)]  # fmt: skip
        self.depth: dict[_Look, int] = {}
        for look, back, _ in self.looks:
            self.depth[look] = max(back, self.depth.get(look, 0))
        self.flow = self._flow(*self._continuous(rates, push))
        self.plant = self._assembled()

    def _continuous(self, rates: Floats, push: Floats) -> tuple[Floats, Floats]:
        """Gradients of robot, lag, integral of the force, way and turn; by command, disturbance."""
        n, at = self.robot, self.robot + self.lag
        a, b = np.zeros((at + 4, at + 4)), np.zeros((at + 4, 4))
        a[:n, :n], b[:n, 2:] = rates, push
        if self.lag:
            a[:n, n:at], a[at : at + 2, n:at] = push, np.eye(2)
            a[n:at, n:at], b[n:at, :2] = -np.eye(2) / self.late.lag, np.eye(2) / self.late.lag
        else:
            b[:n, :2], b[at : at + 2, :2] = push, np.eye(2)
        if n:
            a[at + 2 :, VELOCITIES] = np.eye(2)
        return a, b

    def _flow(self, a: Floats, b: Floats) -> dict[float, Floats]:
        """By instant of the period: all of the above, from what stood at the period's start.

        Columns: robot and lag, the command that acts first (2), the one that takes over (2), the
        disturbance (2).
        """
        at = self.robot + self.lag
        instants = {0.0, self.part, self.period, *(t for look in self.depth for t in _times(look))}
        values = np.eye(len(a), at + 6)
        values[at:] = 0.0
        flow, cuts = {0.0: values}, sorted(instants)
        for start, end in pairwise(cuts):
            free, forced = zero_order_hold(a, b, end - start)
            acting = np.zeros((4, at + 6))
            first = at + (0 if end <= self.part else 2)
            acting[:2, first : first + 2] = acting[2:, at + 4 :] = np.eye(2)
            values = free @ values + forced @ acting
            flow[end] = values
        return flow

    def _assembled(self) -> SampledPlant:
        n, at = self.robot, self.robot + self.lag
        queue = at + self.mean
        shown = queue + 2 * self.sent
        size = shown + sum(self.depth.values())
        moved, forced, pushed = np.zeros((size, size)), np.zeros((size, 2)), np.zeros((size, 2))

        def put(row: slice, flow: Floats) -> None:
            """Rows that depend on the period's start, on two commands and on the disturbance."""
            moved[row, :at] = flow[:, :at]
            pushed[row] = flow[:, at + 4 :]
            for age, first in ((self.whole + 1, at), (self.whole, at + 2)):
                columns = slice(first, first + 2)
                if 0 < age <= self.sent:
                    moved[row, queue + 2 * age - 2 : queue + 2 * age] += flow[:, columns]
                elif age == 0:
                    forced[row] += flow[:, columns]

        end = self.flow[self.period]
        put(slice(0, at), end[:at])
        put(slice(at, queue), end[at : at + self.mean] / self.period)
        if self.sent:
            forced[queue : queue + 2] = np.eye(2)
            moved[queue + 2 : shown, queue : shown - 2] = np.eye(2 * self.sent - 2)
        measured, place = np.eye(n, size), {}
        for look, depth in self.depth.items():
            place[look] = shown
            put(slice(shown, shown + 1), self._seen(look))
            moved[shown + 1 : shown + depth, shown : shown + depth - 1] = np.eye(depth - 1)
            shown += depth
        for axis in {look.axis for look in self.depth}:
            measured[3 + axis] = 0.0
        for look, back, weight in self.looks:
            measured[3 + look.axis, place[look] + back - 1] += weight
        return SampledPlant(
            moved, forced, pushed, measured, np.eye(self.mean, size, at),
            np.eye(self.asked, size, queue), tuple(self._names()),
        )  # fmt: skip

    def _seen(self, look: _Look) -> Floats:
        """What is remembered of a period, as a row of its flow."""
        way = self.robot + self.lag + 2 + look.axis
        if look.since is None:
            return self.flow[look.until][3 + look.axis : 4 + look.axis]
        return (self.flow[look.until] - self.flow[look.since])[way : way + 1]

    def _names(self) -> Iterator[str]:
        pair = (1, 2)
        yield from (f"force_applied[{i}]" for i in pair[: self.lag])
        yield from (f"force_mean[{i}]" for i in pair[: self.mean])
        yield from (f"force_sent{age}[{i}]" for age in range(1, self.sent + 1) for i in pair)
        total = sum(self.depth.values())
        yield from (f"velocity_seen[{k}]" for k in range(1, total + 1))


def _times(look: _Look) -> tuple[float, ...]:
    return (look.until,) if look.since is None else (look.since, look.until)


def _looks(axis: int, late: Lateness, period: float) -> Iterator[tuple[_Look, int, float]]:
    """What the measured velocity of an axis is made of: a look, periods ago, and its weight."""
    age, window = late.age[axis], late.window[axis]
    if age + window == 0:
        return
    if window == 0:
        back, rest = _divided(age, period)
        back, rest = (back, rest) if rest else (back - 1, period)
        yield _Look(axis, period - rest if rest < period else 0.0), back + 1, 1.0
        return
    back, end = _divided(age, period)
    left = window
    while left > GRID * period:
        piece = min(left, period - end)
        until = period - end
        since = 0.0 if until - piece <= GRID * period else until - piece
        yield _Look(axis, until, since), back + 1, 1 / window
        back, end, left = back + 1, 0.0, left - piece


def _divided(value: float, period: float) -> tuple[int, float]:
    """Whole periods and the rest [s]; a rest next to none or to a period is none."""
    ratio = value / period
    whole = math.floor(ratio + GRID)
    rest = value - whole * period
    return whole, rest if rest > GRID * period else 0.0


def linear_plant(robot: Robot, v_d: tuple[float, ...]) -> tuple[Floats, Floats]:
    """Rates' gradients by (e, v) and by the acting force, on the reference at ``v_d``."""
    numbers = (robot.m, robot.I, robot.mu, robot.g, robot.v_s)
    rates, push = (np.asarray(item) for item in _plant_gradient()(numbers, v_d))
    return rates, push


@cache
def _plant_gradient() -> ca.Function:
    p, v_d = ca.SX.sym("robot", 5), ca.SX.sym("v_d", 2)
    (m, inertia, mu, g, v_s) = ca.vertsplit(p)
    s, force = ca.SX.sym("s", 5), ca.SX.sym("force", 2)
    speeding = acceleration(reduced_mass(m, inertia), force, friction(mu, m, g, v_s, s[3:]))
    rate = ca.vertcat(error_rate(s[:3], s[3:], v_d), speeding)
    at = ca.vertcat(ca.SX.zeros(3), v_d)
    gradients = [ca.substitute(ca.jacobian(rate, by), s, at) for by in (s, force)]
    return ca.Function("plant", [p, v_d], gradients)


def zero_order_hold(rates: Floats, push: Floats, period: float) -> tuple[Floats, Floats]:
    """Exact matrices of x(t + period) = free x + forced u for x' = rates x + push u, u held."""
    size, inputs = push.shape
    block = np.zeros((size + inputs, size + inputs))
    block[:size, :size], block[:size, size:] = rates, push
    whole = exponential(block * period)
    return whole[:size, :size], whole[:size, size:]


def exponential(matrix: Floats) -> Floats:
    """Matrix exponential by its series after halving the argument to a norm of at most 1/2."""
    norm = float(np.linalg.norm(matrix, 1))
    halvings = max(0, math.ceil(math.log2(norm)) + 1) if norm > 0 else 0
    scaled, term = matrix / 2.0**halvings, np.eye(len(matrix))
    total = term.copy()
    for order in range(1, 16):
        term = term @ scaled / order
        total += term
    for _ in range(halvings):
        total = total @ total
    return total
