"""``wmr-ctrl show``: a saved run again: figures, plot, animation, another format."""

from __future__ import annotations

import click

from wmr_ctrl.cli.options import debug_option, examples, json_option
from wmr_ctrl.cli.run import check_outputs, film_option, show, write_run


@click.command(
    "show",
    short_help="Print, draw or film a saved run.",
    epilog=examples(
        "wmr-ctrl run far-start --law mb --out mb.npz",
        "wmr-ctrl show mb.npz --plot mb.png --animate mb.html",
        "wmr-ctrl show mb.npz --out mb.parquet",
    ),
)
@click.argument("file", metavar="RUN")
@click.option("--out", metavar="FILE", help="Save it once more: .npz, .csv or .parquet.")
@click.option("--plot", metavar="FILE", help="Draw the run: .png, .svg or .pdf.")
@click.option("--animate", metavar="FILE", help="Film the robot on its path: .gif, .mp4 or .html.")
@film_option
@json_option("Print outcome and figures as one JSON document.")
@debug_option
def show_saved(
    file: str,
    out: str | None,
    plot: str | None,
    animate: str | None,
    film: str | None,
    as_json: bool,
) -> None:
    """Print how a saved run went, and draw, film or convert it; only --film makes it once more.

    RUN is a file that `wmr-ctrl run --out` or `Run.save` wrote: .npz, .csv or .parquet.
    """
    from wmr_ctrl.results import load_run

    check_outputs(out, plot, animate)
    run = load_run(file)
    write_run(run, out, plot, animate, film)
    show(run, as_json)
