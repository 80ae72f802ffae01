"""Errors state the fault, suggest similar names, and shorten values to a readable length."""

import math
import pickle
from fractions import Fraction

import pytest

from wmr_ctrl.core.errors import (
    MissingExtraError,
    UnknownKeyError,
    UnknownNameError,
    choices,
    install,
    library,
    printable,
    show,
)


@pytest.mark.parametrize(
    "value, text",
    [
        (True, "true"),
        ("a\nb", '"a b"'),
        (10**30 - 1, "9" * 30),
        (-(10**30), "an integer beyond 1e30"),
        (0.1, "0.1"),
        (math.inf, "inf"),
        (Fraction(1, 3), "Fraction(1, 3)"),
        ([1, [2.5, ["a", [[]]]]], '[1, [2.5, ["a", [...]]]]'),
        ({"a": 1}, "a table"),
        ("x" * 100, '"' + "x" * 56 + "..."),
    ],
)
def test_values_are_spelled_as_toml_would_and_cut(value, text):
    assert show(value) == text
    assert len(show([value] * 100)) <= 60


def test_a_name_that_is_not_known_comes_with_the_near_ones_and_all():
    error = UnknownNameError("law", "pdi", ["pid", "mb"], "Ask for one of them.")

    said = "no law is named 'pdi' (near: pid; known: mb, pid). Ask for one of them."
    assert str(error) == str(pickle.loads(pickle.dumps(error))) == said
    assert choices("zzz", []) == "known: none"


@pytest.mark.parametrize(
    "path, place", [("robot.mas", "in robot"), ("mas", "at the top of a scenario")]
)
def test_a_key_that_is_not_known_is_placed(path, place):
    said = f"{path} is not a key {place}; near: mass; known: mass."

    assert str(UnknownKeyError(path, ["mass"])) == said


def test_a_library_that_is_not_there_names_its_extra(tmp_path, monkeypatch):
    (tmp_path / "broken_one.py").write_text("raise ImportError('no symbol')")
    monkeypatch.syspath_prepend(tmp_path)

    assert library("math") is math
    with pytest.raises(MissingExtraError) as missing:
        library("no_such_package.part", "plot")
    assert (
        str(missing.value)
        == f"this needs no_such_package, which is not installed: {install('plot')}."
    )
    with pytest.raises(
        MissingExtraError, match=r"broken_one, which cannot be imported \(no symbol"
    ):
        library("broken_one")


def test_control_characters_become_blanks():
    assert printable("a\tb\x1b[c\u202e") == "a b [c "
