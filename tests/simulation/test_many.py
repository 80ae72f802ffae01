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


def many(overrides, seeds, starts=None):
    scenarios = [scenario_of("paper-simulation", {**SHORT, **item}) for item in overrides]
    build = partial(runnable, law="mb")
    return tabulated(planned_tasks(build, scenarios, seeds, starts, None))


class BlindGains(Section, key="gains.blind"):
    """None."""


def blind(sample):
    """A thrust that is no number any more above 0.05 m/s."""
    return sample.system("blind law", ca.vertcat(100 + ca.sqrt(0.05 - sample.v[0]), 0))


def with_law(monkeypatch, name, **changed):
    """A scenario without noise, and one of these laws registered for it."""
    entry = EntryPoint(name, f"{__name__}:{name.upper()}", "wmr_ctrl.laws")
    monkeypatch.setitem(LAWS.plugins, name, entry)
    return scenario_of("paper-simulation", {**SHORT, "disturbance.std": 0.0, **changed})


BLIND = Law("blind", BlindGains, blind, Traits(), "Toy law.")


@pytest.mark.slow
def test_a_torque_that_is_no_number_is_the_largest(monkeypatch):
    scenario = with_law(monkeypatch, "blind")
    table = tabulated([Task(runnable(scenario, "blind"), 0)])
    run = simulate(scenario, "blind")

    assert table["outcome"].tolist() == [run.outcome] == ["non-finite"]
    assert run.rows > 1
    assert np.isnan(table["tau_peak"][0])
    assert summary(run)["tau_peak"] is None


def spin(sample):
    """No thrust, and a moment that turns half a kg m2 faster than doubles can say."""
    return sample.system("spinning law", ca.vertcat(0, 2e307))


SPINNING = Law("spinning", BlindGains, spin, Traits(), "Toy law.")


@pytest.mark.slow
def test_a_rate_of_turn_that_is_no_number_is_not_told_as_the_largest(
    monkeypatch,
):
    scenario = with_law(monkeypatch, "spinning", **{"robot.I": 0.5})
    monitor = simulate(scenario, "spinning").monitor

    assert (monitor.stop_reason, monitor.stopped) == ("non-finite", (0.001, 2))
    assert np.isfinite(monitor.max_abs_v).all()


@pytest.mark.parametrize(
    "overrides, seeds, starts, message",
    [
        ([{}], [], None, "empty"),
        ([{}, {}], [1, 2, 3], None, "2 entries for 3 seeds"),
        ([{}], [1, 2], [[0, 0, 0, 0, 0]], r"\(2, 5\)"),
        ([{}], [1], [[0, 0, 0]], r"\(1, 5\)"),
    ],
)
def test_what_does_not_fit_is_said(overrides, seeds, starts, message):
    with pytest.raises(ArgumentError, match=message):
        many(overrides, seeds, starts=starts)
