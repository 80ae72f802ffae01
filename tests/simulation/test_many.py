"""Tables of many runs: seeds, overrides and starts side by side."""

from functools import partial
from importlib.metadata import EntryPoint

import casadi as ca
import numpy as np
import pytest

from wmr_ctrl.api import simulate
from wmr_ctrl.control.given import scenario_of
from wmr_ctrl.control.laws import LAWS
from wmr_ctrl.control.laws.law import Law, Traits
from wmr_ctrl.core.errors import ArgumentError
from wmr_ctrl.core.fields.section import Section
from wmr_ctrl.results.frames import summary
from wmr_ctrl.simulation.engines import runnable
from wmr_ctrl.simulation.many import planned_tasks, tabulated
from wmr_ctrl.simulation.memory import Task

SHORT = {"clock.duration": 4.0, "changes": []}


class NoGains(Section, key="gains.toy"):
    """Gains of the toy law, which has none."""


def blind(sample):
    """A thrust that becomes NaN above 0.05 m/s."""
    return sample.system("toy law", ca.vertcat(100 + ca.sqrt(0.05 - sample.v[0]), 0))


def spin(sample):
    """No thrust, and a moment that accelerates half a kg m2 beyond the range of doubles."""
    return sample.system("toy law", ca.vertcat(0, 2e307))


def with_law(monkeypatch, build, **changed):
    """A scenario without noise, and a law of this name."""
    law = Law(build.__name__, NoGains, build, Traits(), "Toy law.")
    monkeypatch.setitem(globals(), "TOY", law)
    entry = EntryPoint(law.name, f"{__name__}:TOY", "wmr_ctrl.laws")
    monkeypatch.setitem(LAWS.plugins, law.name, entry)
    return scenario_of("paper-simulation", {**SHORT, "disturbance.std": 0.0, **changed})


@pytest.mark.slow
def test_a_torque_that_is_no_number_is_the_largest(monkeypatch):
    scenario = with_law(monkeypatch, blind)
    table = tabulated([Task(runnable(scenario, "blind"), 0)])
    run = simulate(scenario, "blind")

    assert table["outcome"].tolist() == [run.outcome] == ["non-finite"]
    assert run.rows > 1
    assert np.isnan(table["tau_peak"][0])
    assert summary(run)["tau_peak"] is None


@pytest.mark.slow
def test_a_rate_of_turn_that_is_no_number_is_not_told_as_the_largest(monkeypatch):
    scenario = with_law(monkeypatch, spin, **{"robot.I": 0.5})
    monitor = simulate(scenario, "spin").monitor

    assert (monitor.stop_reason, monitor.stopped) == ("non-finite", (0.001, 2))
    assert np.isfinite(monitor.max_abs_v).all()


@pytest.mark.parametrize(
    "count, seeds, starts, message",
    [
        (1, [], None, "empty"),
        (2, [1, 2, 3], None, "2 entries for 3 seeds"),
        (1, [1, 2], [[0, 0, 0, 0, 0]], r"\(2, 5\)"),
        (1, [1], [[0, 0, 0]], r"\(1, 5\)"),
    ],
)
def test_what_does_not_fit_is_said(count, seeds, starts, message):
    scenarios = [scenario_of("paper-simulation", SHORT)] * count
    with pytest.raises(ArgumentError, match=message):
        planned_tasks(partial(runnable, law="mb"), scenarios, seeds, starts, None)
