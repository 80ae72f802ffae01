"""``wmr-ctrl codegen``: a law as a self-contained C package."""

from __future__ import annotations

from pathlib import Path

import click

from wmr_ctrl.cli.console import say
from wmr_ctrl.cli.options import SCENARIO, check_folder, debug_option, examples, load, set_option


@click.command(
    short_help="Write a law as a C99 package for a robot.",
    epilog=examples("wmr-ctrl codegen nn --out nn_c", "wmr-ctrl codegen mb --float32 --out mb_c"),
)
@click.argument("law")
@click.option("--scenario", default=SCENARIO, metavar="S", help="Preset or TOML file.")
@set_option
@click.option("--float32", is_flag=True, help="Single precision throughout.")
@click.option("--out", required=True, metavar="DIR", help="Folder to write into.")
@debug_option
def codegen(law: str, scenario: str, assignments: tuple[str, ...], float32: bool, out: str) -> None:
    """Write header, source, example, test vectors and build files of one law into a folder.

    No heap, no input or output, no globals: the caller owns the law's memory.
    """
    from wmr_ctrl.codegen.package import write_package

    check_folder(out, "--out")
    for path in write_package(law, Path(out), load(scenario, assignments), float32=float32):
        say("wrote", str(path))
