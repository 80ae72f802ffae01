"""Laws that a user hands over."""

from pathlib import Path

import pytest

from tests.control.laws.toys import PLAIN, forget
from wmr_ctrl.control.laws.given import is_law_file, law_if_any, law_name, law_names
from wmr_ctrl.core.errors import ArgumentError


@pytest.mark.parametrize(
    "given, is_file",
    [
        ("mine.py", True),
        (Path("mine"), True),
        ("folder/mine", True),
        ("mine", False),
        ("pid", False),
    ],
)
def test_a_path_is_told_from_a_name(given, is_file):
    assert is_law_file(given) is is_file


def test_names_stay_names_and_a_law_is_known_by_its_own(monkeypatch):
    forget(monkeypatch)
    assert law_name("no such law") == "no such law"
    assert law_if_any(None) is None
    assert law_names(["pid", PLAIN]) == ("pid", PLAIN.name)


@pytest.mark.parametrize(
    "text, words",
    [
        ("A = 1", "defines no LAW. Write LAW = Law(...)"),
        ("LAW = 1", "line 1: LAW is 1, and must be a Law"),
        ("raise SystemExit", "cannot be loaded: RuntimeError: the file ends the program"),
        (
            "from wmr_ctrl.control.laws.pid import LAW as MINE",
            "Its law is called MINE: name it LAW",
        ),
    ],
)
def test_a_file_without_a_law_is_named(tmp_path, text, words):
    (tmp_path / "mine.py").write_text(text)

    with pytest.raises(ArgumentError) as caught:
        law_name("mine.py", tmp_path)
    assert words in str(caught.value)
