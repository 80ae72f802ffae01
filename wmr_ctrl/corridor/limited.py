"""A sample of the loop with all that limits it, over cells of states.

A cell is a zonotope

    x = c + G xi,     |xi_k| <= 1,     a column a wheel and sample for the pushes.

It goes through the law around its barrier, the barrier's proximal map, the guard, the wheels' limit
and the plant's steps, all of which may act (`wmr_ctrl.corridor.affine`).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from wmr_ctrl.barrier.proximal import resolvent
from wmr_ctrl.checks.loop import Loop
from wmr_ctrl.checks.world import COMMAND, ROBOT, Floats
from wmr_ctrl.control.controller import guard, wheel_limit
from wmr_ctrl.control.setup import Setup
from wmr_ctrl.corridor.affine import ROUNDING, SUMS, AffineGraph, Form, boxes, number
from wmr_ctrl.corridor.certificate import Certifier
from wmr_ctrl.corridor.inputs import Inputs, NoCorridorError
from wmr_ctrl.guard.guard import linear_first
from wmr_ctrl.laws.prox import ProxGains
from wmr_ctrl.model.dynamics import force_to_wheel, full_thrust, wheel_to_force
from wmr_ctrl.model.system import Parameters, stack, values

PARTS = 32
"""Pieces of an interval on which the proximal map is evaluated."""
OTHERS = (150, 400)
"""Columns beside those of the pushes that are kept when there are more than so many."""
COARSE = 1e-12
"""Share by which products of such matrices and their sums can err."""


@dataclass(frozen=True)
class StartCells:
    """C cells: ``c`` (C, n), ``G`` (C, n, columns) and the starts (C, 3) they hold, with widths.

    ``pushes``: number of leading columns that belong to pushes, in their order.
    """

    c: Floats
    G: Floats
    pushes: int
    middle: Floats
    width: Floats

    @property
    def radius(self) -> Floats:
        """Half-widths of the boxes around the cells (C, n)."""
        return np.asarray(np.abs(self.G).sum(axis=2) * SUMS)

    def only(self, which: NDArray[np.bool_] | NDArray[np.int_]) -> StartCells:
        """Some of them."""
        parts = (item[which] for item in (self.c, self.G, self.middle, self.width))
        c, G, middle, width = parts
        return StartCells(c, G, self.pushes, middle, width)


class LimitedLoop:
    """A sample of a law's loop on its reference with all that limits it, over cells."""

    def __init__(self, certifier: Certifier) -> None:
        """NoCorridorError for a loop of which this is not known."""
        self.certifier, self.loop = certifier, certifier.loop
        loop, setup = self.loop, self.loop.setup
        own = setup.gains
        plain = (
            isinstance(own, ProxGains) and own.transport == "two-part" and own.barrier != "smooth"
        )
        if setup.control_law.in_parts is None or not plain:
            raise NoCorridorError("a start so far off is covered for prox as shipped alone")
        inputs = certifier.inputs
        if (
            setup.predicted
            or loop.filter
            or loop.acting
            or loop.queue > 1
            or loop.late
            or len(loop.names) > ROBOT
        ):
            raise NoCorridorError("a start so far off is not covered with delay, lag or filter")
        if inputs.pose or inputs.velocity.any():
            raise NoCorridorError("a start so far off is not covered with errors of measurements")
        self.n = len(loop.at)
        self._compose(setup)
        by, after = loop.step.by, loop.step.output
        self.step = AffineGraph(by, after)

    def _compose(self, setup: Setup) -> None:
        loop, scenario, robot = self.loop, setup.scenario, setup.scenario.robot
        assert setup.control_law.in_parts is not None
        parted = Loop(
            replace(setup, law=replace(setup.control_law, build=setup.control_law.in_parts))
        )
        state, reached = ca.SX.sym("state", self.n), ca.SX.sym("reached", 2)
        memory = ca.vertcat(state[ROBOT + COMMAND * loop.queue :], ca.SX.zeros(4), reached)
        sent = state[ROBOT : ROBOT + COMMAND * loop.queue]
        numbers = ca.DM(parted.parameters(scenario.clock.control))
        v_d = ca.DM(loop.step.at[3:ROBOT])
        force, after = parted.act(state[:ROBOT], v_d, ca.DM.zeros(2), memory, sent, numbers)
        size = loop.memory
        self.wanted = AffineGraph(state, after[size : size + 2])
        self.asked = AffineGraph(ca.vertcat(state, reached), ca.vertcat(force, after[:size]))
        weight = ca.evalf(ca.substitute(after[size + 2 : size + 4], state, ca.DM(loop.at)))
        limits = scenario.limits
        x, u1, u2 = ca.SX.sym("x"), ca.SX(ca.DM(limits.v_u1)), ca.SX(ca.DM(limits.v_u2))
        self.maps = [AffineGraph(x, resolvent(x, ca.SX(weight[i]), u1[i], u2[i])) for i in (0, 1)]
        self.largest = np.array(limits.v_u1)
        asked, v = ca.SX.sym("asked", 2), ca.SX.sym("v", 2)
        torque = _guard(setup, asked, v)
        force = wheel_to_force(ca.SX(robot.r), ca.SX(robot.l), torque)
        self.sent = AffineGraph(ca.vertcat(asked, v), force)

    def start(self, middle: Floats, width: Floats) -> StartCells:
        """Cells of starts (C, 3) off the reference by ``middle``, give or take ``width``."""
        c = np.tile(self.loop.at, (len(middle), 1))
        c[:, :3] += middle
        G = np.zeros((len(middle), self.n, 3))
        for k in range(3):
            G[:, k, k] = width[:, k]
        return StartCells(c, G, 0, middle, width)

    def after(self, cells: StartCells, inputs: Inputs) -> tuple[StartCells, Floats, Floats]:
        """The cells a sample later; largest distance [m] and |e3| [rad] within it (C)."""
        c, G, n = cells.c, cells.G, self.n
        G = np.concatenate([np.zeros((len(c), n, COMMAND)), G], axis=2)
        before, push = cells.pushes + COMMAND, np.arange(COMMAND)
        G = np.concatenate([G[:, :, COMMAND:before], G[:, :, push], G[:, :, before:]], axis=2)
        middle, slope, error = _linear(self.wanted, c, np.abs(G).sum(axis=2) * SUMS)
        reached, of, off = self._mapped(middle, slope @ G, error)
        both, joined = np.hstack([c, reached]), np.concatenate([G, of], axis=1)
        joined = _with_errors(joined, off, n)
        middle, slope, error = _linear(self.asked, both, np.abs(joined).sum(axis=2) * SUMS)
        given = _with_errors(slope @ joined, error, 0)
        joined = _widened(joined, given.shape[2])
        pair = np.hstack([middle[:, :COMMAND], c[:, 3:ROBOT]])
        way = np.concatenate([given[:, :COMMAND], joined[:, 3:ROBOT]], axis=1)
        force, slope, error = _linear(self.sent, pair, np.abs(way).sum(axis=2) * SUMS)
        acts = _with_errors(slope @ way, error, 0)
        given, joined = (_widened(item, acts.shape[2]) for item in (given, joined))
        return self._moved(cells, (c, joined), (force, acts), (middle[:, 2:], given[:, 2:]), inputs)

    def _mapped(self, middle: Floats, G: Floats, error: Floats) -> tuple[Floats, Floats, Floats]:
        """What the proximal map makes of what it is given."""
        radius = (np.abs(G).sum(axis=2) + error) * SUMS
        shown, slopes, errors = [], [], []
        for i, graph in enumerate(self.maps):
            slope, least, most = _secant_of(
                graph, middle[:, i] - radius[:, i], middle[:, i] + radius[:, i]
            )
            shown.append(slope * middle[:, i] + (least + most) / 2)
            slopes.append(slope)
            errors.append((most - least) / 2 + slope * error[:, i] + COARSE)
        return np.stack(shown, 1), np.stack(slopes, 1)[:, :, None] * G, np.stack(errors, 1)

    def _moved(
        self,
        cells: StartCells,
        at: tuple[Floats, Floats],
        force: tuple[Floats, Floats],
        memory: tuple[Floats, Floats],
        inputs: Inputs,
    ) -> tuple[StartCells, Floats, Floats]:
        """The plant's steps of a sample."""
        (c, G), (u, acts) = at, force
        count, pushes = len(c), cells.pushes
        d = np.zeros((count, COMMAND, G.shape[2]))
        for i in (0, 1):
            d[:, i, pushes + i] = inputs.push[i]
        held = np.concatenate([G[:, :ROBOT], acts, d], axis=1)
        middle = np.hstack([c[:, :ROBOT], u, np.zeros((count, COMMAND))])
        radius = np.abs(held).sum(axis=2) * SUMS
        m, steps = 2 * COMMAND + ROBOT, self.loop.steps
        forms = boxes(middle, radius, m + steps * (self.step.columns + ROBOT))
        z, fixed, free = forms[:ROBOT], forms[ROBOT:], m
        fixed += [number(x, count) for x in self.loop.step.at[-COMMAND:]]
        far, turned = _farthest(z), z[2]
        heading = np.abs(turned.c) + turned.radius
        for _ in range(steps):
            z, free = self.step([*z, *fixed], free)
            far = np.maximum(far, _farthest(z))
            heading = np.maximum(heading, np.abs(z[2].c) + z[2].radius)
        shown, slope, error = _taken(z, radius)
        moved = _with_errors(slope @ held, error, 0)
        new = np.concatenate(
            [moved, *(_widened(item, moved.shape[2]) for item in (acts, memory[1]))], axis=1
        )
        after = StartCells(
            np.hstack([shown, u, memory[0]]), new, pushes + COMMAND, cells.middle, cells.width
        )
        return self._reduced(after), far * SUMS, heading * SUMS

    def _reduced(self, cells: StartCells) -> StartCells:
        """With as few columns as are kept: the smallest become a box."""
        own, others = cells.G[:, :, : cells.pushes], cells.G[:, :, cells.pushes :]
        others = others[:, :, (others != 0).any(axis=(0, 1))]
        if others.shape[2] > OTHERS[1]:
            scale = self.certifier.gains.scale[:, None]
            size = (np.abs(others) / scale).max(axis=1).mean(axis=0)
            order = np.argsort(-size)
            first, left = order[: OTHERS[0]], order[OTHERS[0] :]
            box = _box_of(others[:, :, left] / scale) * scale
            others = np.concatenate([others[:, :, first], box], axis=2)
        return replace(cells, G=np.concatenate([own, others], axis=2))

    def rest(self, cells: StartCells, pushed: Floats) -> Floats:
        """Deviations (C, n, columns) less what pushes do in the linear loop (n, columns)."""
        G = cells.G.copy()
        G[:, :, : cells.pushes] -= pushed
        return np.concatenate([(cells.c - self.loop.at)[:, :, None], G], axis=2)


def _guard(setup: Setup, asked: ca.SX, v: ca.SX) -> ca.SX:
    """Wheel torques (2,) of an asked force, behind guard and wheels' limit."""
    if setup.scenario.guard.enabled:
        system = guard(setup)
        given = (ca.vertcat(asked, v), ca.DM(system.x0), ca.DM(system.p0))
        return system.function("torque", [system.y])(*given)
    p = Parameters(setup)
    r, half_track = p.take("robot.r"), p.take("robot.l")
    force = linear_first(asked, full_thrust(r, wheel_limit(setup, p)), half_track)
    torque = force_to_wheel(r, half_track, force)
    own = stack(item.sym for item in p.ports)
    return ca.substitute(torque, own, ca.SX(ca.DM(values(p.ports))))


def _linear(graph: AffineGraph, middle: Floats, radius: Floats) -> tuple[Floats, Floats, Floats]:
    """A graph over boxes: its middle (C, out), slopes (C, out, in) and errors (C, out)."""
    forms = boxes(middle, radius, graph.inputs + graph.columns)
    return _taken(graph(forms, graph.inputs)[0], radius)


def _taken(forms: list[Form], radius: Floats) -> tuple[Floats, Floats, Floats]:
    """Forms of columns that begin with inputs of some radius, as middle, slopes and errors."""
    count, n = radius.shape
    c, slope, error = [], [], []
    for form in forms:
        L = np.zeros((count, n)) if form.L is None else form.L[:, :n]
        more = 0.0 if form.L is None else np.abs(form.L[:, n:]).sum(axis=1)
        c.append(form.c)
        slope.append(np.where(radius > 0, L / np.where(radius > 0, radius, 1.0), 0.0))
        error.append((form.r + more) * SUMS + form.size * COARSE)
    return np.stack(c, 1), np.stack(slope, 1), np.stack(error, 1)


def _farthest(z: list[Form]) -> Floats:
    return np.asarray(np.hypot(*(np.abs(item.c) + item.radius for item in z[:2])) * SUMS)


def _with_errors(G: Floats, error: Floats, first: int) -> Floats:
    """Columns with one more for each error, in the rows from ``first`` on."""
    more = np.zeros((len(G), G.shape[1], error.shape[1]))
    for k in range(error.shape[1]):
        more[:, first + k, k] = error[:, k]
    return np.concatenate([G, more], axis=2)


def _box_of(G: Floats) -> Floats:
    """Columns (C, n, n) of boxes, along the principal axes, that hold zonotopes (C, n, columns)."""
    axes = np.linalg.svd(G, full_matrices=True)[0]
    size = np.abs(axes.transpose(0, 2, 1) @ G).sum(axis=2)
    size = size * SUMS + size.max(axis=1, keepdims=True) * COARSE
    return np.asarray(axes * size[:, None, :])


def _widened(G: Floats, columns: int) -> Floats:
    return np.concatenate([G, np.zeros((*G.shape[:2], columns - G.shape[2]))], axis=2)


def _secant_of(graph: AffineGraph, low: Floats, high: Floats) -> tuple[Floats, Floats, Floats]:
    """Slope, and ends of what is left, of a map that rises by 0 to 1 times its way, on intervals.

    Between two points that are w apart it lies below the lines with slope 1 from the left one and 0
    from the right one, and above the contrary ones (ledger: prox.nonexpansive).
    """
    at = low + (high - low) * np.linspace(0.0, 1.0, PARTS + 1)[:, None]
    at[-1] = high
    flat = at.ravel()
    still = np.zeros_like(flat)
    form = graph([Form(flat, None, still, np.abs(flat))], 0)[0][0]
    off = (form.r + form.size * ROUNDING).reshape(at.shape)
    value = form.c.reshape(at.shape)
    apart = high - low
    slope = np.where(apart > 1e-9, (value[-1] - value[0]) / np.where(apart > 1e-9, apart, 1.0), 1.0)
    slope = np.clip(slope, 0.0, 1.0)
    left = value - slope * at
    w, gained = np.diff(at, axis=0), np.diff(left, axis=0)
    top = left[:-1] + (1 - slope) * np.clip(gained + slope * w, 0.0, w)
    low_end = left[:-1] - slope * np.clip((1 - slope) * w - gained, 0.0, w)
    most = np.maximum(top.max(axis=0), left.max(axis=0)) + off.max(axis=0) * 2 + COARSE
    least = np.minimum(low_end.min(axis=0), left.min(axis=0)) - off.max(axis=0) * 2 - COARSE
    return slope, least, most
