"""The laws past the paper: with and without the guard, or on a rigid body with tyres.

``wmr-ctrl reproduce --with-ours`` and ``--with-physics`` call it beside the paper's claims; alone:
``python -m benchmarks.beyond ours|physics --out DIR [--jobs N] [--quick]``.  ``ours`` writes
DIR/ours.csv and four figures, ``physics`` DIR/rigid.csv, a row a run, and both write what came out
as text beside them.  A minute, and some minutes.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from wmr_ctrl.report.write import write_runs
from wmr_ctrl.results import atomic_text, make_folder
from wmr_ctrl.simulation.batch import Progress

from . import guard_runs, tyre_runs
from .guard_figures import comparison_figures

FILES = {"ours": ("ours.csv", "ours.txt"), "physics": ("rigid.csv", "rigid.txt")}


def ours(out: Path, jobs: int | None, quick: bool, progress: Progress | None) -> str:
    """Every law with and without the guard, one factor at a time around two bases."""
    seeds = guard_runs.HELD_OUT[: 1 if quick else None]
    rows = guard_runs.run_comparison(guard_runs.comparison_plan(seeds=seeds), jobs, progress)
    write_runs(out / FILES["ours"][0], rows, ("base", "guard"), guard_runs.COMPARED)
    make_folder(out / "figures")
    for drawing in comparison_figures(rows):
        drawing.save(out / "figures")
    made = {words: rows.where(guard=on) for words, on in (("without", False), ("with", True))}
    return "".join(
        f"{words} the guard: {some.broken.rows} of {some.rows} runs break a limit\n"
        for words, some in made.items()
    )


def physics(out: Path, jobs: int | None, quick: bool, progress: Progress | None) -> str:
    """Compare the plane model with the rigid body on equal cases, with claims about tyres."""
    seeds = tyre_runs.RIGID_SEEDS[: 1 if quick else None]
    rows = tyre_runs.run_rigid_comparison(seeds, jobs, progress).table
    write_runs(out / FILES["physics"][0], rows, ("plant",), tyre_runs.COMPARED)
    return "".join(
        f"{claim.law}: {claim.text}: {'holds' if claim.holds else 'DOES NOT HOLD'} "
        f"({claim.numbers})\n"
        for claim in tyre_runs.rigid_claims(rows)
    )


def run(what: str, out: Path, jobs: int | None, quick: bool, progress: Progress | None) -> None:
    """Make ``ours`` or ``physics`` and write its files into the folder ``out``."""
    text = {"ours": ours, "physics": physics}[what](out, jobs, quick, progress)
    with atomic_text(out / FILES[what][1]) as file:
        file.write(text)


def main() -> None:
    """Run what the command line asks for."""
    from wmr_ctrl.cli import console

    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("what", choices=FILES)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--jobs", type=int)
    parser.add_argument("--quick", action="store_true", help="one seed")
    asked = parser.parse_args()
    make_folder(asked.out)
    with console.Progress(asked.what) as progress:
        run(asked.what, asked.out, asked.jobs, asked.quick, progress)
    print((asked.out / FILES[asked.what][1]).read_text(encoding="utf-8"), end="")


if __name__ == "__main__":
    main()
