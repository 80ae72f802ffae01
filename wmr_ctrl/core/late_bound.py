"""Functions of higher layers that values and commands offer, imported on first use.

Folders import downwards only.  A Run that draws itself and a Scenario that shows its gains are for
the user's convenience, and commands write the same files.  These few names are the only exceptions,
and importing this file loads nothing.
"""

from collections.abc import Callable
from importlib import import_module
from typing import cast

HOMES = {
    "save_run": "wmr_ctrl.results.formats",
    "draw_linear": "wmr_ctrl.report.linear_figures",
    "draw_against_run": "wmr_ctrl.report.against_run_figure",
    "plot_run": "wmr_ctrl.report.plot_run",
    "write_run_page": "wmr_ctrl.report.run_page",
    "plot_runs": "wmr_ctrl.report.plot_runs",
    "plot_drives": "wmr_ctrl.report.plot_runs",
    "animate_runs": "wmr_ctrl.report.animate",
    "rows_of": "wmr_ctrl.report.run_rows",
    "gains_by_law": "wmr_ctrl.control.setup",
    "outlook_of": "wmr_ctrl.theory.checks.outlook",
    "needed_by": "wmr_ctrl.theory.checks.outlook",
    "left_corridor": "wmr_ctrl.theory.corridor",
}
"""Module of each function."""


def late_bound(name: str) -> Callable[..., object]:
    """The function called ``name``, one of `HOMES`; its module is imported now."""
    return cast("Callable[..., object]", vars(import_module(HOMES[name]))[name])
