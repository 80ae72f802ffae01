"""What `wmr-ctrl prove` does: run, print, compare with the committed ledger."""

from __future__ import annotations

import sys
from collections.abc import Iterable
from pathlib import Path

from wmr_ctrl.proofs.ledger import COMMITTED, Entry, Ledger, differences, exit_code, load
from wmr_ctrl.proofs.runner import Progress, prove, selected
from wmr_ctrl.results import atomic_write

REMEDY = (
    "Some entries were not checked; install the proving packages with: "
    "pip install 'wmr_ctrl[proofs]'"
)


def run_prove(
    only: Iterable[str] = (), json_file: Path | None = None, progress: Progress | None = None
) -> int:
    """Check, print a summary, write ``json_file``; the exit code of `ledger.exit_code`."""
    asked = tuple(only)
    ledger = prove(asked, progress)
    committed = load() if COMMITTED.exists() else Ledger(())
    if json_file is not None:
        with atomic_write(json_file, text=True) as stream:
            stream.write(ledger.to_json() + "\n")
    if asked:
        sys.stdout.write("\n".join(map(described, ledger.entries)) + "\n")
    sys.stdout.write("\n".join(summary(ledger, committed, complete=not asked)) + "\n")
    return exit_code(ledger, committed, complete=not asked)


def run_export(folder: Path, only: Iterable[str] = ()) -> None:
    """Write the obligations of the z3 entries that ``only`` names, and say how many."""
    from wmr_ctrl.proofs.export import export

    count = export(folder, selected(tuple(only)))
    sys.stdout.write(f"{count} obligations in {folder}; its README.md says how to check them.\n")


def described(entry: Entry) -> str:
    """All about one entry, as text."""
    point = ", ".join(f"{name} = {value}" for name, value in (entry.counterexample or {}).items())
    rows = {
        "claim": entry.claim,
        "hypotheses": entry.hypotheses,
        "method": entry.method,
        "rests on": ", ".join(entry.premises),
        "counterexample": point,
        "functions": ", ".join(entry.functions),
        "confirmed by": ", ".join(entry.confirmed_by),
    }
    lines = [f"{entry.id}: {entry.verdict}"]
    return "\n".join([*lines, *(f"  {name}: {text}" for name, text in rows.items() if text), ""])


def summary(ledger: Ledger, committed: Ledger, complete: bool) -> list[str]:
    """Counts, then every difference from the committed ledger, then what is missing."""
    lines = [", ".join(f"{count} {verdict}" for verdict, count in ledger.tally().items())]
    lines += [
        f"{d.id}: {d.now}, committed {d.committed}"
        for d in differences(ledger, committed, complete)
    ]
    if any(entry.verdict == "NOT_CHECKED" for entry in ledger.entries):
        lines.append(REMEDY)
    return lines
