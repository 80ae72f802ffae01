"""From a start that is farther off than limits admit, until the corridor holds.

A box of starts is cut into cells, each carried on over the very loop, sample after sample, as an
enclosure (`wmr_ctrl.corridor.limited`).  After some samples what the pushes would have done in the
linear loop is taken away, column by column.  The rest is a start in the linear loop's sense: the
corridor holds from there on if its box closes with it (ledger: corridor.transient).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from flint import arb_mat, ctx
from numpy.typing import NDArray

from wmr_ctrl.checks.world import ROBOT, Floats
from wmr_ctrl.corridor.affine import SUMS
from wmr_ctrl.corridor.certificate import Certifier, Tube
from wmr_ctrl.corridor.inputs import Inputs, NoCorridorError
from wmr_ctrl.corridor.limited import COARSE, LimitedLoop, StartCells
from wmr_ctrl.corridor.sample import SampleMatrices, doubles

WIDEST, FINEST = (0.005, 0.005, 0.025), (0.001, 0.001, 0.005)
"""Half-widths of the first cells at most, and of cells that are given up [m, m, rad]."""
CELLS, BATCH = 1_200, 16
"""Cells that are tried at most, and together."""
LOST = (0.6, 4.0)
"""Half-width of e3 [rad], and of velocities in v_u1, with which a cell is lost."""
NARROW = 1e-9
"""Of the loop's scale, what is added to a box before it is used as a start."""
FIRST, EVERY, MOST = 40, 20, 200
"""Samples after which a cell may be in, between two looks, and after which it is given up."""
SPARE = 1.25
"""Of the box that the first cells come into, what others may come into."""
BITS = 1000
"""For powers of the loop's matrix."""


@dataclass(frozen=True)
class Transient:
    """What precedes a tube: ``time`` [s] until it holds, the most until then [m], [rad]."""

    time: float
    position: float
    heading: float


def transient(certifier: Certifier, inputs: Inputs) -> tuple[Transient, Tube]:
    """From all starts within `corridor.start` into a tube that holds from then on.

    NoCorridorError where some cell does not come in, or there is no such tube.
    """
    return _Search(certifier, inputs).result()


class _Search:
    """Cells by cells, from the corners inwards; those that are lost are cut in two."""

    def __init__(self, certifier: Certifier, inputs: Inputs) -> None:
        self.certifier, self.inputs, self.limited = certifier, inputs, LimitedLoop(certifier)
        self.start = np.array(certifier.loop.setup.scenario.corridor.start)
        self.pushed = _pushed(certifier, inputs)
        self.scale = certifier.gains.scale[:, None]
        self.samples, self.position, self.heading = 0, 0.0, 0.0
        self.entry: tuple[Floats, Floats] | None = None
        self.tube: Tube | None = None

    def result(self) -> tuple[Transient, Tube]:
        """Run all of them."""
        middle, width = _cut(self.start)
        tried = len(middle)
        outer = np.abs(middle) / np.maximum(self.start, np.finfo(float).tiny)
        order = np.argsort(-outer.sum(axis=1), kind="stable")
        middle, width = middle[order], width[order]
        while len(middle):
            lost = self._run(self.limited.start(middle[:BATCH], width[:BATCH]))
            middle, width = middle[BATCH:], width[BATCH:]
            if not len(lost.middle):
                continue
            tried += 2 * len(lost.middle)
            if (lost.width <= FINEST).all(axis=1).any() or tried > CELLS:
                place = ", ".join(f"{x:.2g}" for x in lost.middle[0])
                raise NoCorridorError(
                    f"limits may act, and from a start off by about ({place}) m, m, rad it is not "
                    "known to come back"
                )
            halves = _halved(lost.middle, lost.width)
            middle, width = (np.vstack(item) for item in zip(halves, (middle, width), strict=True))
        assert self.tube is not None
        period = self.certifier.loop.setup.scenario.clock.control
        return Transient(self.samples * period, self.position, self.heading), self.tube

    def _run(self, cells: StartCells) -> StartCells:
        """Carry cells until all are in; those that are lost come back as they began."""
        first, live = cells, np.arange(len(cells.c))
        far, turned = np.zeros(len(live)), np.zeros(len(live))
        lost: list[int] = []
        for k in range(1, MOST + 1):
            cells, way, heading = self.limited.after(cells, self.inputs)
            far[live], turned[live] = np.maximum(far[live], way), np.maximum(turned[live], heading)
            radius = cells.radius
            good = np.isfinite(radius).all(axis=1) & (radius[:, 2] < LOST[0])
            good &= (radius[:, 3:ROBOT] < LOST[1] * self.limited.largest).all(axis=1)
            lost.extend(live[~good].tolist())
            cells, live = cells.only(good), live[good]
            if len(live) and k >= FIRST and (k - FIRST) % EVERY == 0:
                inside = self._inside(cells)
                self.samples = max(self.samples, k * bool(inside.any()))
                cells, live = cells.only(~inside), live[~inside]
            if not len(live):
                break
        lost.extend(live.tolist())
        through = np.setdiff1d(np.arange(len(far)), lost)
        self.position = max(self.position, far[through].max(initial=0.0))
        self.heading = max(self.heading, turned[through].max(initial=0.0))
        return first.only(np.array(sorted(lost), dtype=int))

    def _inside(self, cells: StartCells) -> NDArray[np.bool_]:
        """Which cells are where the tube holds from: the first ones choose it, if there is one."""
        rest = self.limited.rest(cells, self.pushed[:, -cells.pushes :]) / self.scale
        if self.entry is None:
            axes = np.linalg.svd(rest[0])[0]
            size = SPARE * np.abs(axes.T @ rest).sum(axis=2).max(axis=0) + NARROW
            start = self.scale * np.hstack([axes * size, NARROW * np.eye(len(axes))])
            try:
                self.tube = self.certifier.started(start).tube(self.inputs)
            except NoCorridorError:
                return np.zeros(len(rest), dtype=bool)
            self.entry = axes, size
        axes, size = self.entry
        return np.asarray((np.abs(axes.T @ rest).sum(axis=2) * SUMS + COARSE <= size).all(axis=1))


def _pushed(certifier: Certifier, inputs: Inputs) -> Floats:
    """What pushes of MOST samples do in the linear loop by the end, the first first (n, 2 each)."""
    with ctx.workprec(BITS):
        matrices, columns = SampleMatrices(certifier.loop), list[Floats]()
        A, now = (arb_mat(item.tolist()) for item in (matrices.A, matrices.push))
        for _ in range(MOST):
            columns.append(doubles(np.array(now.tolist(), dtype=object)))
            now = A * now
    return np.asarray(np.hstack(columns[::-1]) * np.tile(inputs.push, MOST))


def _cut(start: Floats) -> tuple[Floats, Floats]:
    """Middles and half-widths (C, 3) of the first cells of a box of starts."""
    counts = [max(1, int(np.ceil(s / w))) for s, w in zip(start, WIDEST, strict=True)]
    ways = [s / n * (2 * np.arange(n) + 1 - n) for s, n in zip(start, counts, strict=True)]
    middle = np.stack(np.meshgrid(*ways, indexing="ij"), axis=-1).reshape(-1, 3)
    return middle, np.tile(start / counts * (1 + COARSE), (len(middle), 1))


def _halved(middle: Floats, width: Floats) -> tuple[Floats, Floats]:
    """Cells cut in two where they are widest."""
    rows, axis = np.arange(len(middle)), (width / WIDEST).argmax(axis=1)
    half, step = width.copy(), np.zeros_like(middle)
    half[rows, axis] *= 0.5 * (1 + COARSE)
    step[rows, axis] = width[rows, axis] / 2
    return np.vstack([middle - step, middle + step]), np.vstack([half, half])
