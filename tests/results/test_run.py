"""Run, Settings, Monitor: access by name, read-only arrays, and refusal of contradictions."""

import copy
import dataclasses
import pickle

import numpy as np
import pytest

from tests.equal_runs import runs_equal
from tests.results.conftest import build
from wmr_ctrl.core.errors import ArgumentError, UnknownNameError
from wmr_ctrl.core.signals import LOG_HEAD
from wmr_ctrl.results import Monitor, Outcome, Run


def test_columns_and_elements_are_reached_by_name():
    pairs = np.arange(200.0).reshape(100, 2)
    run = build(v_c0=pairs, v1=7.0)
    names = [signal.name for signal in run.elements]

    assert np.array_equal(run["v_c0"], pairs)
    assert np.array_equal(np.stack([run["v_c0[1]"], run["v_c0[2]"]], axis=1), pairs)
    assert set(run["v1"]) == {7.0}
    assert np.array_equal(run.time, run["t"])
    assert names == [name for signal in LOG_HEAD for name in signal.elements]
    assert all(run[name].shape == (run.rows,) and name in run for name in names)
    assert (run.signal("v_c0").size, run.signal("v_c0[2]").size) == (2, 1)
    assert run.signal("v_c0[2]").unit == "rad/s"
    assert run.signal("v_c0[2]").meaning == run.signal("v_c0").meaning


@pytest.mark.parametrize("name", ["v_c0[0]", "v_c0[3]", "x[1]", "W_norm", "", "v_c"])
def test_unknown_names_are_refused_with_the_known_ones(name):
    run = build()

    assert name not in run
    with pytest.raises(UnknownNameError, match=r"known: .*v_c0"):
        run[name]
    with pytest.raises(UnknownNameError, match="no column"):
        run.signal(name)


def test_arrays_are_copies_that_nobody_can_change():
    mine = np.ones(100)
    run = build(x=mine)
    mine[:] = 5.0

    assert np.array_equal(run["x"], np.ones(100))
    with pytest.raises(ValueError, match="read-only"):
        run["x"][0] = 2.0
    with pytest.raises(ValueError, match="read-only"):
        run["e[1]"][0] = 2.0
    with pytest.raises(TypeError):
        run.columns["x"] = mine  # type: ignore[index]
    with pytest.raises(dataclasses.FrozenInstanceError):
        run.law = "pid"  # type: ignore[misc]


def test_a_run_survives_pickling_and_copying():
    run = build(x=3.0, provenance={"version": "1"})

    again = pickle.loads(pickle.dumps(run))

    assert isinstance(again, Run)
    assert runs_equal(again, run)
    assert runs_equal(copy.deepcopy(run), run)
    assert not again["x"].flags.writeable


RUN = build()
LOGGED = RUN.columns


@pytest.mark.parametrize(
    "field, value, message",
    [
        ("columns", {**LOGGED, "x": LOGGED["x"][:-1]}, r"'x'.* must be \(100,\)"),
        ("columns", {**LOGGED, "e": LOGGED["e"][:, :2]}, r"'e'.* must be \(100, 3\)"),
        ("columns", {k: v for k, v in LOGGED.items() if k != "x"}, "each signal"),
        ("columns", {**LOGGED, "t": LOGGED["t"] + 1}, "in row k"),
        ("columns", {**LOGGED, "t": LOGGED["t"] * np.nan}, "in row k"),
        ("signals", RUN.signals[1:], "begin with the time"),
        ("signals", (*RUN.signals, RUN.signals[1]), "each signal"),
        ("outcome", Outcome.DIVERGED, "outcome_of"),
        ("guard", 1, "guard = 1"),
        ("law", None, "law = None"),
        ("settings", dataclasses.replace(RUN.settings, duration=0.5), "100 rows, more than"),
    ],
)
def test_contradictions_are_refused(field, value, message):
    with pytest.raises(ArgumentError, match=message):
        dataclasses.replace(RUN, **{field: value})


def test_repr_is_one_short_line():
    text = repr(build(labels={"guard": True}))

    assert text == "<Run toy, nn, guarded, seed 0, native: 100 rows, completed>"


@pytest.mark.parametrize(
    "fields",
    [
        {"violations": 1},
        {"first_violation": (0.0, 1)},
        {"violations": 1, "first_violation": (0.0, 4)},
        {"stopped": (0.0, 1)},
        {"stop_reason": "diverged"},
        {"stop_reason": "tired", "stopped": (0.0, 1)},
        {"stop_reason": "diverged", "stopped": (0.0, 0)},
    ],
)
def test_a_monitor_that_contradicts_itself_is_refused(fields):
    with pytest.raises(ArgumentError, match="monitor"):
        Monitor((0.0, 0.0), **fields)  # type: ignore[arg-type]
