"""The promise of the registry: a new law is one module, and everything else follows."""

from importlib.metadata import EntryPoint

import numpy as np
import pytest

from tests.control.laws.toys import TOY, install
from wmr_ctrl.api import compile_law, law_table, simulate
from wmr_ctrl.control.laws import LAWS
from wmr_ctrl.core.errors import ArgumentError, UnknownNameError


@pytest.fixture(autouse=True)
def toy(monkeypatch):
    install(monkeypatch, TOY)


def test_it_is_listed_run_and_compiled():
    run = simulate("paper-simulation", "toy", overrides={"clock.duration": 20.0})

    assert {"name": "toy", "title": "Toy law"} in law_table()
    assert run.outcome == "completed"
    assert np.hypot(run["x"] - run["x_d"], run["y"] - run["y_d"])[-1] < 0.3
    assert compile_law("toy").step().shape == (2,)


def test_its_gains_are_scenario_keys():
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


def test_an_entry_point_that_cannot_be_loaded_is_named(monkeypatch):
    entry = EntryPoint("lost", "nowhere_at_all:LAW", "wmr_ctrl.laws")
    monkeypatch.setitem(LAWS.plugins, "lost", entry)

    with pytest.raises(ArgumentError, match=r"'lost' = 'nowhere_at_all:LAW'.* cannot be loaded"):
        LAWS["lost"]


def test_a_law_is_found_by_the_name_that_it_gives_itself():
    assert len(LAWS) == len(set(LAWS)) > 3
    assert all(law.name == name for name, law in LAWS.items())
