"""``wmr-ctrl laws``: the control laws."""

from __future__ import annotations

import click

from wmr_ctrl.cli.console import print_json, table
from wmr_ctrl.cli.options import debug_option, json_option


@click.command(short_help="List the control laws.")
@json_option("Print the list as one JSON document.")
@debug_option
def laws(as_json: bool) -> None:
    """List the control laws, one line each."""
    from wmr_ctrl.api import law_table

    listed = law_table()
    if as_json:
        print_json(listed)
    else:
        click.echo(table([(row["name"], row["title"]) for row in listed]))
