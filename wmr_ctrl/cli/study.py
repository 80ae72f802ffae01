"""``wmr-ctrl study``: thousands of runs by a plan, resumed where they were interrupted."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path

import click

from wmr_ctrl.cli.console import print_json, say, wrapped
from wmr_ctrl.cli.failures import resumable
from wmr_ctrl.cli.options import check_folder, debug_option, examples, json_option
from wmr_ctrl.cli.progress import Progress

PLOT, PARQUET = "plot", "parquet"


@click.command(
    short_help="Run a plan of many runs; draw its results.",
    epilog=examples(
        "wmr-ctrl study plan.toml --out mass",
        "wmr-ctrl study plan.toml --out mass --executor dask://10.0.0.1:8786",
        "wmr-ctrl study plot mass",
        "wmr-ctrl study parquet mass",
    ),
)
@click.argument("words", metavar="PLAN.toml | plot DIR | parquet DIR", nargs=-1, required=True)
@click.option("--out", metavar="DIR", help="Folder of the results; an interrupted one goes on.")
@click.option(
    "--executor",
    default="threads",
    metavar="E",
    help="threads, dask (processes here) or dask://HOST:PORT.",
)
@click.option("--jobs", type=click.IntRange(min=1), metavar="N", help="Threads or processes.")
@json_option("Print what was made as one JSON document.")
@debug_option
def study(
    words: tuple[str, ...], out: str | None, executor: str, jobs: int | None, as_json: bool
) -> None:
    """Run all that PLAN.toml asks for, and write DIR/table.csv, one row a run.

    A plan names a scenario, laws, guards and seeds, values of fields ([grid]), ranges of fields
    ([sample]) and a rule to stop ([stop]). The table has the same bytes for any executor, any
    number of jobs and of interruptions. `study plot DIR` draws its pictures,
    `study parquet DIR` writes the table by columns too. Where the guard refused
    every run, the exit code is 1.
    """
    if words[0] in (PLOT, PARQUET) and len(words) == 2:
        _written((_plot if words[0] == PLOT else _columns)(words[1]), as_json)
        return
    if len(words) != 1 or out is None:
        raise click.UsageError("give PLAN.toml and --out DIR, or `plot DIR`, or `parquet DIR`.")
    check_folder(out, "--out")
    from wmr_ctrl import api
    from wmr_ctrl.campaign.study_plan import load_plan

    plan = load_plan(words[0])
    for text in plan.warnings:
        say("warning", text)
    with resumable(Path(out)), Progress("study") as progress:
        result = api.study(plan, out, executor=executor, jobs=jobs, progress=progress)
    if as_json:
        print_json(
            {key: str(v) if key in ("folder", "table") else v for key, v in asdict(result).items()}
        )
    else:
        head, *refused = str(result).split("\n")
        click.echo("\n".join((head, *(wrapped(f"- {text}", hang="  ") for text in refused))))
    if result.all_refused:
        raise SystemExit(1)


def _plot(folder: str) -> list[Path]:
    from wmr_ctrl.report.study_figures import plot_study

    with Progress("drawing", measured=False):
        return plot_study(folder)


def _columns(folder: str) -> list[Path]:
    from wmr_ctrl.campaign.study_columns import write_columns

    with Progress("writing", measured=False):
        return [write_columns(folder)]


def _written(paths: list[Path], as_json: bool) -> None:
    """Tell what was written."""
    if as_json:
        print_json([str(path) for path in paths])
    for path in paths:
        say("wrote", str(path))
