"""Some samples of a passage at once: what their rows make of all that disturbs them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wmr_ctrl.checks.loop import IntArray
from wmr_ctrl.checks.world import COMMAND, Floats
from wmr_ctrl.corridor.inputs import Inputs
from wmr_ctrl.corridor.stretch import Stretch


@dataclass(frozen=True)
class FollowedBlock:
    """J samples at the places ``at`` of a stretch.

    ``chain`` (J + 1, n, n): products of matrices until each sample and until the end.  ``inner``
    (J, rows, n): rows of each sample by the state at which it begins.  ``columns`` (n, m): what the
    samples add, at the end; ``ends``: of the known ones, discs' pairs, the law's force, and boxes.
    ``after_by`` and ``inner_by`` (J, rows, m): sizes of rows of these, at the end of each sample,
    and at its beginning.
    """

    at: IntArray
    chain: Floats
    inner: Floats
    columns: Floats
    ends: IntArray
    after_by: Floats
    inner_by: Floats


def inputs_of(here: Stretch, inputs: Inputs, at: IntArray) -> tuple[Floats, Floats]:
    """Columns (..., n, m) of what disturbs samples, and pairs of a disc."""
    by_law, push, seen = (getattr(here, name).middle[at] for name in ("law", "push", "seen"))
    known = push * inputs.push
    if inputs.velocity.any():
        known = np.concatenate([known, by_law @ seen[..., 3:] * inputs.velocity], axis=-1)
    return known, by_law @ seen[..., : COMMAND if inputs.pose else 0] * inputs.pose


def blocks_of(
    here: Stretch, inputs: Inputs, at: IntArray, which: tuple[Floats, Floats, IntArray]
) -> list[FollowedBlock]:
    """Of the places ``at`` (blocks, J).

    ``which``: rows (r, n) of the state and of the fast state, and which of the law's outputs.
    """
    rows, knot_rows, outputs = which
    A, law = here.A.middle[at], here.law.middle[at]
    many, count, n = A.shape[:3]
    known, misled = inputs_of(here, inputs, at)
    added = [known, misled, law[..., :COMMAND], np.broadcast_to(np.eye(n), A.shape)]
    ends = np.cumsum([count * item.shape[-1] for item in added])
    knots = (knot_rows @ knot.state.middle[at] for knot in here.knots[1:])
    inner = np.concatenate([here.outputs.middle[at][:, :, outputs], *knots], axis=2)
    columns = np.zeros((many, n, ends[-1]))
    chain = np.empty((many, count + 1, n, n))
    chain[:, 0] = np.eye(n)
    after_by, inner_by = (np.zeros((many, count, r, ends[-1])) for r in (len(rows), inner.shape[2]))
    for j in range(count):
        if j:
            np.matmul(inner[:, j], columns, out=inner_by[:, j])
        columns = A[:, j] @ columns
        for first, item in zip((0, *ends[:-1]), added, strict=True):
            width = item.shape[-1]
            place = slice(first + j * width, first + (j + 1) * width)
            columns[:, :, place] = item[:, j]
        np.matmul(rows, columns, out=after_by[:, j])
        np.matmul(A[:, j], chain[:, j], out=chain[:, j + 1])
    for part in (after_by, inner_by):
        np.abs(part, out=part)
    return [
        FollowedBlock(at[k], chain[k], inner[k], columns[k], ends, after_by[k], inner_by[k])
        for k in range(many)
    ]
