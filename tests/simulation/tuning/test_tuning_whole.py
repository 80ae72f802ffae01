"""Gains found by search: better on training."""

import sys
from itertools import pairwise

import pytest
from click.testing import CliRunner

import wmr_ctrl
from tests.tables import cases
from wmr_ctrl.cli import root
from wmr_ctrl.core.errors import ArgumentError, MissingExtraError, UnknownNameError
from wmr_ctrl.simulation.tuning.search import Cost, Search
from wmr_ctrl.world.scenario import load_scenario

SHORT = {"clock.control": 0.1, "clock.duration": 12.0, "changes": []}


@pytest.fixture(scope="module")
def short():
    return load_scenario("paper-simulation", SHORT)


def test_a_cost_keeps_the_order_of_certificates_of_lost_runs_and_of_distances():
    """The order holds at any distance: costs are not clipped, and earlier terms always win."""
    order = [
        Cost(False, 0, 1e-3), Cost(False, 0, 10.0), Cost(False, 0, 1e9), Cost(False, 1, 1e-3),
        Cost(True, 0, 1e-3), Cost(True, 0, 10.0), Cost(True, 0, 20.0), Cost(True, 1, 0.0),
    ]  # fmt: skip
    search = Search({"a": (1.0,), "b": (2.0, 3.0)})
    candidates = search.ask()
    while len(candidates) < len(order):
        candidates += candidates[:1]
    search.tell(candidates[:7], order[6::-1])

    assert all(first < second for first, second in pairwise(order))
    assert search.best() == search.gains(candidates[6])
    assert "without a corridor, 1 of the runs ended early" in order[-1].sentence


def test_an_unknown_merit_is_refused(tmp_path):
    pytest.importorskip("flint")
    curved = load_scenario("safe-simulation", {"reference.kind": "lemniscate"})

    with pytest.raises(ArgumentError, match="circles and lines alone are covered"):
        wmr_ctrl.tune(curved, "prox", tmp_path / "a.toml", merit="corridor")
    with pytest.raises(UnknownNameError, match="tracking"):
        wmr_ctrl.tune(curved, "prox", tmp_path / "a.toml", merit="speed")


def test_without_the_extra_it_says_what_to_install(short, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "cma", None)

    with pytest.raises(MissingExtraError, match=r"wmr_ctrl\[tune\]"):
        wmr_ctrl.tune(short, "prox", tmp_path / "a.toml")


@pytest.mark.parametrize(
    "given, told",
    cases("""
        --seeds 3 | not a range of seeds
        --seeds 5:5 | not a range of seeds
        --seeds 1:9 --test-seeds 8:12 | 8 serves training and test alike
        --trials 0 | --trials
        --weight nan | weight
        --out a.csv | must end in .toml
        --out no/a.toml | Create the folder first
        --law lqr | no law is named
        --hold gains.x,gains.pid.Kp | "gains.pid.Kp" would not change anyway; a search for prox
        --hold gains.prox.rho,gains.prox.wo --hold gains.kinematics.k | these are all
        --set gains.prox.wo=0 | above zero
    """),
)
def test_bad_input_is_one_paragraph(given, told, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    line = ["tune", "paper-simulation", "--law", "prox", "--out", "a.toml", *given.split()]
    done = CliRunner().invoke(root, line)

    assert done.exit_code == 2
    assert told in " ".join(done.stderr.split())
    assert not list(tmp_path.iterdir())
