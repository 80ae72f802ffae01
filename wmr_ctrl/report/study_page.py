"""A study as one self-contained page: shares, pictures, plan."""

import json
import os
import tempfile
from dataclasses import asdict
from pathlib import Path

from wmr_ctrl.results import atomic_text

from . import drawing, style
from .run_page import embedded
from .study_figures import drawings_of
from .study_shares import SHARE_HEADS, shares_of
from .study_table import read_study


def write_study_page(folder: str | Path, path: str | os.PathLike[str], plan: str = "") -> None:
    """Write the page of a finished study into an .html file, atomically.

    ``plan``: the text of its plan.  The page contains the shares as JSON, too.  Raises
    ResultFileError for a folder without a finished study, or if the file cannot be written.
    """
    target, home = drawing.target_of(path, (".html",), "the page is .html"), Path(folder)
    table, about = read_study(home), json.loads((home / "study.json").read_text(encoding="utf-8"))
    shares = shares_of(table)
    made = {"identity": about["identity"], **about["provenance"]}
    with tempfile.TemporaryDirectory() as place, style.house_style():
        drawn = []
        for name, figure in drawings_of(table):
            drawing.save_figure(figure, Path(place, f"{name}.svg"))
            drawn.append(name)
        text = style.page_environment().get_template("study.html.j2").render(
            name=home.name, runs=len(table.group), scenario=table.plan["scenario"]["name"],
            heads=SHARE_HEADS, shares=[share.cells for share in shares], drawings=drawn,
            figure=table.figure, plan=plan, made=made,
            document=embedded({"shares": [asdict(share) for share in shares]}),
            picture=lambda name: style.picture(Path(place, f"{name}.svg")),
        )  # fmt: skip
    with atomic_text(target) as file:
        file.write(text)
