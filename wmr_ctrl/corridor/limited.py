"""A sample of the loop with all that limits it, over cells of states.

A cell is a zonotope

    x = c + G xi,     |xi_k| <= 1,     a column a wheel and sample for the pushes,

with velocities between ``low`` and ``high``.  It goes through the law around its barrier, the
barrier's proximal map, the wheels' limit and the plant's steps, all of which may act; a cell of
which the guard might change the force is given up (ledger: corridor.transient).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from wmr_ctrl.barrier.proximal import resolvent
from wmr_ctrl.checks.loop import Loop
from wmr_ctrl.checks.world import COMMAND, ROBOT, Floats
from wmr_ctrl.control.setup import Setup
from wmr_ctrl.corridor.affine import ROUNDING, SUMS, AffineGraph, Form, OverBoxes, number
from wmr_ctrl.corridor.certificate import Certifier
from wmr_ctrl.corridor.inputs import Inputs, NoCorridorError
from wmr_ctrl.corridor.limits import FAR_START, AskedForce, ForceLimits, uncovered
from wmr_ctrl.corridor.peaks import reference_gap
from wmr_ctrl.corridor.zonotopes import (
    COARSE,
    Ends,
    Rows,
    alike,
    linear,
    radius_of,
    reduced,
    with_errors,
)
from wmr_ctrl.laws.prox import ProxGains

PARTS = 32
"""Pieces of an interval on which the proximal map is evaluated."""
OTHERS = (120, 240)
"""Columns beside those of the pushes that are kept when there are more than so many."""
FRESH = 0.7
"""Share of a velocity's half-width below which its interval takes the place of its row."""
NARROW = 1e-9
"""Of the loop's scale, what is added to a rest before it is used as a start."""
V = slice(ROBOT - COMMAND, ROBOT)
"""Velocities in the state."""


@dataclass(frozen=True)
class StartCells:
    """C cells: ``c`` (C, n), ``G`` (C, n, columns), and the places of their ``begin`` (C).

    ``pushes``: number of leading columns that belong to pushes, in their order.  ``low``, ``high``
    (C, 2): what else is known of the velocities.
    """

    c: Floats
    G: Floats
    pushes: int
    low: Floats
    high: Floats
    begin: NDArray[np.int_]

    @property
    def radius(self) -> Floats:
        """Half-widths of the boxes around the cells (C, n)."""
        return radius_of(self.G)

    @property
    def velocities(self) -> Ends:
        """Ends of the velocities, from the boxes and from what else is known of them."""
        radius = self.radius[:, V]
        low, high = self.c[:, V] - radius, self.c[:, V] + radius
        return np.maximum(low, self.low), np.minimum(high, self.high)

    def only(self, which: NDArray[np.bool_] | NDArray[np.int_]) -> StartCells:
        """Some of them."""
        c, G, low, high = (item[which] for item in (self.c, self.G, self.low, self.high))
        return StartCells(c, G, self.pushes, low, high, self.begin[which])

    def joined(self, others: Sequence[StartCells]) -> StartCells:
        """With others behind, of no pushes all of them, and places anew."""
        every = [self, *others]
        c, low, high = (
            np.concatenate([getattr(item, name) for item in every]) for name in ("c", "low", "high")
        )
        G = np.concatenate(alike([item.G for item in every]))
        return StartCells(c, G, 0, low, high, np.arange(len(c)))

    def halves(self, row: int) -> StartCells:
        """Of one cell, cut across an element of the state: each half is a cell of no pushes.

        With l any vector, x_row = d + w s and |s| <= 1: x = c + l (d - c_row) + (G - l G_row) xi +
        l w s, as adding and taking away l x_row does nothing.
        """
        c, G, g = self.c[0], self.G[0], self.G[0, row]
        away = G @ g / max(float(g @ g), np.finfo(float).tiny)
        half = float(np.abs(g).sum() * SUMS + COARSE * abs(c[row]))
        low, high = c[row] - half, c[row] + half
        ends = self.low.repeat(2, axis=0), self.high.repeat(2, axis=0)
        if row in range(V.start, V.stop):
            low, high = (x[0, row - V.start] for x in self.velocities)
            ends[0][1, row - V.start] = ends[1][0, row - V.start] = (low + high) / 2
        w = (high - low) / 4 * (1 + COARSE) + COARSE * abs(low + high)
        middles = np.array([(3 * low + high) / 4, (low + 3 * high) / 4])
        lost = (
            np.abs(c) + np.abs(G).sum(axis=1) + np.abs(away) * (np.abs(g).sum() + abs(high - low))
        )
        more = with_errors((G - np.outer(away, g))[None], COARSE * lost[None])
        whole = np.concatenate([more, (away * w)[None, :, None]], axis=2).repeat(2, axis=0)
        moved = c + away * (middles - c[row])[:, None]
        return StartCells(moved, whole, 0, *ends, np.arange(2))

    def with_push(self) -> StartCells:
        """With two more columns behind those of the pushes, still empty."""
        own, others = self.G[:, :, : self.pushes], self.G[:, :, self.pushes :]
        room = np.zeros((*self.G.shape[:2], COMMAND))
        return replace(self, G=np.concatenate([own, room, others], axis=2))


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
            raise NoCorridorError(f"{FAR_START} is covered for prox as shipped alone")
        more = [words for words, there in uncovered(certifier).items() if there]
        if more:
            raise NoCorridorError(f"{FAR_START} is not covered with {', '.join(more)}")
        self.n = len(loop.at)
        self._compose_law(setup)
        self.limits = ForceLimits(setup)
        self.steps = OverBoxes(ROBOT + 2 * COMMAND, self._stepped)

    def _stepped(self, given: list[Form]) -> list[Form]:
        """State after each plant step of a sample, by that before it, force and push."""
        loop, columns = self.loop, len(given)
        gap = reference_gap(loop.step.at[V], loop.setup.scenario.clock.plant)
        step, z, course = AffineGraph(loop.step.by, loop.step.output), given[:ROBOT], list[Form]()
        fixed = [*given[ROBOT:], *(number(x, columns) for x in loop.step.at[-COMMAND:])]
        for _ in range(loop.steps):
            z = step.rule([*z, *fixed])
            z[:2] = [replace(item, r=item.r + gap) for item in z[:2]]
            course += z
        return course

    def _compose_law(self, setup: Setup) -> None:
        loop, scenario = self.loop, setup.scenario
        assert setup.control_law.in_parts is not None
        parted = Loop(
            replace(setup, law=replace(setup.control_law, build=setup.control_law.in_parts))
        )
        state, reached = ca.SX.sym("state", self.n), ca.SX.sym("reached", 2)
        memory = ca.vertcat(state[ROBOT + COMMAND * loop.queue :], ca.SX.zeros(4), reached)
        sent = state[ROBOT : ROBOT + COMMAND * loop.queue]
        numbers = ca.DM(parted.parameters(scenario.clock.control))
        v_d = ca.DM(loop.step.at[V])
        force, after = parted.act(state[:ROBOT], v_d, ca.DM.zeros(2), memory, sent, numbers)
        size = loop.memory
        self.wanted = AffineGraph(state, after[size : size + 2])
        self.asked = AffineGraph(ca.vertcat(state, reached), ca.vertcat(force, after[:size]))
        weight = ca.evalf(ca.substitute(after[size + 2 : size + 4], state, ca.DM(loop.at)))
        limits = scenario.limits
        x, u1, u2 = ca.SX.sym("x"), ca.SX(ca.DM(limits.v_u1)), ca.SX(ca.DM(limits.v_u2))
        self.maps = [AffineGraph(x, resolvent(x, ca.SX(weight[i]), u1[i], u2[i])) for i in (0, 1)]
        self.largest = np.array(limits.v_u1)

    def start(self, middle: Floats, width: Floats) -> StartCells:
        """Cells of starts (C, 3) off the reference by ``middle``, give or take ``width``."""
        c, G = np.tile(self.loop.at, (len(middle), 1)), np.zeros((len(middle), self.n, 3))
        c[:, :3] += middle
        G[:, [0, 1, 2], [0, 1, 2]] = width
        most = np.full((len(c), COMMAND), np.inf)
        return StartCells(c, G, 0, -most, most, np.arange(len(c)))

    def after(self, cells: StartCells, inputs: Inputs) -> tuple[StartCells, Floats, Floats]:
        """The cells a sample later; largest distance [m] and |e3| [rad] within it (C).

        A cell of which the guard might change the force comes back as not a number.
        """
        known, n = cells.velocities, self.n
        cells = cells.with_push()
        c, G = cells.c, cells.G
        middle, slope, error = _linear(self.wanted, c, radius_of(G))
        v, wanted = Rows.of(c[:, V], G[:, V]), Rows(middle, slope @ G, error)
        reached, reach = self._mapped(wanted, wanted.between(v, _own(slope, V.start), known))
        joined = with_errors(np.concatenate([G, reached.rows], axis=1), reached.error, n)
        middle, slope, error = _linear(self.asked, np.hstack([c, reached.c]), radius_of(joined))
        joined, given = alike([joined, with_errors(slope @ joined, error)])
        force = Rows.of(middle[:, :COMMAND], given[:, :COMMAND])
        through = _own(slope, n)
        rest = force.plus(Rows.of(reached.c, joined[:, n:]), -through)
        v = Rows.of(c[:, V], joined[:, V])
        asked = AskedForce(force, rest, through, wanted, reach, v, _own(slope, V.start), known)
        memory = middle[:, COMMAND:], given[:, COMMAND:]
        after, far, turned = self._moved(cells, joined, asked, memory, inputs)
        after.c[self.limits.guard_acts(asked)] = np.nan
        return after, far, turned

    def _mapped(self, wanted: Rows, ends: Ends) -> tuple[Rows, Ends]:
        """The proximal map of what is wanted, as rows and by its ends."""
        shown, slopes, errors, reach = [], [], [], []
        for i, graph in enumerate(self.maps):
            slope, least, most, at = _secant_of(graph, ends[0][:, i], ends[1][:, i])
            shown.append(slope * wanted.c[:, i] + (least + most) / 2)
            slopes.append(slope)
            errors.append((most - least) / 2 + slope * wanted.error[:, i] + COARSE)
            reach.append(at)
        rows = np.stack(slopes, 1)[:, :, None] * wanted.rows
        low, high = (np.stack([item[k] for item in reach], axis=1) for k in (0, 1))
        return Rows(np.stack(shown, 1), rows, np.stack(errors, 1)), (low, high)

    def _moved(
        self,
        cells: StartCells,
        joined: Floats,
        asked: AskedForce,
        memory: tuple[Floats, Floats],
        inputs: Inputs,
    ) -> tuple[StartCells, Floats, Floats]:
        """The plant's steps of a sample, and what is known of the velocities after it."""
        count, pushes = len(cells.c), cells.pushes
        sent, spare = self.limits.sent(asked)
        joined, acts = alike([joined, sent.rows])
        d = np.zeros_like(acts)
        d[:, [0, 1], [pushes, pushes + 1]] = inputs.push
        held = np.concatenate([joined[:, :ROBOT], acts, d], axis=1)
        middle = np.hstack([cells.c[:, :ROBOT], sent.c, np.zeros((count, COMMAND))])
        radius = radius_of(held)
        forms = self.steps(middle, radius)
        size = np.hstack(
            [np.abs(middle[:, :ROBOT]) + radius[:, :ROBOT], np.abs(forms.c) + forms.radius]
        )
        course = size.reshape(count, -1, ROBOT)
        far, heading = np.hypot(*course.T[:2]).max(axis=0), course[:, :, 2].max(axis=1)
        shown, slope, error = (item[:, -ROBOT:] for item in linear(forms, radius))
        moved, gain = with_errors(slope @ held, error), _own(slope[:, V], ROBOT)
        now = Rows.of(shown[:, V], moved[:, V])
        base = now.plus(sent, -gain)
        low, high = asked.moved(gain, base.plus(asked.v, -1.0), spare)
        now, sent = _refreshed(now, sent, base, gain, (low, high))
        rows = alike([moved[:, : V.start], now.rows, sent.rows, memory[1]])
        G = np.concatenate(rows, axis=1)
        own, others = G[:, :, : pushes + COMMAND], G[:, :, pushes + COMMAND :]
        G = np.concatenate([own, reduced(others, self.scale, OTHERS)], axis=2)
        c = np.hstack([shown[:, : V.start], now.c, sent.c, memory[0]])
        after = StartCells(c, G, pushes + COMMAND, low, high, cells.begin)
        return after, far * SUMS, heading * SUMS

    @property
    def scale(self) -> Floats:
        """Sizes of the state's elements, none of them 0."""
        own = self.certifier.gains.scale
        return np.where(own > 0, own, own[own > 0].min())

    def rest(self, cells: StartCells, pushed: Floats) -> Floats:
        """Deviations (C, n, columns) less what pushes do in the linear loop (n, columns)."""
        G, more = cells.G.copy(), NARROW * np.diag(self.scale)
        G[:, :, : cells.pushes] -= pushed
        each = (cells.c - self.loop.at)[:, :, None], G, np.tile(more, (len(G), 1, 1))
        return np.concatenate(each, axis=2)


def _refreshed(now: Rows, sent: Rows, base: Rows, gain: Floats, ends: Ends) -> tuple[Rows, Rows]:
    """Velocities by their intervals where these are much narrower.

    The force that was sent is then (velocity - base)/gain, so that an observer still sees pushes.
    """
    half, middle = (ends[1] - ends[0]) / 2, (ends[1] + ends[0]) / 2
    fresh = (half < FRESH * np.abs(now.rows).sum(axis=2)) & (gain > 0)
    half, middle = np.where(fresh, half, 0.0), np.where(fresh, middle, 0.0)
    new = Rows.of(middle, with_errors(np.zeros_like(now.rows), half * SUMS + COARSE))
    force = new.plus(base, -1.0).times(1 / np.where(fresh, gain, 1.0))
    known = with_errors(force.rows, force.error)
    picked = []
    for old, c, rows in ((now, new.c, new.rows), (sent, force.c, known)):
        before, after = alike([old.rows, rows])
        shown = np.where(fresh[:, :, None], after, before)
        picked.append(Rows.of(np.where(fresh, c, old.c), shown))
    return picked[0], picked[1]


def _own(slope: Floats, first: int) -> Floats:
    """Slopes (C, 2) of two rows by two inputs, each by its own."""
    return np.stack([slope[:, i, first + i] for i in range(COMMAND)], axis=1)


def _linear(graph: AffineGraph, middle: Floats, radius: Floats) -> tuple[Floats, Floats, Floats]:
    """A graph over boxes."""
    return linear(graph(middle, radius), radius)


def _secant_of(
    graph: AffineGraph, low: Floats, high: Floats
) -> tuple[Floats, Floats, Floats, tuple[Floats, Floats]]:
    """Slope, ends of what is left, and ends, of a map that rises by 0 to 1 times its way.

    Between two points that are w apart it lies below the lines with slope 1 from the left one and 0
    from the right one, and above the contrary ones (ledger: prox.not-expansive).
    """
    at = low + (high - low) * np.linspace(0.0, 1.0, PARTS + 1)[:, None]
    at[-1] = high
    forms = graph(at.reshape(-1, 1), np.zeros((at.size, 1)))
    off = (forms.r + forms.size * ROUNDING).reshape(at.shape)
    value = forms.c.reshape(at.shape)
    apart = high - low
    slope = np.where(apart > 1e-9, (value[-1] - value[0]) / np.where(apart > 1e-9, apart, 1.0), 1.0)
    slope = np.clip(slope, 0.0, 1.0)
    left = value - slope * at
    w, gained = np.diff(at, axis=0), np.diff(left, axis=0)
    top = left[:-1] + (1 - slope) * np.clip(gained + slope * w, 0.0, w)
    low_end = left[:-1] - slope * np.clip((1 - slope) * w - gained, 0.0, w)
    most = np.maximum(top.max(axis=0), left.max(axis=0)) + off.max(axis=0) * 2 + COARSE
    least = np.minimum(low_end.min(axis=0), left.min(axis=0)) - off.max(axis=0) * 2 - COARSE
    return slope, least, most, (value[0] - off[0] - COARSE, value[-1] + off[-1] + COARSE)
