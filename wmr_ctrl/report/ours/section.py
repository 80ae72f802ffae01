"""Everything that the section's template shows."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from wmr_ctrl.report.drawing import Drawing
from wmr_ctrl.report.ours.bounds import price_table
from wmr_ctrl.report.ours.findings import findings
from wmr_ctrl.report.ours.rows import BASE, Rows
from wmr_ctrl.report.ours.shortfalls import ADVERSARY, shortfalls
from wmr_ctrl.report.ours.tables import our_tables


def our_section(rows: Rows, drawings: Sequence[Drawing]) -> dict[str, Any]:
    """Counts, sentences, tables and figures."""
    priced = tuple(
        (base, factor)
        for factor in (BASE, ADVERSARY)
        for base in rows.bases
        if factor in rows.factors(base)
    )
    return {
        "runs": len(rows.all),
        "seeds": ", ".join(map(str, rows.seeds)),
        "findings": findings(rows),
        "shortfalls": shortfalls(rows),
        "price": price_table(priced) if priced else None,
        "tables": {base: our_tables(rows, base) for base in rows.bases},
        "drawings": drawings,
    }
