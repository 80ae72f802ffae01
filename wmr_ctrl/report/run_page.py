"""A run as one self-contained page: verdict, figures, scenario, picture."""

import json
import os
import tempfile
from pathlib import Path

from wmr_ctrl.results import Run, atomic_text, json_safe, summary
from wmr_ctrl.results.measures import tracked
from wmr_ctrl.theory.checks.unknown_zero import promise_of_run

from . import drawing
from .plot_run import overview
from .run_rows import MOST_ROWS, guard_relies_on, rows_of
from .style import driver, page_environment, picture

WORDS = {True: "tracked", False: "did not track", None: ""}
"""Whether a run tracked, by `tracked`."""


def write_run_page(run: Run, path: str | os.PathLike[str]) -> None:
    """Write the page of a run, or of a co-simulation, into an .html file, atomically.

    Its numbers are those of ``run --json``, which the page contains, too.  Raises ResultFileError
    for another suffix or if it cannot be written.
    """
    target = drawing.target_of(path, (".html",), "the page is .html")
    document = summary(run)
    rows = rows_of(run, verbose=True)
    with tempfile.TemporaryDirectory() as folder:
        drawn = Path(folder, "run.svg")
        if run.rows:
            overview(run).written([drawn])
        text = page_environment().get_template("run.html.j2").render(
            run=run, driver=driver(run.law, run.guard), word=WORDS[tracked(run)],
            kept=document["kept"], promise=promise_of_run(run),
            relies=guard_relies_on(run), shown=rows[:MOST_ROWS], others=rows[MOST_ROWS:],
            scenario=run.provenance.get("scenario_toml", ""),
            made={k: v for k, v in run.provenance.items() if "\n" not in v},
            document=embedded(document),
            picture=lambda name: picture(drawn),
        )  # fmt: skip
    with atomic_text(target) as file:
        file.write(text)


def embedded(document: object) -> str:
    """JSON that is safe inside a script element."""
    text = json.dumps(json_safe(document), allow_nan=False)
    return text.replace("<", "\\u003c")
