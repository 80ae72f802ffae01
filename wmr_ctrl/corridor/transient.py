"""From a start that is farther off than limits admit, until the corridor holds.

A box of starts is cut into cells, each carried on over the very loop, sample after sample, as an
enclosure (`wmr_ctrl.corridor.limited`).  After some samples what the pushes would have done in the
linear loop is taken away, column by column.  The rest is followed on while nothing limits
(`wmr_ctrl.corridor.settling`), until it is small enough for a start in the linear loop's sense: the
corridor holds from there on if its box closes with it (ledger: corridor.transient).
"""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from flint import arb_mat, ctx
from numpy.typing import NDArray

from wmr_ctrl.checks.world import ROBOT, Floats
from wmr_ctrl.corridor.certificate import Certifier
from wmr_ctrl.corridor.inputs import Inputs, NoCorridorError
from wmr_ctrl.corridor.limited import NARROW, LimitedLoop, StartCells, V
from wmr_ctrl.corridor.peaks import Tube
from wmr_ctrl.corridor.sample import SampleMatrices, doubles
from wmr_ctrl.corridor.settling import BITS, Settling
from wmr_ctrl.corridor.zonotopes import COARSE, radius_of

WIDEST = (0.005, 0.005, 0.025)
"""Half-widths of the first cells at most [m, m, rad]."""
CELLS, BATCH = 4_000, 256
"""Cells that are tried at most, and together."""
SIGNS = np.array(list(product((-1.0, 1.0), repeat=3)))
"""Of a box's corners: tried first, without pushes, they soon refuse a start that is too far off."""
LOST = (0.15, 0.6)
"""Half-width of e3 [rad], and of velocities in v_u1, with which a cell is lost."""
WHY = (
    "the guard may act", "its heading is known too coarsely", "its speed is known too coarsely",
    "its turning velocity is known too coarsely", "limits may act still",
)  # fmt: skip
"""Reasons for which a cell is lost; the last where none of the others holds."""
LOOKS = (20, 30, 40, 50, 60, 70, 80, 90, 100, 110, 120)
"""Samples after which a cell may need no limits any more; after the last it is given up."""
SAMPLES, STAGES = 200, 6
"""That are followed from there on at once, and how often at most."""
CUTS, WIDTHS = (10, 15, 20), (0.01, 0.006, 0.03, 0.12, 0.2)
"""Samples at which a lost cell may be cut, if one of its half-widths of errors [m, m, rad] and
velocities [m/s, rad/s] is larger than ``share`` of these."""
BEGUN, FINER, FINEST = 0.25, 0.7, 0.1
"""Share of WIDEST down to which a start is cut first; of ``share``, its next one, and its least."""


@dataclass(frozen=True)
class Transient:
    """Phase before a tube: ``time`` [s] after which no limit acts, the most so far [m], [rad]."""

    time: float
    position: float
    heading: float


@dataclass(frozen=True)
class StartPart:
    """One cell of the starts about ``start`` (3) after ``k`` samples, the most so far [m], [rad].

    ``share``: of WIDTHS, at which it is cut.
    """

    cell: StartCells
    k: int
    start: Floats
    far: float = 0.0
    turned: float = 0.0
    share: float = 1.0


@dataclass(frozen=True)
class PassedCells:
    """Cells after ``k`` samples, and the most so far of all of a batch."""

    k: int
    cells: StartCells
    far: Floats
    turned: Floats

    def part(self, place: int, of: StartPart) -> StartPart | None:
        """The cells that began as one of the batch; None where all are done."""
        which = np.flatnonzero(self.cells.begin == place)
        if not len(which):
            return None
        far, turned = float(self.far[place]), float(self.turned[place])
        return replace(of, cell=self.cells.only(which), k=self.k, far=far, turned=turned)


def transient(certifier: Certifier, inputs: Inputs) -> tuple[Transient, Tube]:
    """From all starts within `corridor.start` into a tube that holds from then on.

    NoCorridorError where some cell does not come in, or there is no such tube.
    """
    return _Search(certifier, inputs, LimitedLoop(certifier)).result()


class _Search:
    """Batch by batch, the earliest first, so that batches are large; a lost cell is cut in two."""

    def __init__(self, certifier: Certifier, inputs: Inputs, limited: LimitedLoop) -> None:
        self.certifier, self.inputs, self.limited = certifier, inputs, limited
        n = len(certifier.loop.at)
        scenario = certifier.loop.setup.scenario
        self.start, self.period = np.array(scenario.corridor.start), scenario.clock.control
        self.settling = Settling(certifier.started(np.zeros((n, 1))), inputs, SAMPLES)
        self.pushed = _pushed(certifier, inputs)
        self.samples, self.position, self.heading = 0, 0.0, 0.0
        self.came, self.lost = list[Floats](), NoCorridorError("no cell was lost")

    def result(self) -> tuple[Transient, Tube]:
        """Run all of them."""
        middle, width = _cut(self.start)
        if len(middle) > CELLS:
            stated = ", ".join(f"{x:g}" for x in self.start)
            raise NoCorridorError(
                f"so large a start takes {len(middle)} cells, more than {CELLS} (is corridor.start "
                f"= [{stated}] in m, m and rad?)"
            )
        _Search(self.certifier, self.inputs.scaled(0.0), self.limited).try_corners()
        outer = np.abs(middle) / np.maximum(self.start, np.finfo(float).tiny)
        order = np.argsort(outer.sum(axis=1), kind="stable")
        begun = self._begun(middle[order], width[order])
        waiting = {0: begun}
        tried = 0
        while waiting:
            k = min(waiting)
            parts, rest = waiting[k][-BATCH:], waiting.pop(k)[:-BATCH]
            if rest:
                waiting[k] = rest
            tried += len(parts)
            for part in self._run(parts):
                waiting.setdefault(part.k, []).append(part)
            if tried > CELLS:
                raise NoCorridorError(f"{self.lost}, and more than {CELLS} cells were tried")
        return Transient(self.samples * self.period, self.position, self.heading), self._entered()

    def _begun(self, middle: Floats, width: Floats) -> list[StartPart]:
        """Cells of starts (C, 3) with their half-widths, each for itself."""
        cells = self.limited.start(middle, width)
        return [StartPart(cells.only(np.array([i])), 0, at) for i, at in enumerate(middle)]

    def try_corners(self) -> None:
        """Raise NoCorridorError where one of the box's corners alone does not come in."""
        corners = np.unique(self.start * SIGNS, axis=0)
        parts = self._begun(corners, np.zeros_like(corners))
        with suppress(NoCorridorError):
            if not self._run(parts):
                return
        raise NoCorridorError(f"{self.lost}, also without pushes")

    def _entered(self, stage: int = 1) -> Tube:
        """The tube of what came in, which is followed on where it is too far off for one."""
        entry = np.max([radius_of(item).max(axis=0) for item in self.came], axis=0)
        try:
            return self.certifier.started(np.diag(entry)).tube(self.inputs)
        except NoCorridorError as error:
            came, self.came = self.came, []
            if stage == STAGES or not all(self._course(item).all() for item in came):
                left = ", ".join(f"{x:.2g}" for x in entry[:3])
                raise NoCorridorError(
                    f"{stage * SAMPLES * self.period:g} s after limits may act last, what is left "
                    f"of the start may be ({left}) m, m, rad, which is too much: {error}"
                ) from error
        return self._entered(stage + 1)

    def _run(self, parts: list[StartPart]) -> list[StartPart]:
        """Carry parts until all are in; halves of those that are lost."""
        cells = parts[0].cell.joined([item.cell for item in parts[1:]])
        far = np.array([item.far for item in parts])
        turned = np.array([item.turned for item in parts])
        through, over = np.zeros(len(parts), dtype=bool), np.full(len(parts), LOOKS[-1])
        why = np.full(len(parts), len(WHY) - 1)
        saved = [PassedCells(parts[0].k, cells, far.copy(), turned.copy())]
        for k in range(parts[0].k + 1, LOOKS[-1] + 1):
            cells, way, heading = self.limited.after(cells, self.inputs)
            far[cells.begin] = np.maximum(far[cells.begin], way)
            turned[cells.begin] = np.maximum(turned[cells.begin], heading)
            radius = cells.radius
            wide = radius[:, 2:ROBOT] >= np.array([LOST[0], *LOST[1] * self.limited.largest])
            bad = np.column_stack([~np.isfinite(cells.c).all(axis=1), wide])
            good = np.logical_not(bad.any(axis=1))
            over[cells.begin[~good]], why[cells.begin[~good]] = k, bad[~good].argmax(axis=1)
            cells = cells.only(good)
            if len(cells.c) and k in LOOKS:
                inside = self._settled(cells, k)
                through[cells.begin[inside]] = True
                cells = cells.only(~inside)
            if not len(cells.c):
                break
            if k in CUTS:
                saved.append(PassedCells(k, cells, far.copy(), turned.copy()))
        self.position = max(self.position, far[through].max(initial=0.0))
        self.heading = max(self.heading, turned[through].max(initial=0.0))
        lost = np.flatnonzero(~through)
        halves = list[StartPart]()
        for i in lost:
            two = _halved(saved, int(i), parts[i], int(over[i]))
            self.lost = _lost(parts[i].start, f"{over[i] * self.period:g} s after it {WHY[why[i]]}")
            if not two:
                raise self.lost
            halves += two
        return halves

    def _settled(self, cells: StartCells, k: int) -> NDArray[np.bool_]:
        """Which cells need no limits any more and come in."""
        inside = np.zeros(len(cells.c), dtype=bool)
        rest = self.limited.rest(cells, self.pushed[:, self.pushed.shape[1] - cells.pushes :])
        likely = np.flatnonzero(self.settling.likely(rest))
        if not len(likely):
            return inside
        inside[likely] = self._course(rest[likely])
        if inside.any():
            self.samples = max(self.samples, k)
        return inside

    def _course(self, rest: Floats) -> NDArray[np.bool_]:
        """Which deviations come in while nothing limits; what they are then is kept."""
        course, inside = self.settling.course(rest), np.zeros(len(rest), dtype=bool)
        inside[course.through] = True
        if inside.any():
            self.position = max(self.position, course.position)
            self.heading = max(self.heading, course.heading)
            self.came.append(course.rest)
        return inside


def _halved(
    saved: Sequence[PassedCells], place: int, part: StartPart, over: int
) -> list[StartPart]:
    """The halves of a part that was lost after ``over`` samples, cut as early as it is wide.

    Empty where it is not wide at all.
    """
    share = part.share
    while share > FINEST:
        for item in saved:
            at = item.part(place, part)
            if at is None or item.k >= over:
                break
            row = _widest(at, share)
            if row is not None:
                halves = at.cell.halves(row)
                starts = halves.c[:, :3] if at.k == 0 else [part.start, part.start]
                cells = [halves.only(np.array([i])) for i in (0, 1)]
                return [
                    replace(at, cell=cell, start=start, share=share)
                    for cell, start in zip(cells, starts, strict=True)
                ]
        share *= FINER
    return []


def _widest(part: StartPart, share: float) -> int | None:
    """Element of the state in which a part is widest, None where it is not too wide."""
    size, most = part.cell.radius[0, :ROBOT], np.array(WIDTHS) * share
    if part.k == 0:
        size, most = size[:3], np.array(WIDEST) * min(share, BEGUN)
    else:
        low, high = part.cell.velocities
        size[V] = (high - low)[0] / 2
    return int((size / most).argmax()) if (size > most * (1 + NARROW)).any() else None


def _lost(start: Floats, why: str) -> NoCorridorError:
    place = ", ".join(f"{x + 0.0:.2g}" for x in start)
    return NoCorridorError(
        f"limits may act, and from a start off by about ({place}) m, m, rad it is not known to "
        f"come back: {why}"
    )


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
