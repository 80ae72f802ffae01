"""``wmr-ctrl prove``: the paper's equations and theorems, checked by machine."""

from __future__ import annotations

from pathlib import Path

import click

from wmr_ctrl.cli.options import check_output, debug_option, examples
from wmr_ctrl.cli.progress import Progress


@click.command(
    short_help="Check the paper's equations by machine.",
    epilog=examples(
        "wmr-ctrl prove",
        "wmr-ctrl prove --only eq25.printed --only 'guard.*' --json entries.json",
        "wmr-ctrl prove --export obligations",
    ),
)
@click.option(
    "--only",
    multiple=True,
    metavar="ID",
    help="Only this entry: an id, its beginning, or a pattern such as 'guard.*'. May be repeated; "
    "what was checked is then printed in full.",
)
@click.option("--json", "file", metavar="FILE", help="Also write all entries to FILE (.json).")
@click.option(
    "--export",
    "folder",
    metavar="DIR",
    help="Check nothing; write the obligations of the z3 entries to DIR as SMT-LIB 2.",
)
@click.option(
    "--anew",
    is_flag=True,
    help="Take nothing from the committed ledger: neither what altering functions did, nor what "
    "another solver said, nor which engine to ask first.",
)
@debug_option
def prove(only: tuple[str, ...], file: str | None, folder: str | None, anew: bool) -> None:
    """Prove or refute the paper's numbered equations and theorems, and our own results.

    Claims are about the very graphs that the C is made from. Every verdict is found again, and the
    functions that an entry names are searched again. The exit code is 1 where a verdict
    differs from the committed one, and 3 where a proving package is missing, so that entries are
    NOT_CHECKED.
    """
    from wmr_ctrl.proofs.command import run_export, run_prove

    if folder is not None:
        run_export(Path(folder), only)
        return
    check_output(file, (".json",), "--json")
    with Progress("proofs") as progress:

        def tell(share: float, _entry: object) -> None:
            progress(share)

        code = run_prove(only, Path(file) if file else None, tell, anew)
    raise click.exceptions.Exit(code)
