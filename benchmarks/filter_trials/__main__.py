"""The filter's statements against adversaries, a hundred thousand trials each.

``python -m benchmarks.filter_trials [--quick] [--only WORDS] [--out benchmarks/results.md]``;
with words only the statements whose titles have them, and the page keeps its other rows.  The
filter is the C of its package; bases and adversaries are the tests' own, integrated exactly between
all instants at which something changes.  Where both axes are scaled by one factor, a command that
does not keep the curvature counts as a break.  Then each hypothesis is broken by 5 % (or by the
least that can be: one loss, a lag), and the runs that leave the limit are counted: a statement
whose hypotheses may be broken unnoticed would say nothing.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from benchmarks.parts import page_parser, renew

from .compiled import Statement
from .statements import STATEMENTS, refusals

NAME = "trials"
TRIALS, BROKEN_TRIALS = 100_000, 2_000


def row(statement: Statement, trials: int, broken: int) -> str:
    """A Markdown row: the largest |v|/V inside, then that of each broken hypothesis."""
    found = statement.inside(trials, 1)
    if (found > 1).any():
        raise SystemExit(f"{statement.title}: {np.sum(found > 1)} trials broke the limit")
    teeth = []
    for number, (name, run) in enumerate(statement.broken.items()):
        worst = run(broken, 100 + number)
        teeth.append(f"{name} {np.mean(worst > 1):.0%} ({worst.max():.4f})")
    return f"| {statement.title} | {found.max():.9f} | {', '.join(teeth)} |"


def rows_of(page: Path) -> dict[str, str]:
    """Rows of the table on the page, by the statement's title."""
    part = page.read_text(encoding="utf-8").partition(f"<!-- begin {NAME} -->")[2]
    rows = part.partition(f"<!-- end {NAME} -->")[0].splitlines()
    return {line.split("|")[1].strip(): line for line in rows if line.startswith("|")}


def main(arguments: Sequence[str] | None = None) -> None:
    """Run all trials, print the table, and with ``--out`` renew its part of the page."""
    parser = page_parser(__doc__, "a hundredth of the trials")
    parser.add_argument("--only", default="", metavar="WORDS", help="statements with these words")
    given = parser.parse_args(arguments)
    share = 100 if given.quick else 1
    lines = [
        "| statement | largest \\|v\\|/V | broken by 5 %: share of "
        f"{BROKEN_TRIALS // share:,} trials beyond the limit (largest \\|v\\|/V) |",
        "|---|---|---|",
    ]
    known = rows_of(given.out) if given.out else {}
    for statement in STATEMENTS:
        if given.only not in statement.title:
            lines += [known[statement.title]] if statement.title in known else []
            continue
        begin = time.monotonic()
        lines.append(row(statement, TRIALS // share, BROKEN_TRIALS // share))
        print(f"{lines[-1]}  {time.monotonic() - begin:.0f} s", flush=True)
    if given.out:
        renew(given.out, NAME, "\n".join(lines))
        renew(given.out, "refused", refusals())


if __name__ == "__main__":
    main()
