"""``wmr-ctrl bench``: how fast the generated code is."""

from __future__ import annotations

from importlib import import_module
from typing import Any

import click

from wmr_ctrl.cli.console import json_text, say
from wmr_ctrl.cli.options import check_output, debug_option
from wmr_ctrl.cli.progress import Progress


@click.command(short_help="Measure the speed of the generated code, as ratios.")
@click.option("--json", "file", metavar="FILE", help="Also write all measurements to FILE (.json).")
@debug_option
def bench(file: str | None) -> None:
    """Measure generated C against hand-written C and NumPy, interleaved in one run.

    Ratios carry over from one machine to another; FILE has the times too.
    """
    check_output(file, (".json",), "--json")
    api: Any = import_module("wmr_ctrl.api")
    with Progress("benchmarks") as progress:
        measured = api.bench(progress=progress)
    if file:
        from wmr_ctrl.results import atomic_write

        with atomic_write(file, text=True) as stream:
            stream.write(json_text(measured) + "\n")
        say("wrote", file)
    click.echo(measured["text"])
