"""A study as one self-contained page: shares, pictures, plan."""

import json
from dataclasses import asdict
from pathlib import Path

from wmr_ctrl.core.fields.files import AnyPath

from .drawing import inlined, write_html
from .run_page import embedded
from .study_figures import drawings_of
from .study_shares import SHARE_HEADS, shares_of
from .study_table import read_study
from .style import house_style


def write_study_page(folder: str | Path, path: AnyPath, plan: str = "") -> None:
    """Write the page of a finished study into an .html file, atomically.

    ``plan``: the text of its plan.  The page contains the shares as JSON, too.  Raises
    ResultFileError for a folder without a finished study, or if the file cannot be written.
    """
    home = Path(folder)
    table, about = read_study(home), json.loads((home / "study.json").read_text(encoding="utf-8"))
    shares = shares_of(table)
    with house_style():
        drawn = {name: inlined(figure) for name, figure in drawings_of(table)}
    write_html(
        path, "study.html.j2",
        name=home.name, runs=len(table.group), scenario=table.plan["scenario"]["name"],
        heads=SHARE_HEADS, shares=[share.cells for share in shares], drawings=drawn,
        figure=table.figure, plan=plan,
        made={"identity": about["identity"], **about["provenance"]},
        document=embedded({"shares": [asdict(share) for share in shares]}),
        picture=drawn.get,
    )  # fmt: skip
