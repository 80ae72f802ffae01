"""Comparison of two runs: differences of columns and of properties."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from itertools import zip_longest
from textwrap import fill
from typing import Any, Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from wmr_ctrl.core.errors import ArgumentError
from wmr_ctrl.core.fields.arguments import checks_arguments
from wmr_ctrl.core.fields.orientation import ORIENTATIONS, inward

from .run import Floats, Run

Verdict: TypeAlias = Literal["equal", "agree", "differ", "nothing shared"]

_ABSENT = "(absent)"
_TICK = 1e-9
"""Runs of different control periods are matched at sample times on a grid this fine [s]."""
_LINE = 88
"""Width of wrapped text, in characters."""
_WIDTH = 42
"""Longest value of a fact that is shown whole; a scenario's text is not."""


@dataclass(frozen=True)
class Fact:
    """A property that differs between two runs: its name, and both values as text."""

    name: str
    in_a: str
    in_b: str


@dataclass(frozen=True)
class ColumnDifference:
    """Difference of one logged number in two runs, over the samples that they share.

    ``largest`` [unit] is the largest absolute difference, inf where only one of the two is finite
    or an infinity changes its sign; ``time`` [s] its first occurrence; ``relative`` is it divided
    by the range that the finite values of both runs span.
    """

    name: str
    unit: str
    largest: float
    time: float
    relative: float

    def within(self, tolerance: float) -> bool:
        """True if the difference is at most ``tolerance``, in the unit or relative to the range."""
        return min(self.largest, self.relative) <= tolerance


@dataclass(frozen=True)
class Comparison:
    """Two runs side by side.

    ``columns``: one entry per number that both runs log, empty if they share no sample; ``rows``:
    number of samples that they share; ``facts``: labels, settings, readings and provenance that
    differ; ``notes``: sentences on omitted columns and samples; ``verdict``: "equal" (no shared
    value differs), "agree" (each within ``tolerance``), "differ" or "nothing shared".
    """

    columns: tuple[ColumnDifference, ...]
    rows: int
    facts: tuple[Fact, ...]
    notes: tuple[str, ...]
    tolerance: float
    verdict: Verdict

    def __str__(self) -> str:
        return comparison_text(self)


@checks_arguments
def compare(first: Run, second: Run, tolerance: float = 1e-9) -> Comparison:
    """Compare the common columns and samples of two runs, and list other differences.

    ``tolerance`` is absolute in a column's own unit or relative to its range, whichever is larger.
    Runs whose outcomes differ over the same samples differ, however close their columns are.
    Raises ArgumentError for a tolerance that is negative or not a number.
    """
    if not tolerance >= 0:
        raise ArgumentError(f"tolerance = {tolerance!r} must be zero or a positive number.")
    rows_a, rows_b = _shared_rows(first, second)
    columns = tuple(
        _difference(signal.name, first, second, rows_a, rows_b)
        for signal in first.elements
        if signal.name in second and len(rows_a)
    )
    facts = differing_facts(first, second, tolerance)
    same_span = len(rows_a) == first.rows == second.rows
    verdict = _verdict(columns, tolerance, same_span and first.outcome != second.outcome)
    notes = tuple(_notes(first, second, len(rows_a)))
    return Comparison(columns, len(rows_a), facts, notes, tolerance, verdict)


def _shared_rows(run_a: Run, run_b: Run) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    if run_a.settings.control == run_b.settings.control:
        rows = np.arange(min(run_a.rows, run_b.rows))
        return rows, rows
    ticks_a, ticks_b = (np.rint(run.time / _TICK).astype(np.int64) for run in (run_a, run_b))
    _, rows_a, rows_b = np.intersect1d(ticks_a, ticks_b, assume_unique=True, return_indices=True)
    return rows_a, rows_b


def _difference(
    name: str, run_a: Run, run_b: Run, rows_a: NDArray[np.intp], rows_b: NDArray[np.intp]
) -> ColumnDifference:
    a, b = run_a[name][rows_a], run_b[name][rows_b]
    if name in ORIENTATIONS:  # the runs may count them differently
        a, b = inward(a, run_a.settings.frames), inward(b, run_b.settings.frames)
    gaps = _gaps(a, b)
    row = int(np.argmax(gaps))
    largest = relative = float(gaps[row])
    if 0 < largest < math.inf:
        finite = np.concatenate((a, b))[np.isfinite(np.concatenate((a, b)))]
        span = float(np.max(finite)) - float(np.min(finite))
        relative = largest / span if math.isfinite(span) else math.inf
    time = float(run_a.time[rows_a][row])
    return ColumnDifference(name, run_a.signal(name).unit, largest, time, relative)


def _gaps(a: Floats, b: Floats) -> Floats:
    """|a - b| by element: 0 for equal values (NaN equals NaN), inf for one finite, one not."""
    same = (a == b) | (np.isnan(a) & np.isnan(b))
    comparable = np.isfinite(a) & np.isfinite(b) & ~same
    with np.errstate(over="ignore"):
        gaps = np.abs(np.subtract(a, b, out=np.zeros_like(a), where=comparable))
    return np.where(same | comparable, gaps, np.inf)


def _verdict(
    columns: tuple[ColumnDifference, ...], tolerance: float, outcomes_differ: bool
) -> Verdict:
    if not columns:
        return "nothing shared"
    if outcomes_differ or not all(column.within(tolerance) for column in columns):
        return "differ"
    return "agree" if any(column.largest > 0 for column in columns) else "equal"


def _notes(run_a: Run, run_b: Run, shared: int) -> Iterator[str]:
    """Sentences on omitted columns and samples."""
    for label, run, other in (("first", run_a, run_b), ("second", run_b, run_a)):
        alone = [signal.name for signal in run.elements if signal.name not in other]
        if alone:
            yield f"Only the {label} run logs {', '.join(alone)}."
    if not shared == run_a.rows == run_b.rows:
        yield (
            f"The first run has {run_a.rows} samples and the second {run_b.rows}; "
            f"they share {shared}, and only these are compared."
        )


def differing_facts(run_a: Run, run_b: Run, tolerance: float) -> tuple[Fact, ...]:
    """Labels, settings, monitor's readings and provenance that differ.

    Numbers that differ by at most ``tolerance``, times their size above 1, count as equal.
    """
    a, b = dict(_facts(run_a)), dict(_facts(run_b))
    names = list(dict.fromkeys((*a, *b)))
    return tuple(
        Fact(name, str(a.get(name, _ABSENT)), str(b.get(name, _ABSENT)))
        for name in names
        if not _same(a.get(name, _ABSENT), b.get(name, _ABSENT), tolerance)
    )


def _facts(run: Run) -> Iterator[tuple[str, Any]]:
    for name in ("scenario", "law", "guard", "seed", "engine"):
        yield name, getattr(run, name)
    yield "outcome", run.outcome.value
    groups = {"settings": asdict(run.settings), "monitor": asdict(run.monitor)}
    for group, values in {**groups, "provenance": run.provenance}.items():
        yield from ((f"{group}.{key}", value) for key, value in values.items())


def _same(a: Any, b: Any, tolerance: float) -> bool:
    if isinstance(a, tuple) and isinstance(b, tuple):
        return all(_same(x, y, tolerance) for x, y in zip(a, b, strict=True))
    if isinstance(a, float) and isinstance(b, float):
        close = abs(a - b) <= tolerance * max(1.0, min(abs(a), abs(b)))
        return a == b or (math.isnan(a) and math.isnan(b)) or close
    return bool(a == b)


def comparison_text(comparison: Comparison) -> str:
    """Facts that differ, columns that differ, notes, and the verdict as the last line."""
    facts = [(fact.name, _short(fact.in_a), _short(fact.in_b)) for fact in comparison.facts]
    rows = [
        (c.name, c.unit, f"{c.largest:.3g}", f"{c.time:.6g}", f"{c.relative:.3g}")
        for c in comparison.columns
        if c.largest > 0
    ]
    equal = [column.name for column in comparison.columns if column.largest == 0]
    parts = (
        aligned(("differs", "first run", "second run"), facts),
        aligned(("column", "unit", "largest difference", "at t [s]", "of its range"), rows),
        fill(f"No difference in {', '.join(equal)}.", _LINE) if equal else "",
        "\n".join(fill(note, _LINE) for note in comparison.notes),
        _closing(comparison),
    )
    return "\n\n".join(part for part in parts if part)


def _closing(comparison: Comparison) -> str:
    span = f"{comparison.rows} shared samples of {len(comparison.columns)} shared columns"
    manner = f"by more than {comparison.tolerance:g}"
    if all(column.within(comparison.tolerance) for column in comparison.columns):
        manner = "in their outcome, though no value differs by more than the tolerance"
    return {
        "equal": f"EQUAL: no value differs in {span}.",
        "agree": f"AGREE to {comparison.tolerance:g}: {span}, no value farther apart than that.",
        "differ": f"DIFFER {manner}: {span}.",
        "nothing shared": "NOTHING SHARED: they have no sample in common.",
    }[comparison.verdict]


def _short(value: str) -> str:
    line = " ".join(value.split())
    return line if len(line) <= _WIDTH else f"{line[: _WIDTH - 3]}..."


def aligned(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table with columns of one width; empty without rows. A row may lack its last cells."""
    columns = zip_longest(head, *rows, fillvalue="")
    widths = [max(map(len, column)) for column in columns]
    lines = (
        "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=False)).rstrip()
        for row in (head, *rows)
    )
    return "\n".join(lines) if rows else ""
