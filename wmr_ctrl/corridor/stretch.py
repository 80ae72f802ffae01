"""Matrices of some samples along a motion, in spans: of a whole sample, and of times within it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wmr_ctrl.checks.world import COMMAND, ROBOT, Floats
from wmr_ctrl.corridor.midradius import OUTWARD, ROUNDED, MidRadius, rounding
from wmr_ctrl.corridor.motion import MovingLoop
from wmr_ctrl.corridor.secants import Secants


@dataclass(frozen=True)
class Within:
    """A time within samples: rows of the fast state by the state, a push, an added command.

    ``apart`` (3): the largest sizes by which such rows are off the chord to the next such time.
    """

    state: MidRadius
    push: MidRadius
    command: MidRadius
    apart: tuple[Floats, Floats, Floats]


@dataclass(frozen=True)
class Stretch:
    """Samples of a motion, the first axis of all.

    ``A`` (n, n): the state a sample later; ``push`` (n, 2), ``law`` (n, outputs): by what disturbs
    and by what is added to the law's outputs; ``outputs`` (outputs, n): the law's linear part, and
    ``seen`` (outputs, 5) that of what is measured.  ``steps`` (fast, fast): sizes by which what
    each plant step leaves adds up; ``body`` (fast, 2): of a plant step by mass and inertia.
    ``secants``: of law and plant step, where these are not slopes at points.
    """

    A: MidRadius
    push: MidRadius
    law: MidRadius
    outputs: MidRadius
    seen: MidRadius
    steps: Floats
    body: Floats
    knots: list[Within]
    secants: tuple[Secants, Secants] | None = None


def stretch(loop: MovingLoop, law: MidRadius, step: MidRadius, knots: list[int]) -> Stretch:
    """From the slopes of the law and of a plant step in each sample; ``knots`` begin with 0."""
    nz, nq, nm, na = len(loop.names), COMMAND * loop.queue, loop.memory, loop.acting
    n, count = nz + nq + nm + na, len(law.middle)
    order = [*range(ROBOT), *range(nz + nq, nz + nq + nm), *range(nz, nz + nq), *range(n - na, n)]
    outputs = MidRadius(*(_placed(part, order, n) for part in (law.middle, law.radius)))
    behind, rest = divmod(loop.late, loop.steps)
    ages = [n, *range(nz, nz + nq, COMMAND)]  # the state, then an added command, then a push
    by_z, inputs = step[:, :, :nz], step[:, :, nz : nz + 2 * COMMAND]
    now = MidRadius(*(np.zeros((count, nz, n + 2 * COMMAND)) for _ in range(2)))
    now.middle[:] = np.eye(nz, n + 2 * COMMAND)
    sums, size, course = np.zeros((count, nz, nz)), by_z.most, [now]
    for s in range(loop.steps):
        now = by_z @ now
        for k, at in enumerate((ages[behind + (s < rest)], n + COMMAND)):
            part, new = slice(at, at + COMMAND), inputs[:, :, k * COMMAND : (k + 1) * COMMAND]
            whole = now[:, :, part] + new
            now.middle[:, :, part], now.radius[:, :, part] = whole.middle, whole.radius
        sums = (size @ sums) * (1 + rounding(nz)) + np.eye(nz)
        course.append(now)
    each = [_closed(item, outputs, n) for item in course]
    rows = MidRadius(*(np.zeros((count, n, n)) for _ in range(2)))
    by_law = MidRadius(*(np.zeros((count, n, outputs.middle.shape[1])) for _ in range(2)))
    push = MidRadius(*(np.zeros((count, n, COMMAND)) for _ in range(2)))
    for key in ("middle", "radius"):
        part = getattr(now, key)
        getattr(rows, key)[:, :nz] = part[:, :, :n]
        getattr(by_law, key)[:, :nz, :COMMAND] = part[:, :, n : n + COMMAND]
        getattr(push, key)[:, :nz] = part[:, :, n + COMMAND :]
    for k, at in enumerate(ages[: loop.queue]):
        place, unit = slice(nz + COMMAND * k, nz + COMMAND * (k + 1)), np.eye(COMMAND)
        if at == n:
            by_law.middle[:, place, :COMMAND] = unit
        else:
            rows.middle[:, place, at : at + COMMAND] = unit
    by_law.middle[:, nz + nq :, COMMAND : COMMAND + nm + na] = np.eye(nm + na)
    between = zip(knots, [*knots[1:], loop.steps], strict=True)
    return Stretch(
        rows + by_law @ outputs, push, by_law, outputs, law[:, :, :ROBOT], sums,
        step[:, :, -COMMAND:].most, [Within(*each[a], _bent(each, a, b)) for a, b in between],
    )  # fmt: skip


def _placed(part: Floats, order: list[int], n: int) -> Floats:
    result = np.zeros((*part.shape[:2], n))
    result[:, :, order] = part
    return result


def _closed(now: MidRadius, outputs: MidRadius, n: int) -> tuple[MidRadius, MidRadius, MidRadius]:
    """Rows of the fast state by the state, with the command that the law makes of it."""
    command = now[:, :, n : n + COMMAND]
    whole = now[:, :, :n] + command @ outputs[:, :COMMAND]
    return whole, now[:, :, n + COMMAND :], command


def _bent(
    each: list[tuple[MidRadius, MidRadius, MidRadius]], first: int, last: int
) -> tuple[Floats, Floats, Floats]:
    result = []
    for k in range(3):
        begin, end = (each[s][k] for s in (first, last))
        most = np.zeros(begin.middle.shape)
        size = np.abs(begin.middle) + np.abs(end.middle)
        wide = np.maximum(begin.radius, end.radius)
        for s in range(first + 1, last):
            share, here = (s - first) / (last - first), each[s][k]
            off = np.abs(here.middle - (1 - share) * begin.middle - share * end.middle)
            off += here.radius + wide + 8 * ROUNDED * (size + np.abs(here.middle))
            most = np.maximum(most, off * OUTWARD)
        result.append(most)
    return result[0], result[1], result[2]


def forgets(A: Floats, x: Floats, left: float, longest: int) -> int:
    """Samples, at most so many, until a share of pushes ``x`` is left, were A the same always."""
    scale, later = np.zeros(len(A)), x
    for _ in range(200):
        scale, later = scale + np.abs(later).sum(axis=1), A @ later
    scale += 1e-9 * scale.max()
    first = 0.0
    for age in range(longest):
        size = float((np.abs(x).sum(axis=1) / scale).max())
        first, x = max(first, size), A @ x
        if size < left * first:
            return age
    return longest
