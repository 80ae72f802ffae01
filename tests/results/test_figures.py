"""The numbers that are stored for each run."""

import json
import math

import numpy as np
import pytest

from tests.results.conftest import build
from tests.simulation.campaign.synthetic import made_up
from wmr_ctrl.core.errors import ArgumentError, UnknownNameError
from wmr_ctrl.results import Monitor
from wmr_ctrl.results.figures import FIGURES, Figure, FigureRegistry, values_of
from wmr_ctrl.simulation.campaign.engine import run_campaign
from wmr_ctrl.simulation.campaign.paper_runs import REPORTED, paper_plan

STOPPED = Monitor((1000.0, 2.0), 5, (0.2, 1), (0.5, 1), "diverged")


def figures_of(run):
    return values_of(run, FIGURES.with_others(REPORTED))


def test_names_are_unique_and_headings_carry_units():
    names = [figure.name for figure in FIGURES]

    assert len(set(names)) == len(names) > 60
    assert [FIGURES[name].name for name in names] == names
    assert FIGURES["tau_rms"].heading == "tau_rms [N.m]"
    with pytest.raises(UnknownNameError):
        FIGURES["tau_mean"]


def test_a_run_that_ended_early_has_the_figures_that_it_covers():
    values = figures_of(build(duration=80.0, rows=50, monitor=STOPPED))

    assert values["ise_total"] is None
    assert values["d_rms_70_80"] is None
    assert values["limit_ratio"] == 1000.0
    assert values["first_violation"] == 0.2
    assert math.isfinite(json.loads(json.dumps(values, allow_nan=False))["violations"])


def test_distance_figures():
    values = figures_of(build(duration=80.0, x=np.linspace(2.0, 0.0, 8000)))

    assert values["d_start"] == 2.0
    assert values["halving_time"] == pytest.approx(40.0, abs=0.02)
    assert values["d_rms_70_80"] == pytest.approx(0.25 / math.sqrt(3), rel=1e-3)


def test_a_figure_of_another_package_stands_in_the_report_s_tables(monkeypatch):
    twice = Figure("twice", "1", "a number", lambda run: 2.0)
    monkeypatch.setitem(FIGURES.__dict__, "plugins", (twice,))

    assert figures_of(build())["twice"] == 2.0
    assert build().summary()["figures"]["twice"] == 2.0
    with made_up():
        table = run_campaign(paper_plan(seeds=1)[:1], 1, figures=("ise_total",), whole=False).table
    assert table["twice"].tolist() == [2.0]


@pytest.mark.parametrize(
    "of, error",
    [(lambda run: run.speed, "Attribute"), (lambda run: run["speed"], "UnknownName")],
)
def test_a_figure_of_another_package_that_fails_is_named(monkeypatch, of, error):
    wrong = Figure("wrong", "1", "a number", of)
    monkeypatch.setitem(FIGURES.__dict__, "plugins", (wrong,))

    with pytest.raises(ArgumentError, match=f"figure 'wrong' cannot be taken: {error}Error"):
        figures_of(build())


def test_a_figure_of_another_package_with_a_name_of_ours_is_refused(monkeypatch):
    taken = Figure("tau_rms", "1", "a number", lambda run: 2.0)
    monkeypatch.setattr("wmr_ctrl.results.figures.loaded", lambda group, kind: (taken,))

    with pytest.raises(ArgumentError, match="'tau_rms' of another package"):
        list(FigureRegistry())
