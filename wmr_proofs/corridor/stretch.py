"""Matrices of some samples along a motion, in spans: of a whole sample, and of times within it."""

from dataclasses import dataclass

import numpy as np

from wmr_ctrl.theory.checks.error_coordinates import COMMAND, ROBOT, Floats

from .midradius import OUTWARD, ROUNDED, SMALLEST, MidRadius, rounding
from .motion import MovingLoop
from .secants import Secants


@dataclass(frozen=True)
class Within:
    """Rows at a time within samples: the fast state as a function of the state, a push, an added
    command.

    ``apart`` (3): largest distances of such rows from the chord to the next such time.
    """

    state: MidRadius
    push: MidRadius
    command: MidRadius
    apart: tuple[Floats, ...]


@dataclass(frozen=True)
class Stretch:
    """Samples of a motion, along the first axis of all arrays.

    ``A`` (n, n): the state a sample later.  ``push`` (n, 2), ``law`` (n, outputs): effects of
    disturbances and of additions to the law's outputs on it.  ``outputs`` (outputs, n): the law's
    linear part; ``seen`` (outputs, 5): the same for measurements.  ``steps`` (fast, fast): sizes by
    which increments of plant steps add up.  ``body`` (fast, 2): effect of mass and inertia on a
    plant step.  ``secants``: those of law and plant step, if these are not gradients at points.
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
    """Compose a Stretch from the slopes of law and plant step; ``knots`` begin with 0."""
    nz, nq, nm, na = len(loop.names), COMMAND * loop.queue, loop.memory, loop.acting
    n, count = nz + nq + nm + na, len(law.middle)
    order = [*range(ROBOT), *range(nz + nq, nz + nq + nm), *range(nz, nz + nq), *range(n - na, n)]
    outputs = MidRadius(*(_placed(part, order, n) for part in (law.middle, law.radius)))
    behind, rest = divmod(loop.late, loop.steps)
    ages = [n, *range(nz, nz + nq, COMMAND)]  # the state, then an added command, then a push
    acting = [ages[behind + (s < rest)] for s in range(loop.steps)]
    course = _course(step[:, :, : nz + 2 * COMMAND], n, acting)
    now, size, sums = course[:, loop.steps], step[:, :, :nz].most, np.zeros((count, nz, nz))
    for _ in range(loop.steps):
        sums = (size @ sums) * (1 + rounding(nz)) + np.eye(nz)
    widths = n, outputs.middle.shape[1], COMMAND
    rows, by_law, push = (MidRadius(*np.zeros((2, count, n, width))) for width in widths)
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
    closed, between = _closed(course, outputs, n), zip(knots, [*knots[1:], loop.steps], strict=True)
    return Stretch(
        rows + by_law @ outputs, push, by_law, outputs, law[:, :, :ROBOT], sums,
        step[:, :, -COMMAND:].most, [_within(closed, n, a, b) for a, b in between],
    )  # fmt: skip


def _placed(part: Floats, order: list[int], n: int) -> Floats:
    result = np.zeros((*part.shape[:2], n))
    result[:, :, order] = part
    return result


def _course(step: MidRadius, n: int, acting: list[int]) -> MidRadius:
    """Rows (J, steps + 1, nz, n + 4) of the fast state by the state, an added command and a push.

    ``step`` (J, nz, nz + 4): by the fast state, command and push; ``acting``: the column of the
    command that acts in each step.
    """
    count, nz, wide = step.middle.shape
    columns, share = n + 2 * COMMAND, rounding(wide)
    now, off = np.zeros((2, count, wide, columns))
    now[:, :nz] = np.eye(nz, columns)
    now[:, nz + COMMAND :, n + COMMAND :] = np.eye(COMMAND)
    middle, radius = np.zeros((2, count, len(acting) + 1, nz, columns))
    middle[:, 0] = now[:, :nz]
    sizes = np.abs(step.middle)
    both = np.concatenate([sizes + step.radius, share * sizes + step.radius], axis=2) * OUTWARD
    for s, at in enumerate(acting):
        now[:, nz : nz + COMMAND] = np.eye(COMMAND, columns, at)
        wider = both @ np.concatenate([off, np.abs(now)], axis=1)
        now[:, :nz] = step.middle @ now
        off[:, :nz] = wider * ((1 + 2 * share) * OUTWARD) + SMALLEST
        middle[:, s + 1], radius[:, s + 1] = now[:, :nz], off[:, :nz]
    return MidRadius(middle, radius)


def _closed(course: MidRadius, outputs: MidRadius, n: int) -> MidRadius:
    """Rows of the fast state by the state alone, with the law's command substituted."""
    shape, command = course.middle.shape, slice(n, n + COMMAND)
    middle, radius = (x.reshape(len(x), -1, shape[-1]) for x in (course.middle, course.radius))
    law, share = outputs[:, :COMMAND], rounding(COMMAND + 1)
    both = np.concatenate([np.abs(middle[:, :, command]), radius[:, :, command]], axis=2)
    sizes = np.concatenate([law.radius + share * np.abs(law.middle), law.most], axis=1) * OUTWARD
    middle[:, :, :n] += middle[:, :, command] @ law.middle
    radius[:, :, :n] += both @ sizes
    radius[:, :, :n] += ROUNDED * np.abs(middle[:, :, :n]) + SMALLEST
    radius *= OUTWARD
    return MidRadius(middle.reshape(shape), radius.reshape(shape))


def _within(course: MidRadius, n: int, first: int, last: int) -> Within:
    """Rows from the beginning of plant step ``first`` to that of ``last``.

    The values at the chord's ends and the distance from the chord bound the inner points.
    """
    begin, end, inner = (course[:, place] for place in (first, last, slice(first + 1, last)))
    share = (np.arange(1, last - first) / (last - first))[:, None, None]
    off = inner.middle - (1 - share) * begin.middle[:, None]
    off -= share * end.middle[:, None]
    np.abs(off, out=off)
    off += inner.radius
    most = off.max(axis=1, initial=0.0) * OUTWARD + np.maximum(begin.radius, end.radius)
    most = (most + 16 * ROUNDED * (np.abs(begin.middle) + np.abs(end.middle))) * OUTWARD
    most = np.where(last > first + 1, most, 0.0)
    places = slice(n), slice(n + COMMAND, None), slice(n, n + COMMAND)
    state, push, command = (begin[:, :, place] for place in places)
    return Within(state, push, command, tuple(most[:, :, place] for place in places))


def forgets(A: Floats, x: Floats, left: float, longest: int) -> int:
    """Samples until pushes ``x`` decay to a share ``left`` under A; at most ``longest``."""
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
