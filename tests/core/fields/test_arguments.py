"""Any argument of a public function or value gives a result, or one sentence about the error."""

import inspect
from functools import partial
from pathlib import Path

import numpy as np
import pytest

import wmr_ctrl
from tests.papers_robot import paper
from wmr_ctrl.core.errors import ArgumentError, UnknownNameError, WmrError
from wmr_ctrl.core.fields.arguments import hints_of
from wmr_ctrl.results.drive import drive_of

SHORT = {"clock.duration": 0.05}
SCENARIO, LAW = "paper-simulation", "pid"
RUN = partial(wmr_ctrl.simulate, SCENARIO, LAW, overrides=SHORT)
GOOD = {
    "RecordedDrive": {},
    "Run": {},
    "Scenario": {},
    "command_filter": {"scenario": "no scenario"},
    "compare": {"first": "no run", "second": "no run"},
    "compile_law": {"law": LAW},
    "cosimulate": {"scenario": SCENARIO, "law": "no law"},
    "export_fmu": {"what": "guard", "out": "fmus"},
    "identify": {"log": "no log"},
    "linear_against_run": {"scenario": "no scenario"},
    "linearize": {"scenario": "no scenario", "law": LAW},
    "load_drive": {"path": "drive.mcap"},
    "load_run": {"path": "run.npz"},
    "load_scenario": {"name_or_path": SCENARIO},
    "prove": {"only": ("no entry",)},
    "reproduce": {"seeds": 0},
    "simulate": {"scenario": SCENARIO, "law": LAW, "overrides": SHORT},
    "simulate_many": {"scenario": SCENARIO, "law": LAW, "overrides": SHORT, "seeds": [1]},
    "simulate_runs": {"scenario": SCENARIO, "law": LAW, "overrides": SHORT, "seeds": [1]},
    "study": {"plan": {"scenario": SCENARIO, "laws": [LAW], "seeds": 1, "set": SHORT},
              "out": "study"},
    "tune": {"scenario": SCENARIO, "law": "mb", "out": "mine.toml", "trials": 0},
    "write_page": {"out": "page.html", "scenario": "no scenario"},
}  # fmt: skip
"""Arguments of a short call; of what takes long, such as are refused when all types are right."""


def DRIVE():
    return drive_of(RUN())


LONG = {
    ("cosimulate", "law"): {"None"},
    ("prove", "only"): {"no list", "no table", "array"},
    ("reproduce", "quick"): {"True"},
}
"""Functions that accept the arguments but take long: whole runs, every entry of the ledger."""


class Unfit:
    def __repr__(self):
        raise RuntimeError("a value that cannot be shown")


BAD = {
    "None": None, "zero": 0, "minus one": -1, "a half": 0.5, "nan": float("nan"),
    "inf": float("inf"), "2^70": 2**70, "2^10000": 2**10000, "True": True, "empty": "",
    "a word": "word", "NUL": "a\0b", "surrogate": "\ud800", "a long text": "x" * 10_000,
    "bytes": b"nn", "no list": [], "a list": [1, "a", None], "no table": {}, "a table": {1: 2},
    "object": object(), "unfit": Unfit(), "array": np.ones(2), "an array of one": np.array(4),
    "a class": Exception, "a function": lambda *args: None, "folder": Path(),
    "NUL path": Path("\0"), "endless": range(2**62),
}  # fmt: skip


@pytest.fixture(autouse=True)
def elsewhere(tmp_path, monkeypatch):
    """Folder for the files that successful calls write."""
    monkeypatch.chdir(tmp_path)


def refused_in_a_sentence(call):
    """Return whether a call is refused with a WmrError, whose text must end in a full stop."""
    try:
        call()
    except WmrError as error:
        text = str(error)
    else:
        return False
    assert text.rstrip().endswith(".")
    assert text.isprintable()
    return True


def test_every_public_name_is_walked():
    functions = {n for n in wmr_ctrl.__all__ if inspect.isfunction(getattr(wmr_ctrl, n))}

    assert {name for name in GOOD if GOOD[name]} <= functions <= set(GOOD)


@pytest.mark.parametrize("name", [name for name in GOOD if GOOD[name]])
@pytest.mark.slow_but(
    "compile_law",
    "load_run",
    "load_scenario",
    "prove",
    "reproduce",
    "simulate",
    "write_page",
)
def test_every_argument_of_a_public_function(name):
    function, good = getattr(wmr_ctrl, name), GOOD[name]
    refusals = [
        refused_in_a_sentence(partial(function, **{**good, argument: value}))
        for argument in hints_of(function)
        for key, value in BAD.items()
        if key not in LONG.get((name, argument), ())
    ]

    assert sum(refusals) > len(refusals) / 2


@pytest.mark.parametrize("name", [name for name in GOOD if GOOD[name]])
def test_missing_and_unknown_arguments(name):
    function = getattr(wmr_ctrl, name)
    needed = [
        key for key, item in inspect.signature(function).parameters.items()
        if item.default is item.empty and item.kind is not item.VAR_KEYWORD
    ]  # fmt: skip
    if needed:
        with pytest.raises(ArgumentError, match=needed[0]):
            function()
    with pytest.raises(UnknownNameError, match="known: "):
        function(**GOOD[name], no_such_argument=1)


METHODS = [
    (paper, method) for method in ("table", "section", "number", "value")
] + [
    (RUN, method) for method in ("__getitem__", "signal", "save", "plot", "animate")
] + [
    (DRIVE, method) for method in ("__getitem__", "save", "plot")
]  # fmt: skip


@pytest.mark.parametrize("make, method", METHODS, ids=[method for _, method in METHODS])
def test_every_argument_of_a_public_values_method(make, method):
    call = getattr(make(), method)

    accepted = [
        key for key, value in BAD.items() if not refused_in_a_sentence(partial(call, value))
    ]

    assert accepted == (["None"] if method == "plot" else [])


@pytest.mark.parametrize("make", [RUN, DRIVE], ids=["run", "drive"])
def test_every_field_of_a_result(make):
    good = make()
    kind = type(good)
    fields = {name: getattr(good, name) for name in hints_of(kind.__init__)}
    refusals = [
        refused_in_a_sentence(partial(kind, **{**fields, name: value}))
        for name in fields
        for value in BAD.values()
    ]

    assert sum(refusals) > 0.8 * len(refusals)


def test_every_field_of_a_scenario():
    for name in hints_of(wmr_ctrl.Scenario.__init__):
        for value in BAD.values():
            refused_in_a_sentence(partial(wmr_ctrl.Scenario, **{name: value}))
