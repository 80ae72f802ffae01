"""Synthetic runs of 80 s that are quick to make and differ by scenario, law and seed."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

import pytest

from tests.campaign.conftest import campaign as campaign
from tests.campaign.conftest import fake_simulate as fake_simulate
from tests.campaign.synthetic import made_up
from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.report.drawing import Drawing
from wmr_ctrl.results.table import RunTable
from wmr_ctrl.simulation.campaign.comparison import comparison_plan, run_comparison
from wmr_ctrl.simulation.campaign.plan import PlannedRun


@pytest.fixture(scope="session")
def comparison_cases() -> tuple[PlannedRun, ...]:
    return comparison_plan(("smc", "prox"), bases=("10 ms",), factors=("base", "tau_max = 5 N m"))


@pytest.fixture(scope="session")
def comparison(comparison_cases) -> RunTable:
    def asked(case):
        if case.guard and "actuator.tau_max" in case.overrides:
            raise ScenarioError("too weak for the bounds")

    with made_up(asked=asked):
        return run_comparison(comparison_cases)


@contextmanager
def drawn_for_the_page(wanted: Callable[[str], bool]) -> Iterator[None]:
    """To save time: only the pictures of these names, as SVG; empty ones for the others."""
    whole = Drawing.save

    def save(drawing, folder):
        if wanted(drawing.name):
            return whole(drawing, folder, (".svg",))
        path = folder / f"{drawing.name}.svg"
        path.write_text("<svg/>")
        return (path,)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Drawing, "save", save)
        yield


@pytest.fixture
def few_pictures() -> Iterator[frozenset[str]]:
    """Two; test_write.py has one of each kind."""
    drawn = frozenset(("fig3a_trajectory", "limits_all_seeds"))
    with drawn_for_the_page(drawn.__contains__):
        yield drawn
