"""Which rows belong to a span of time, and whether the run lasted through it."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from wmr_ctrl.results.run import Run

Span = tuple[int, int]
WINDOWS: tuple[Span, ...] = ((30, 40), (40, 45), (70, 80))
"""Before, just after and long after the paper's change of parameters [s]."""
BEFORE, LATE = WINDOWS[0], WINDOWS[-1]


def named(span: Span) -> str:
    """The end of the name of a figure over a window."""
    return f"{span[0]}_{span[1]}"


def window(run: Run, start: float, end: float) -> slice | None:
    """Rows k with ``start`` <= t_k < ``end`` [s], or None where the run does not cover them all.

    Samples are counted, not compared as floats, so that windows that touch share no sample.
    """
    first, last = run.settings.index(start), run.settings.index(end)
    return slice(first, last) if 0 <= first <= last <= covered(run) else None


def span(run: Run, start: float = 0.0, end: float | None = None) -> slice | None:
    """Rows in [``start``, ``end``) [s] as :func:`window` has them; without ``end``, all later rows.

    Without ``end`` it is never None: the rows of a run that ended early simply end earlier.
    """
    if end is not None:
        return window(run, start, end)
    return slice(min(max(0, run.settings.index(start)), run.rows), run.rows)


def covered(run: Run) -> int:
    """Number of whole sample periods that the run lasted.

    A run that ends between two samples has logged the sample before, yet not lived through it.
    """
    if run.monitor.stopped is None:
        return run.rows
    time, _ = run.monitor.stopped
    return min(run.rows, math.floor(time / run.settings.control + 1e-6))
