"""The laws past the paper: with and without the guard, or on a rigid body with tyres.

``python -m benchmarks.beyond guard|tyres --out DIR [--jobs N] [--quick]`` writes DIR/runs.csv, a
row a run; ``guard`` draws four figures beside it, ``tyres`` (needs the extra physics) prints
what a robot with tyres ought to do and whether it does.  A minute, and some minutes.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from wmr_ctrl.cli.console import Progress
from wmr_ctrl.report.write import write_runs
from wmr_ctrl.results import make_folder

from . import guard_runs, tyre_runs
from .guard_figures import comparison_figures


def guard(out: Path, jobs: int | None, quick: bool, progress: Progress) -> None:
    """Every law with and without the guard, one factor at a time around two bases."""
    seeds = guard_runs.HELD_OUT[: 1 if quick else None]
    rows = guard_runs.run_comparison(guard_runs.comparison_plan(seeds=seeds), jobs, progress)
    write_runs(out / "runs.csv", rows, ("base", "guard"), guard_runs.COMPARED)
    for drawing in comparison_figures(rows):
        drawing.save(out)
    for guarded in (False, True):
        made = rows.where(guard=guarded)
        words = "with the guard" if guarded else "without it"
        print(f"{words}: {made.broken.rows} of {made.rows} runs break a limit")


def tyres(out: Path, jobs: int | None, quick: bool, progress: Progress) -> None:
    """The same cases on the plane model and on the rigid body."""
    seeds = tyre_runs.RIGID_SEEDS[: 1 if quick else None]
    rows = tyre_runs.run_rigid_comparison(seeds, jobs, progress).table
    write_runs(out / "runs.csv", rows, ("plant",), tyre_runs.COMPARED)
    for claim in tyre_runs.rigid_claims(rows):
        verdict = "holds" if claim.holds else "does not hold"
        print(f"{claim.law}: {claim.text}: {verdict} ({claim.numbers})")


def main() -> None:
    """Run what the command line asks for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("what", choices=("guard", "tyres"))
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--jobs", type=int)
    parser.add_argument("--quick", action="store_true", help="one seed")
    asked = parser.parse_args()
    make_folder(asked.out)
    with Progress(asked.what) as progress:
        {"guard": guard, "tyres": tyres}[asked.what](asked.out, asked.jobs, asked.quick, progress)


if __name__ == "__main__":
    main()
