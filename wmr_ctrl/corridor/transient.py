"""From a start that is farther off than limits admit, until the corridor holds.

A box of starts is cut into cells, each carried on over the very loop, sample after sample, as an
enclosure (`wmr_ctrl.corridor.limited`).  After some samples what the pushes would have done in the
linear loop is taken away, column by column.  The rest is followed on while nothing limits
(`wmr_ctrl.corridor.settling`), until it is small enough for a start in the linear loop's sense: the
corridor holds from there on if its box closes with it (ledger: corridor.transient).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from flint import arb_mat, ctx
from numpy.typing import NDArray

from wmr_ctrl.checks.world import Floats
from wmr_ctrl.corridor.certificate import Certifier
from wmr_ctrl.corridor.inputs import Inputs, NoCorridorError
from wmr_ctrl.corridor.limited import LimitedLoop, StartCells, V
from wmr_ctrl.corridor.peaks import Tube
from wmr_ctrl.corridor.sample import SampleMatrices, doubles
from wmr_ctrl.corridor.settling import BITS, Settling
from wmr_ctrl.corridor.zonotopes import COARSE

WIDEST, FINEST = (0.005, 0.005, 0.025), (0.0012, 0.0012, 0.006)
"""Half-widths of the first cells at most, and of cells that are given up [m, m, rad]."""
CELLS, BATCH = 4_000, 64
"""Cells that are tried at most, and together."""
LOST = (0.6, 2.0)
"""Half-width of e3 [rad], and of velocities in v_u1, with which a cell is lost."""
LOOKS = (20, 30, 40, 60, 80, 100, 120)
"""Samples after which a cell may need no limits any more; after the last it is given up."""
SAMPLES = 200
"""That are followed from there on."""


@dataclass(frozen=True)
class Transient:
    """Phase before a tube: ``time`` [s] after which no limit acts, the most so far [m], [rad]."""

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
        n = len(certifier.loop.at)
        self.start = np.array(certifier.loop.setup.scenario.corridor.start)
        self.settling = Settling(certifier.started(np.zeros((n, 1))), inputs, SAMPLES)
        self.pushed = _pushed(certifier, inputs)
        self.samples, self.position, self.heading = 0, 0.0, 0.0
        self.entry = np.zeros(n)

    def result(self) -> tuple[Transient, Tube]:
        """Run all of them."""
        middle, width = _cut(self.start)
        tried = len(middle)
        if tried > CELLS:
            raise NoCorridorError(f"so large a start takes {tried} cells, more than {CELLS}")
        outer = np.abs(middle) / np.maximum(self.start, np.finfo(float).tiny)
        order = np.argsort(-outer.sum(axis=1), kind="stable")
        middle, width = middle[order], width[order]
        while len(middle):
            lost = self._run(middle[:BATCH], width[:BATCH])
            halves = _halved(middle[:BATCH][lost], width[:BATCH][lost])
            tried += len(halves[0])
            if tried > CELLS or (halves[1] < FINEST).all(axis=1).any():
                place = ", ".join(f"{x:.2g}" for x in middle[lost][0])
                raise NoCorridorError(
                    f"limits may act, and from a start off by about ({place}) m, m, rad it is not "
                    "known to come back"
                )
            left = middle[BATCH:], width[BATCH:]
            middle, width = (np.vstack(item) for item in zip(halves, left, strict=True))
        period = self.certifier.loop.setup.scenario.clock.control
        tube = self.certifier.started(np.diag(self.entry)).tube(self.inputs)
        return Transient(self.samples * period, self.position, self.heading), tube

    def _run(self, middle: Floats, width: Floats) -> NDArray[np.intp]:
        """Carry cells until all are in; places of those that are lost."""
        cells, count = self.limited.start(middle, width), len(middle)
        far, turned, through = np.zeros(count), np.zeros(count), np.zeros(count, dtype=bool)
        for k in range(1, LOOKS[-1] + 1):
            cells, way, heading = self.limited.after(cells, self.inputs)
            far[cells.begin] = np.maximum(far[cells.begin], way)
            turned[cells.begin] = np.maximum(turned[cells.begin], heading)
            radius = cells.radius
            good = np.isfinite(cells.c).all(axis=1) & (radius[:, 2] < LOST[0])
            good &= (radius[:, V] < LOST[1] * self.limited.largest).all(axis=1)
            cells = cells.only(good)
            if len(cells.c) and k in LOOKS:
                inside = self._settled(cells, k)
                through[cells.begin[inside]] = True
                cells = cells.only(~inside)
            if not len(cells.c):
                break
        self.position = max(self.position, far[through].max(initial=0.0))
        self.heading = max(self.heading, turned[through].max(initial=0.0))
        return np.flatnonzero(~through)

    def _settled(self, cells: StartCells, k: int) -> NDArray[np.bool_]:
        """Which cells need no limits any more and come in."""
        rest = self.limited.rest(cells, self.pushed[:, -cells.pushes :])
        course = self.settling.course(rest)
        inside = np.zeros(len(cells.c), dtype=bool)
        inside[course.through] = True
        if inside.any():
            self.samples = max(self.samples, k)
            self.position = max(self.position, course.position)
            self.heading = max(self.heading, course.heading)
            self.entry = np.maximum(self.entry, course.rest.max(axis=0))
        return inside


def _pushed(certifier: Certifier, inputs: Inputs) -> Floats:
    """Effect of each sample's push on the linear loop at the end, earliest first (n, 2 each)."""
    with ctx.workprec(BITS):
        matrices, columns = SampleMatrices(certifier.loop), list[Floats]()
        A, now = (arb_mat(item.tolist()) for item in (matrices.A, matrices.push))
        for _ in range(LOOKS[-1]):
            columns.append(doubles(np.array(now.tolist(), dtype=object)))
            now = A * now
    return np.asarray(np.hstack(columns[::-1]) * np.tile(inputs.push, LOOKS[-1]))


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
