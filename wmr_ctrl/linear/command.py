"""What ``wmr-ctrl linearize`` does."""

from __future__ import annotations

import json
import sys
from pathlib import Path

from wmr_ctrl.linear.report import report_linear
from wmr_ctrl.scenario import Scenario


def run_linearize(
    scenario: Scenario, law: str, plot_dir: str | Path | None = None, as_json: bool = False
) -> int:
    """Write the report to stdout as a table or as JSON, and figures into ``plot_dir``; returns 0.

    Paths of the figures go to stderr, so that stdout stays parseable.  Raises UnknownNameError or
    ScenarioError.
    """
    report = report_linear(scenario, law)
    text = json.dumps(report.to_json(), indent=2, allow_nan=False) if as_json else report.table()
    sys.stdout.write(text + "\n")
    if plot_dir is not None:
        for path in report.plots(plot_dir):
            sys.stderr.write(f"{path}\n")
    return 0
