"""``wmr-ctrl prove``: the paper's equations and theorems, checked by machine."""

from __future__ import annotations

from pathlib import Path

import click

from wmr_ctrl.cli.options import check_output, debug_option, examples
from wmr_ctrl.cli.progress import Progress


@click.command(
    short_help="Check the paper's equations by machine.",
    epilog=examples("wmr-ctrl prove", "wmr-ctrl prove --only eq25.printed --json entry.json"),
)
@click.option("--only", multiple=True, metavar="ID", help="Only this entry. May be repeated.")
@click.option("--json", "file", metavar="FILE", help="Also write all entries to FILE (.json).")
@debug_option
def prove(only: tuple[str, ...], file: str | None) -> None:
    """Prove or refute the paper's numbered equations and theorems, and our own results.

    Claims are about the very graphs that the C is made from. The exit code is 1 where a verdict
    differs from the committed one, and 3 where a proving package is missing, so that entries are
    NOT_CHECKED.
    """
    from wmr_ctrl.proofs.command import run_prove

    check_output(file, (".json",), "--json")
    with Progress("proofs") as progress:

        def tell(done: int, total: int, _entry: object) -> None:
            progress(done / total)

        code = run_prove(only, Path(file) if file else None, tell)
    raise click.exceptions.Exit(code)
