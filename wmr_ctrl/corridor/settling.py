"""From states off the reference into the corridor, while nothing limits: a majorant sequence.

With p what the inputs do to the linear loop from now on, the state is p + r, and

    r+ = A r + what the linear parts leave of the graphs on the box |x| <= |r| + L,

L the largest deviations that the inputs can cause (ledger: corridor.frame).  r begins in a
zonotope, of which many are carried at once, and has no column for a push.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, pi

import numpy as np
from flint import arb_mat, ctx
from numpy.typing import NDArray

from wmr_ctrl.checks.world import COMMAND, ROBOT, Floats
from wmr_ctrl.corridor.certificate import Certifier
from wmr_ctrl.corridor.gains import DIRECTIONS, PAIRS, fast_rows
from wmr_ctrl.corridor.inputs import Inputs
from wmr_ctrl.corridor.loop import Curve
from wmr_ctrl.corridor.sample import SampleMatrices, doubles, powers_of
from wmr_ctrl.corridor.zonotopes import COARSE, SUMS, reduced

BITS = 1000
"""For powers of the loop's matrix."""
COLUMNS = (30, 60)
"""Columns that are kept when there are more than so many."""
ROUNDS, MORE = 12, 1.01
"""Rounds in which a sample's remainders are found, and by how much a guess exceeds the last one."""
ROOM, WIDE, FAINT = 1.03, 1.15, 1e-9
"""Factor by which a box of bends is wider than needed; factor and size up to which it is used."""
LOOK = 4
"""Of so many samples one is looked at for what breaks a condition in any case."""
SLOWEST = 0.65
"""Deviation of v1, as a share of v1_d, with which a cell is too near standstill."""


@dataclass(frozen=True)
class Bends:
    """Half the second derivatives of a graph's outputs (out, n, n), at most, within a box (n)."""

    sizes: Floats
    box: Floats

    @classmethod
    def of(cls, curve: Curve, box: Floats) -> Bends:
        """Of a curve, over deviations from its point."""
        products = np.outer(box, box)
        return cls(curve.remainders(products) / np.where(products > 0, products, 1.0) * SUMS, box)

    @classmethod
    def none(cls) -> Bends:
        """Of nothing yet."""
        return cls(np.zeros(0), np.zeros(0))

    def fits(self, box: Floats) -> bool:
        """True where it holds on a box, and is not much wider."""
        if len(self.box) != len(box):
            return False
        return bool((box <= self.box).all() and (self.box <= WIDE * box + FAINT).all())

    def remainders(self, products: Floats) -> Floats:
        """Of the outputs (C, out), by products of inputs (C, n, n)."""
        return np.asarray(np.einsum("oij,cij->co", self.sizes, products) * SUMS)


@dataclass(frozen=True)
class SettledCells:
    """Cells that came through: their places, the most on their way, and where they end.

    ``rest`` (C, n, columns): deviations as those that were given.
    """

    through: NDArray[np.int_]
    rest: Floats
    position: float
    heading: float


class Settling:
    """A loop from states off its reference over ``samples``, with exact measurements.

    ``certifier`` has no start.
    """

    def __init__(self, certifier: Certifier, inputs: Inputs, samples: int) -> None:
        """Follow the linear loop from each of its states, and from each remainder."""
        self.certifier, self.inputs, self.samples = certifier, inputs, samples
        loop, gains = certifier.loop, certifier.gains
        self.nz, self.linear = len(loop.names), certifier.linear(inputs)
        with ctx.workprec(BITS):
            sample, picked = SampleMatrices(loop), fast_rows(self.nz, gains.ratios)
            A, power, powers = arb_mat(sample.A.tolist()), None, [np.eye(sample.n)]
            for _ in range(samples):
                power = A if power is None else A * power
                powers.append(doubles(np.array(power.tolist(), dtype=object)))
            outputs, self.law = doubles(sample.outputs), doubles(sample.law)
            within = [sample.rows_within(s, picked) for s in range(loop.steps)]
            steps = [doubles(item) for item in powers_of(sample.step, loop.steps)]
        self.powers, self.n = np.array(powers), sample.n
        self.rows = np.concatenate([item.picked @ item.state for item in within])
        self.direct = np.max([item.law for item in within], axis=0) * SUMS
        self.own = np.max([item.steps for item in within], axis=0) * SUMS
        self.acting = np.flatnonzero(outputs.any(axis=0))
        self.every = np.vstack([self.rows, np.eye(self.n), self.law])
        blank = np.zeros((self.n - self.nz, self.nz))
        by_steps = np.sum([self._ways(np.vstack([item, blank])) for item in steps], axis=0)
        ways = np.concatenate([self._ways(outputs[:, self.acting]), by_steps], axis=2)
        count = len(self.rows) // loop.steps
        fast = ways[:, : len(self.rows)].reshape(samples + 1, loop.steps, count, -1).max(axis=1)
        every = np.concatenate([fast, ways[:, len(self.rows) :]], axis=1) * SUMS
        self.ways = np.ascontiguousarray(every.transpose(0, 2, 1))
        self.count, self.steps = count, loop.steps
        self.scale = np.where(gains.scale > 0, gains.scale, gains.scale[gains.scale > 0].min())
        self.slowest = SLOWEST * abs(float(loop.at[ROBOT - COMMAND]))
        self.of_step, self.of_law = Bends.none(), Bends.none()

    def _ways(self, new: Floats) -> Floats:
        """Sizes (samples + 1, rows, columns) of all rows after columns (n, columns) of a state.

        What the plant steps of a sample leave may have any signs, so each step's sizes are added.
        """
        moved, most = self.powers @ new, np.abs(self.powers) @ np.abs(new)
        return np.asarray(np.abs(self.every @ moved) + COARSE * np.abs(self.every) @ most)

    def _moved(self, fast: Floats, force: Floats) -> Floats:
        known = np.concatenate((self.inputs.push, self.inputs.body))
        return np.hstack([fast[:, : self.nz], force, np.tile(known, (len(fast), 1))])

    def _seen(self, fast: Floats, state: Floats) -> Floats:
        loop = self.certifier.loop
        queue = COMMAND * loop.queue
        sent, memory, acting = np.split(state[:, self.nz :], [queue, queue + loop.memory], axis=1)
        return np.hstack([fast[:, :ROBOT], memory, sent, acting])

    def likely(self, rest: Floats) -> NDArray[np.bool_]:
        """Which deviations (C, n, columns) break no condition even in the linear loop."""
        own, live = self.law[-self.certifier.loop.count :], np.arange(len(rest))
        most = self.linear.law[-len(own) :]
        for power in self.powers[::LOOK]:
            law = np.abs((own @ power) @ rest[live]).sum(axis=2) + most
            live = live[self._inside(law)]
        likely = np.zeros(len(rest), dtype=bool)
        likely[live] = True
        return likely

    def course(self, rest: Floats) -> SettledCells:
        """Carry deviations (C, n, columns), the first column their middle, over the samples."""
        live, count = np.arange(len(rest)), self.count
        whole = np.concatenate(
            [rest[:, :, :1], reduced(rest[:, :, 1:], self.scale, COLUMNS)], axis=2
        )
        far, turned = np.zeros(len(rest)), np.zeros(len(rest))
        added = np.zeros((len(rest), self.samples, self.ways.shape[1]))  # the latest first
        for k in range(self.samples):
            size = self._reached(whole, added[:, self.samples - k :], k)
            fast, stays, new = self._sample(size)
            far[live] = np.maximum(far[live], fast[:, self.nz : self.nz + DIRECTIONS].max(axis=1))
            turned[live] = np.maximum(turned[live], fast[:, 2])
            added[:, self.samples - 1 - k] = new
            whole, added, live = whole[stays], added[stays], live[stays]
            if not len(live):
                break
        position = far[live].max(initial=0.0) / cos(pi / (2 * DIRECTIONS)) * SUMS
        moved = self.powers[-1] @ whole
        left = self._after(added, self.samples)[:, count : count + self.n]
        left = left * SUMS + COARSE * self._most_moved(whole, self.samples)
        rest = np.concatenate([moved, left[:, :, None] * np.eye(self.n)], axis=2)
        return SettledCells(live, rest, float(position), float(turned[live].max(initial=0.0)))

    def _reached(self, whole: Floats, added: Floats, k: int) -> Floats:
        """Largest deviations r (C, rows) at the sample k: of fast state, state and law."""
        ends = np.abs(self.every @ (self.powers[k] @ whole)).sum(axis=2)
        ends += COARSE * self._most_moved(whole, k) @ np.abs(self.every).T
        within = len(self.rows)
        fast = ends[:, :within].reshape(len(ends), self.steps, self.count).max(axis=1)
        size = np.concatenate([fast, ends[:, within:]], axis=1)
        if k:
            size += self._after(added, k)
        return np.asarray(size * SUMS)

    def _most_moved(self, whole: Floats, k: int) -> Floats:
        """Sums (C, n) of columns after k samples if nothing cancelled, for their rounding."""
        return np.asarray(np.abs(whole).sum(axis=2) @ np.abs(self.powers[k]).T)

    def _after(self, added: Floats, k: int) -> Floats:
        """Largest values (C, rows) after what k samples added."""
        ways = self.ways[:k].reshape(-1, self.ways.shape[2])
        return np.asarray(added.reshape(len(added), len(ways)) @ ways)

    def _sample(self, size: Floats) -> tuple[Floats, NDArray[np.bool_], Floats]:
        """Deviations of the fast state in a sample, where they admit it, what law and steps add."""
        count, most, n = len(size), self.linear, self.n
        fast, state = size[:, : self.count] + most.fast, size[:, self.count :][:, :n] + most.state
        law = size[:, self.count + n :] + most.law
        by_law, by_step = np.zeros((count, len(self.law))), np.zeros((count, self.nz))
        inside = self._inside(law)
        held = ~inside
        reach = fast
        for _ in range(ROUNDS):
            reach = (fast + by_law @ self.direct.T + by_step @ self.own.T) * SUMS
            shown = (law + by_law) * SUMS
            inside &= self._inside(shown)
            inside &= np.asarray(reach[:, ROBOT - COMMAND] <= self.slowest)
            if not inside.any():
                break
            next_law, next_step = self._remainders(reach, shown, state, inside)
            held = np.asarray((next_law <= by_law).all(axis=1) & (next_step <= by_step).all(axis=1))
            if held[inside].all():
                break
            by_law = np.where(held[:, None], by_law, next_law * MORE)
            by_step = np.where(held[:, None], by_step, next_step * MORE)
        return reach, held & inside, np.hstack([by_law[:, self.acting], by_step])

    def _inside(self, law: Floats) -> NDArray[np.bool_]:
        """Whether no condition is broken by outputs of the law that are off so far."""
        own = self.certifier
        return np.asarray(((own.level + law[:, -own.loop.count :]) * SUMS <= own.most).all(axis=1))

    def _remainders(
        self, fast: Floats, law: Floats, state: Floats, counts: NDArray[np.bool_]
    ) -> tuple[Floats, Floats]:
        """Of the law and of a plant step, of the cells that count (ledger: corridor.frame)."""
        pairs = fast[:, :ROBOT, None] * fast[:, None, :ROBOT]
        ends = fast[:, self.nz + DIRECTIONS :].reshape(len(fast), -1, 2).max(axis=2)
        both = ends**2 / (4 * self.certifier.gains.ratios)
        for k, (a, b) in enumerate(PAIRS):
            pairs[:, a, b] = pairs[:, b, a] = np.minimum(pairs[:, a, b], both[:, k])
        moved, seen = self._moved(fast, law[:, :COMMAND]), self._seen(fast, state)
        loop = self.certifier.loop
        if not self.of_step.fits(box := moved[counts].max(axis=0)):
            self.of_step = Bends.of(loop.step, box * ROOM)
        if not self.of_law.fits(box := seen[counts].max(axis=0)):
            self.of_law = Bends.of(loop.law, box * ROOM)
        by_step, by_law = (x[:, :, None] * x[:, None, :] for x in (moved, seen))
        by_step[:, :ROBOT, :ROBOT] = by_law[:, :ROBOT, :ROBOT] = pairs
        return self.of_law.remainders(by_law * SUMS), self.of_step.remainders(by_step * SUMS)
