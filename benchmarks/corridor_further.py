"""The certified corridor against further adversaries, each with a loop of its own.

``python -m benchmarks.corridor_further [--quick] [--out PAGE]``: a table of benchmarks/results.md.
Bases that take velocities, commands that take over when it hurts, poses that are lost
(`benchmarks.corridor_cases`). A row has the largest distance with worst signs at the bound and a
fifth beyond it, and the multiple of the bound from which on a loop leaves the corridor.
"""

from __future__ import annotations

from collections.abc import Sequence

from benchmarks.corridor_cases import ROWS
from benchmarks.parts import millimetres, page_parser, renew
from wmr_ctrl.theory.corridor import find_corridor

NAME = "corridor further"
"""Name of the page's part that this module writes."""
HEAD = ("case (mm)", "certified", "adversary", "ratio", "a fifth beyond", "leaves", "leaves from")
FIFTH, FINE = 1.2, 0.01
"""A bound exceeded by a fifth, and the step by which it is exceeded until a loop leaves."""


def row(words: str) -> str:
    """One line of the table; SystemExit if a run within its bounds is outside."""
    case = ROWS[words]()
    most = find_corridor(case.scenario, case.law).position or 0.0
    first, beyond = case.reach(1.0), case.reach(FIFTH)
    if first > most:
        raise SystemExit(f"{words}: a run left the corridor")
    times = max(1.0, FINE * int(most / first / FINE))
    while case.reach(times) <= most:
        times += FINE
    left = "yes" if beyond > most else "no"
    led, farther = (f"{1e3 * x:.2f}" for x in (first, beyond))
    cells = [words, millimetres(most), led, f"{most / first:.2f}", farther, left, f"{times:.2f}"]
    return f"| {' | '.join(cells)} |"


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the table, and with ``--out`` renew it."""
    given = page_parser(__doc__, "two cases").parse_args(arguments)
    rows = []
    for words in list(ROWS)[: 2 if given.quick else None]:
        rows.append(row(words))
        print(rows[-1], flush=True)
    if given.out:
        renew(
            given.out, NAME, "\n".join([f"| {' | '.join(HEAD)} |", "|---" * len(HEAD) + "|", *rows])
        )


if __name__ == "__main__":
    main()
