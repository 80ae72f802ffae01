"""Command `wmr-ctrl prove`: run, print, compare with the committed ledger."""

import sys
from collections.abc import Iterable
from importlib.resources import files
from pathlib import Path

from wmr_ctrl.proofs.ledger import COMMITTED, PROVED, Entry, Ledger, differences, exit_code, load
from wmr_ctrl.proofs.runner import Progress, prove, selected
from wmr_ctrl.results import atomic_text, write_all

REMEDY = (
    "Some entries were not checked; install the proving packages with: "
    "pip install 'wmr_ctrl[proofs]'"
)


ALTERED = {"tried": "functions altered", "caught": "REFUTED then", "open": "left open"}


def run_prove(
    only: Iterable[str] = (),
    json_file: Path | None = None,
    progress: Progress | None = None,
    anew: bool = False,
) -> int:
    """Check, print a summary, write ``json_file``; the exit code of `ledger.exit_code`.

    ``anew``: nothing is taken from the committed ledger.
    """
    asked = tuple(only)
    ledger = prove(asked, progress, anew=anew)
    committed = load() if COMMITTED.exists() else Ledger(())
    if json_file is not None:
        with atomic_text(json_file) as stream:
            stream.write(ledger.to_json() + "\n")
    if asked:
        sys.stdout.write("\n".join(map(described, ledger.entries)) + "\n")
    sys.stdout.write("\n".join(summary(ledger, committed, not asked, anew)) + "\n")
    return exit_code(ledger, committed, complete=not asked)


def run_export(folder: Path, only: Iterable[str] = ()) -> None:
    """Write the obligations of the z3 entries that ``only`` names, and say how many.

    SMT-LIB 2 files, for whoever trusts another solver more.  Raises ResultFileError where a file
    cannot be written.
    """
    from wmr_ctrl.proofs.claim import CLAIMED
    from wmr_ctrl.proofs.claims import all_claims
    from wmr_ctrl.proofs.methods.obligations import obligations, uses_z3

    readme = files("wmr_ctrl.proofs").joinpath("obligations.md").read_text(encoding="utf-8")
    write_all({"README.md": readme}, folder)
    wanted, count = set(selected(tuple(only))), 0
    for claim in all_claims():
        if claim.id not in wanted or claim.statement is None or not uses_z3(claim.method):
            continue
        texts = {
            f"{item.name}.smt2": f"; {claim.id}, {item.name}: {item.wanted} is needed\n{item.text}"
            for item in obligations(claim.statement(CLAIMED))
        }
        count += len(write_all(texts, folder / claim.id))
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
        "not noticed": ", ".join(name for name, said in entry.altered.items() if said == PROVED),
        "not tried": ", ".join(name for name, said in entry.altered.items() if not said),
        "altered": ", ".join(f"{n} {ALTERED[key]}" for key, n in (entry.alterations or {}).items()),
        "confirmed by": ", ".join(entry.confirmed_by),
        "cancelled by CasADi": f"{entry.cancelled} operations, all defined" * bool(entry.cancelled),
        "versions": ", ".join(f"{name} {number}" for name, number in entry.versions.items()),
    }
    lines = [f"{entry.id}: {entry.verdict}"]
    return "\n".join([*lines, *(f"  {name}: {text}" for name, text in rows.items() if text), ""])


def provenance(ledger: Ledger, committed: Ledger, anew: bool) -> str:
    """Summary of entries checked now, given, and taken from the committed ledger."""
    known = {entry.id: entry for entry in committed.entries if entry.cancelled is not None}
    checked = [entry for entry in ledger.entries if entry.graph_hash]
    given = sum(1 for e in ledger.entries if not e.graph_hash and e.verdict != "NOT_CHECKED")
    altered = sum(1 for entry in checked if entry.alterations)
    confirmed = sum(1 for entry in checked if entry.confirmed_by)
    defined = sum(
        1 for e in checked if e.id in known and known[e.id].is_about(e.graph_hash, e.versions)
    )
    taken = (
        f"the alterations of {altered} of them, the second solvers' answers for {confirmed} and "
        f"that what CasADi cancels is defined for {defined}, where claim, method and versions are "
        "the same"
    )
    return (
        f"{len(checked)} checked now, their functions searched anew; {given} given (by hand, "
        f"definitions, open). From the record: {'nothing' if anew else taken}. Claims are about "
        "real numbers, except where an entry's id or method speaks of rounding."
    )


def summary(ledger: Ledger, committed: Ledger, complete: bool, anew: bool) -> list[str]:
    """Counts, where they come from, differences from the committed ledger, what is missing."""
    lines = [
        ", ".join(f"{count} {verdict}" for verdict, count in ledger.tally().items()),
        provenance(ledger, committed, anew),
    ]
    lines += [
        f"{d.id}: {d.now}, committed {d.committed}"
        for d in differences(ledger, committed, complete)
    ]
    if any(entry.verdict == "NOT_CHECKED" for entry in ledger.entries):
        lines.append(REMEDY)
    return lines
