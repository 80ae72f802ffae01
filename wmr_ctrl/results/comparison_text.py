"""A comparison of two runs as plain text for a terminal."""

from __future__ import annotations

from collections.abc import Sequence
from textwrap import fill
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from wmr_ctrl.results.compare import ColumnDifference, Comparison

_LINE = 88
"""Width of wrapped text, in characters."""

_WIDTH = 42
"""Longest value of a fact that is shown whole; a scenario's text is not."""


def comparison_text(comparison: Comparison) -> str:
    """Facts that differ, columns that differ, notes, and the verdict as the last line."""
    parts = (
        _facts(comparison),
        _columns(comparison.columns),
        "\n".join(comparison.notes),
        _closing(comparison),
    )
    return "\n\n".join(part for part in parts if part)


def _facts(comparison: Comparison) -> str:
    if not comparison.facts:
        return ""
    rows = [(fact.name, _short(fact.in_a), _short(fact.in_b)) for fact in comparison.facts]
    return _aligned([("differs", "first run", "second run"), *rows])


def _columns(columns: Sequence[ColumnDifference]) -> str:
    differing = [column for column in columns if column.largest > 0]
    equal = [column.name for column in columns if column.largest == 0]
    rows = [
        (c.name, c.unit, f"{c.largest:.3g}", f"{c.time:.6g}", f"{c.relative:.3g}")
        for c in differing
    ]
    header = ("column", "unit", "largest difference", "at t [s]", "of its range")
    table = _aligned([header, *rows]) if rows else ""
    same = fill(f"No difference in {', '.join(equal)}.", _LINE) if equal else ""
    return "\n\n".join(part for part in (table, same) if part)


def _closing(comparison: Comparison) -> str:
    span = f"{comparison.rows} shared samples of {len(comparison.columns)} shared columns"
    return {
        "equal": f"EQUAL: no value differs in {span}.",
        "agree": f"AGREE to {comparison.tolerance:g}: {span}, no value farther apart than that.",
        "differ": f"DIFFER {_manner(comparison)}: {span}.",
        "nothing shared": "NOTHING SHARED: the runs have no sample in common.",
    }[comparison.verdict]


def _manner(comparison: Comparison) -> str:
    if all(column.within(comparison.tolerance) for column in comparison.columns):
        return "in their outcome, though no value differs by more than the tolerance"
    return f"by more than {comparison.tolerance:g}"


def _short(value: str) -> str:
    line = " ".join(value.split())
    return line if len(line) <= _WIDTH else f"{line[: _WIDTH - 3]}..."


def _aligned(rows: Sequence[Sequence[str]]) -> str:
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    lines = (
        "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip()
        for row in rows
    )
    return "\n".join(lines)
