"""Blocks: several samples of a flowpipe, and the effect of disturbances on their outputs."""

from dataclasses import dataclass

import numpy as np

from wmr_ctrl.theory.checks.error_coordinates import COMMAND, Floats
from wmr_ctrl.theory.checks.loop import IntArray

from .inputs import Inputs
from .loop import MOST_NUMBERS, UP
from .midradius import MidRadius, rounding
from .stretch import Stretch

DOT = rounding(MOST_NUMBERS)
"""Share by which a sum of products over a state can err."""


@dataclass(frozen=True)
class FollowedBlock:
    """J samples at the indices ``at`` of a stretch.

    ``chain`` (J + 1, n, n): products of matrices until each sample and until the end.  ``inner``
    (J, rows, n): rows of each sample as functions of the state at its beginning.  ``columns`` (n,
    J, w): each sample's generators at the end of the block: known disturbances, from the second of
    ``ends`` on a disc's pair, from the third the law's force, then boxes.  ``by`` (J times all
    rows, j w): responses of the rows at the end and at the beginning of sample j to the generators
    of the first j samples.

    Independent of the deviations: ``ahead`` (J, all rows, n): rows at the end and at the beginning
    of each sample as functions of the state before the block; ``own`` (J, all rows): their sizes
    due to the sample's disturbances.  ``wide`` (J, outputs, n): error of the law's linear part per
    unit of the state; ``direct``: its error due to measurement errors.  For boxes: ``box`` (J, n),
    and contributions of the state and the law.
    """

    at: IntArray
    chain: Floats
    inner: Floats
    columns: Floats
    ends: tuple[int, int]
    by: list[Floats]
    ahead: Floats
    own: Floats
    wide: Floats
    direct: Floats
    box_by_state: Floats
    box_by_law: Floats
    box: Floats


def inputs_of(here: Stretch, inputs: Inputs, at: IntArray) -> tuple[Floats, Floats]:
    """Columns (..., n, m) of the disturbances of samples, and the pairs of a disc."""
    by_law, push, seen = (getattr(here, name).middle[at] for name in ("law", "push", "seen"))
    known = push * inputs.push
    if inputs.velocity.any():
        known = np.concatenate([known, by_law @ seen[..., 3:] * inputs.velocity], axis=-1)
    return known, by_law @ seen[..., : COMMAND if inputs.pose else 0] * inputs.pose


def blocks_of(
    here: Stretch, inputs: Inputs, at: IntArray, which: tuple[Floats, Floats, IntArray]
) -> list[FollowedBlock]:
    """Blocks of the samples at the indices ``at`` (blocks, J) of a stretch.

    ``which``: rows (r, n) of the state and of the fast state, and indices of the law's outputs.
    """
    rows, knot_rows, outputs = which
    A, law = here.A.middle[at], here.law.middle[at]
    many, count, n = A.shape[:3]
    known, misled = inputs_of(here, inputs, at)
    ends = known.shape[-1], known.shape[-1] + misled.shape[-1]
    unit = np.broadcast_to(np.eye(n), A.shape)
    added = np.concatenate([known, misled, law[..., :COMMAND], unit], axis=-1)
    width = added.shape[-1]
    knots = (knot_rows @ knot.state.middle[at] for knot in here.knots[1:])
    inner = np.concatenate([here.outputs.middle[at][:, :, outputs], *knots], axis=2)
    columns, chain = np.zeros((many, n, count * width)), np.empty((many, count + 1, n, n))
    chain[:, 0] = np.eye(n)
    by = list[Floats]()
    own = np.zeros((many, count, len(rows) + inner.shape[2]))
    for j in range(count):
        old, new = slice(j * width), slice((j + 1) * width)
        reach = np.zeros((many, own.shape[2], (j + 1) * width))
        if j:
            np.matmul(inner[:, j], columns[..., old], out=reach[:, len(rows) :, old])
            columns[..., old] = A[:, j] @ columns[..., old]
        columns[..., j * width : (j + 1) * width] = added[:, j]
        np.matmul(rows, columns[..., new], out=reach[:, : len(rows)])
        np.matmul(A[:, j], chain[:, j], out=chain[:, j + 1])
        by.append(np.abs(reach, out=reach))
        sizes = reach.reshape(many, -1, j + 1, width)
        own[:, j] = sizes[..., : ends[0]].sum(axis=(-1, -2))
        if misled.size:
            own[:, j] += np.hypot(*np.moveaxis(sizes[..., slice(*ends)], -1, 0)).sum(axis=-1)
    parts = {
        "at": at, "chain": chain, "inner": inner, "own": own,
        "columns": columns.reshape(many, n, count, width),
        "ahead": np.concatenate([rows @ chain[:, 1:], inner @ chain[:, :-1]], axis=2),
        **_wide(here, inputs, at, outputs),
    }  # fmt: skip
    each = ({name: part[k] for name, part in parts.items()} for k in range(many))
    parted = ([reach[k] for reach in by] for k in range(many))
    return [
        FollowedBlock(ends=ends, by=own, **item) for own, item in zip(parted, each, strict=True)
    ]


def _wide(here: Stretch, inputs: Inputs, at: IntArray, which: IntArray) -> dict[str, Floats]:
    """Contributions of the matrices' radii and of rounding at some indices."""
    A, law, outputs, push, seen = (
        MidRadius(part.middle[at], part.radius[at])
        for part in (here.A, here.law, here.outputs, here.push, here.seen)
    )
    wide_law, error = law.radius + DOT * np.abs(law.middle), inputs.measured
    direct = seen.most @ error * UP
    box = each(law.most, (seen.radius + DOT * np.abs(seen.middle)) @ error)
    box += (push.radius + DOT * np.abs(push.middle)) @ inputs.push + each(wide_law, direct)
    beside = np.abs(law.middle)
    beside[..., :COMMAND] = 0
    return {
        "wide": (outputs.radius + DOT * np.abs(outputs.middle))[..., which, :], "direct": direct,
        "box_by_state": A.radius + DOT * np.abs(A.middle), "box_by_law": wide_law + beside,
        "box": box,
    }  # fmt: skip


def each(matrices: Floats, vectors: Floats) -> Floats:
    """Products of matrices (..., m, n), or of one, with vectors (..., n)."""
    return np.asarray((matrices @ vectors[..., None])[..., 0])
