"""The promise of the registry: a new law is one module, and everything else follows."""

from __future__ import annotations

import types
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pytest

from wmr_ctrl.api import compile_law, law_table, simulate
from wmr_ctrl.checks import warnings_for
from wmr_ctrl.control import registry
from wmr_ctrl.errors import ArgumentError, UnknownNameError
from wmr_ctrl.fields.section import Section, quantity
from wmr_ctrl.laws.sample import Sample
from wmr_ctrl.model.system import System
from wmr_ctrl.scenario import Scenario, load_scenario


@dataclass(frozen=True, kw_only=True)
class Gains(Section):
    """One gain an axis."""

    KEY: ClassVar[str] = "gains.toy"

    k: tuple[float, float] = quantity((200.0, 20.0), unit="N.s/m, N.m.s/rad", doc="gain on z")


def build(scenario: Scenario) -> System:
    """F = F1 - k (v - v_c1)."""
    sample = Sample("toy", scenario)
    pull = sample.gain("k") * (sample.v - sample.per_axis("v_c1"))
    return sample.system("toy", sample.friction - pull)


class Entry:
    """Stands for the entry point of another package."""

    name = "toy"

    def load(self) -> types.SimpleNamespace:
        """The law's module."""
        return types.SimpleNamespace(__doc__="Toy law.", Gains=Gains, build=build)


@pytest.fixture(autouse=True)
def toy(monkeypatch: pytest.MonkeyPatch) -> None:
    fresh = registry.Registry()
    monkeypatch.setattr(registry, "entry_points", lambda group: [Entry()])
    fresh._plugins  # noqa: B018  # read while the entry point is there
    monkeypatch.setattr(registry.LAWS, "__dict__", fresh.__dict__)


def test_it_is_listed_run_and_compiled() -> None:
    run = simulate("paper-simulation", "toy", overrides={"clock.duration": 20.0})

    assert {"name": "toy", "title": "Toy law"} in law_table()
    assert run.outcome == "completed"
    assert np.hypot(run["x"] - run["x_d"], run["y"] - run["y_d"])[-1] < 0.3
    assert compile_law("toy").step().shape == (2,)


def test_its_gains_are_scenario_keys() -> None:
    weak, strong = (
        simulate(
            "paper-simulation-nominal",
            "toy",
            overrides={"clock.duration": 3.0, "gains.toy.k": [k, 20.0]},
        )
        for k in (20.0, 400.0)
    )

    assert abs(strong["e[1]"][-1]) < abs(weak["e[1]"][-1])
    with pytest.raises(UnknownNameError, match="near: k"):
        simulate("paper-simulation", "toy", overrides={"gains.toy.kk": 1.0})


def test_guard_and_theory_serve_it_too() -> None:
    guarded = simulate("far-start-drop", "toy", guard=True, overrides={"disturbance.truncate": 3.0})

    assert guarded.monitor.violations == 0
    assert warnings_for(load_scenario("paper-experiment-literal"), "toy")


def test_numpy_engine_says_that_it_has_no_twin() -> None:
    with pytest.raises(ArgumentError, match="native engine"):
        simulate("paper-simulation", "toy", engine="numpy")
