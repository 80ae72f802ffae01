"""A run as one self-contained page: verdict, figures, scenario, picture."""

import json

from wmr_ctrl.core.fields.files import AnyPath
from wmr_ctrl.results import Run, json_safe, summary
from wmr_ctrl.results.measures import tracked
from wmr_ctrl.theory.checks.unknown_zero import promise_of_run

from .drawing import write_html
from .plot_run import overview
from .run_rows import MOST_ROWS, guard_relies_on, rows_of
from .style import driver

WORDS = {True: "tracked", False: "did not track", None: ""}
"""Words for the values of `tracked`."""


def write_run_page(run: Run, path: AnyPath) -> None:
    """Write the page of a run, or of a co-simulation, into an .html file, atomically.

    Its numbers are those of ``run --json``, which the page contains, too.  Raises ResultFileError
    for another suffix or if it cannot be written.
    """
    document = summary(run)
    rows = rows_of(run, verbose=True)
    write_html(
        path, "run.html.j2",
        run=run, driver=driver(run.law, run.guard), word=WORDS[tracked(run)],
        kept=document["kept"], promise=promise_of_run(run),
        relies=guard_relies_on(run), shown=rows[:MOST_ROWS], others=rows[MOST_ROWS:],
        scenario=run.provenance.get("scenario_toml", ""),
        made={k: v for k, v in run.provenance.items() if "\n" not in v},
        document=embedded(document),
        picture=lambda name: overview(run).inlined(),
    )  # fmt: skip


def embedded(document: object) -> str:
    """JSON that is safe inside a script element."""
    text = json.dumps(json_safe(document), allow_nan=False)
    return text.replace("<", "\\u003c")
