"""The filter's statements against adversaries, a hundred thousand trials each, and a stop in time.

``python -m benchmarks.filter_trials [--quick] [--only WORDS] [--out benchmarks/results.md]``;
``--only`` runs the statements with these words in their titles, and keeps the page's other rows.
The filter is the C of its package; bases and adversaries are the tests' own, integrated exactly
between all instants at which something changes. Where both axes are scaled by one factor, a
command that does not keep the curvature counts as a break. Then each hypothesis is broken by 5 %
(or by the least that can be: one loss, a lag), and the runs that leave the limit are counted: a
statement whose hypotheses may be broken unnoticed would say nothing.

Bases that are told limits and free distances while they drive have tables of their own: drives
within all bounds and beyond one of them, of the bases of a governor and of a clip, drives behind
formulas that are wrong, and beside other rules.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.parts import page_parser, renew

from .altered import ALTERED
from .compiled import Statement
from .statements import STATEMENTS, refusals
from .stopping import (
    FAMILIES,
    RAMP_TEETH,
    RAMPS,
    RULES,
    TEETH,
    Found,
    bitten,
    bitten_ramps,
    breaks,
    compared,
    drives,
)

TRIALS, BROKEN_TRIALS = 100_000, 2_000
DRIVES, BITTEN, WRONG, RULED = 20_000, 500, 2_000, 400
"""Drives of each base; of each broken bound and kind; of each wrong formula; of each rule."""


def row(statement: Statement, share: int) -> list[str]:
    """Cells of a statement: the largest |v|/V inside, then that of each broken hypothesis."""
    found = statement.inside(TRIALS // share, 1)
    if (found > 1).any():
        raise SystemExit(f"{statement.title}: {np.sum(found > 1)} trials broke the limit")
    teeth = []
    for number, (name, run) in enumerate(statement.broken.items()):
        worst = run(BROKEN_TRIALS // share, 100 + number)
        teeth.append(f"{name} {np.mean(worst > 1):.0%} ({worst.max():.4f})")
    return [f"{found.max():.9f}", ", ".join(teeth)]


def stops(name: str, share: int) -> list[str]:
    """Cells of a base within its bounds; SystemExit if a drive breaks one of the promises."""
    found = drives(FAMILIES[name], DRIVES // share, 1)
    for what, broken in breaks(found).items():
        if broken.any():
            raise SystemExit(f"{name}: {broken.sum()} drives {what}")
    waits = found["waits"].max()
    return [
        f"{len(found['gap']):,}", f"{1e3 * found['gap'].min():.3f} mm",
        f"{found['used'].max():.1%}", f"{waits:.0%}" if waits else "",
    ]  # fmt: skip


def ramps(name: str, share: int) -> list[str]:
    """Cells of a base that slows down, within its bounds; SystemExit if a drive breaks them."""
    found = drives(RAMPS[name], DRIVES // share, 1)
    for what, broken in breaks(found).items():
        if broken.any():
            raise SystemExit(f"{name}: {broken.sum()} drives {what}")
    return [
        f"{len(found['gap']):,}", f"{1e3 * found['gap'].min():.3f} mm", f"{found['over'].max():.9f}"
    ]  # fmt: skip


def ramp_shares(name: str, share: int) -> list[str]:
    """Shares of drives of a base beyond one of its bounds that touch, or are too fast."""
    found = bitten_ramps(name, BITTEN // min(share, 5), 1)
    broken = breaks(found)
    return [f"{np.mean(broken[what]):.1%}" for what in ("touch", "fast")]


def shares(found: Found) -> list[str]:
    """Shares of drives with each kind of break."""
    return [f"{np.mean(broken):.1%}" if broken.any() else "" for broken in breaks(found).values()]


def beside(name: str, share: int) -> list[str]:
    """Cells of the filter and other rules on bases by chance."""
    found = compared(name, RULED // min(share, 4))
    touched, least = found.approach
    tuned = "none up to 12 s"
    if found.tuned:
        horizon, gap, worst = found.tuned
        tuned = f"{horizon:g} s: {1e3 * gap:.0f} mm ({worst:.0%})"
    return [
        f"{1e3 * found.filtered[0]:.0f} mm", f"{1e3 * found.filtered[1]:.0f} mm",
        f"{touched:.0%} ({1e3 * least:.0f} mm)", tuned, f"{found.root:.0%}",
    ]  # fmt: skip


@dataclass(frozen=True)
class Table:
    """Table of the page: its columns, and a function for the cells of each row."""

    columns: Sequence[str]
    rows: Mapping[str, Callable[[int], Sequence[str]]]


def _by(
    make: Callable[[str, int], list[str]], names: Sequence[str]
) -> Mapping[str, Callable[[int], list[str]]]:
    return {name: lambda share, name=name: make(name, share) for name in names}


TOUCHES = ("touch", "beyond a limit", "late", "stuck")
TABLES: Mapping[str, Table] = {
    "trials": Table(
        ("statement", "largest \\|v\\|/V", f"broken by 5 %: share of {BROKEN_TRIALS:,} trials "
         "beyond the limit (largest \\|v\\|/V)"),
        {item.title: lambda share, item=item: row(item, share) for item in STATEMENTS},
    ),
    "stops": Table(
        ("base", "drives", "least gap", "time for a lowered limit, used", "longest wait"),
        _by(stops, list(FAMILIES)),
    ),
    "stops-broken": Table(
        ("10 % beyond its bound", *TOUCHES),
        _by(lambda name, share: shares(bitten(name, BITTEN // min(share, 10), 1)), list(TEETH)),
    ),
    "ramps": Table(
        ("base that slows down", "drives", "least gap", "largest \\|v\\|/V"),
        _by(ramps, list(RAMPS)),
    ),
    "ramps-broken": Table(
        ("10 % beyond its bound", "touch", "beyond a limit"), _by(ramp_shares, list(RAMP_TEETH))
    ),
    "stops-altered": Table(
        ("wrong formula", *TOUCHES),
        _by(lambda name, share: shares(ALTERED[name].found(WRONG // min(share, 4), 1)),
            list(ALTERED)),
    ),
    "stops-beside": Table(
        ("base", "filter, `leave = 0`", "`leave = 1`", "approach, 1.2 s: touch (least gap)",
         "its least horizon without a touch: gap (worst bases that touch)", "sqrt(2 a d): touch"),
        _by(beside, RULES),
    ),
}  # fmt: skip


def rows_of(page: Path, name: str) -> dict[str, str]:
    """Rows of a table on the page, by their first cell."""
    part = page.read_text(encoding="utf-8").partition(f"<!-- begin {name} -->")[2]
    rows = part.partition(f"<!-- end {name} -->")[0].splitlines()
    return {line.split("|")[1].strip(): line for line in rows if line.startswith("|")}


def main(arguments: Sequence[str] | None = None) -> None:
    """Run all trials, print the tables, and with ``--out`` renew their parts of the page."""
    parser = page_parser(__doc__, "a hundredth of the trials")
    parser.add_argument("--only", default="", metavar="WORDS", help="statements with these words")
    given = parser.parse_args(arguments)
    share = 100 if given.quick else 1
    for name, table in TABLES.items():
        known = rows_of(given.out, name) if given.out else {}
        lines = [f"| {' | '.join(table.columns)} |", f"|{'---|' * len(table.columns)}"]
        for title, cells in table.rows.items():
            if given.only not in title:
                lines += [known[title]] if title in known else []
                continue
            begin = time.monotonic()
            lines.append(f"| {' | '.join([title, *cells(share)])} |")
            print(f"{lines[-1]}  {time.monotonic() - begin:.0f} s", flush=True)
        if given.out:
            renew(given.out, name, "\n".join(lines))
    if given.out:
        renew(given.out, "refused", refusals())


if __name__ == "__main__":
    main()
