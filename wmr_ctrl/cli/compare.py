"""``wmr-ctrl compare``: two saved runs side by side."""

from __future__ import annotations

from dataclasses import asdict

import click

from wmr_ctrl.cli.console import print_json
from wmr_ctrl.cli.failures import DIFFERENCE
from wmr_ctrl.cli.options import debug_option, examples, json_option


@click.command(
    short_help="Where two saved runs differ, and by how much.",
    epilog=examples(
        "wmr-ctrl run --out a.npz",
        "wmr-ctrl run --engine numpy --out b.npz",
        "wmr-ctrl compare a.npz b.npz",
    ),
)
@click.argument("run_a")
@click.argument("run_b")
@click.option(
    "--tolerance",
    type=float,
    default=1e-9,
    metavar="X",
    help="Columns this close, in their unit or relative to their range, agree.",
)
@json_option("Print the comparison as one JSON document.")
@debug_option
@click.pass_context
def compare(ctx: click.Context, run_a: str, run_b: str, tolerance: float, as_json: bool) -> None:
    """Show where two saved runs (.npz, .csv or .parquet) differ, by how much and when.

    Compares the samples and columns that both have. The exit code is 0 if the runs are equal or
    agree within the tolerance, 1 if they differ or share no sample.
    """
    from wmr_ctrl.results import compare as compare_runs
    from wmr_ctrl.results import load_run

    comparison = compare_runs(load_run(run_a), load_run(run_b), tolerance)
    if as_json:
        print_json(asdict(comparison))
    else:
        click.echo(str(comparison))
    if comparison.verdict not in ("equal", "agree"):
        ctx.exit(DIFFERENCE)
