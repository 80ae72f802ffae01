"""Entries of other packages, and errors in code of other authors."""

from importlib.metadata import EntryPoint

import pytest

from wmr_ctrl.core.errors import ArgumentError, ScenarioError
from wmr_ctrl.core.fields import plugins
from wmr_ctrl.core.fields.plugins import blamed, load, loaded


def broken():
    raise KeyError("of theirs")


def test_an_error_of_theirs_is_told_with_its_place():
    with pytest.raises(ArgumentError) as caught, blamed("their law", "Ask them."):
        broken()

    line = broken.__code__.co_firstlineno + 1
    assert (
        str(caught.value)
        == f"their law: KeyError: 'of theirs' ({__file__}, line {line}). Ask them."
    )


def test_one_in_a_library_is_placed_where_their_function_begins_and_ours_pass():
    with pytest.raises(ArgumentError) as caught, blamed("it", "Ask.", function=broken):
        "".encode("no such code")
    line = broken.__code__.co_firstlineno
    assert f"line {line})" in str(caught.value) or "test_plugins.py" in str(caught.value)

    with pytest.raises(ScenarioError, match=r"^ours$"), blamed("it", "Ask."):
        raise ScenarioError("ours")


def test_entry_points_are_of_a_kind_and_in_the_order_of_their_names(monkeypatch):
    points = [EntryPoint("b", "math:pi", "g"), EntryPoint("a", "math:e", "g")]
    monkeypatch.setattr(plugins, "entry_points", lambda group: points)

    assert loaded("g", float) == pytest.approx((2.718281828459045, 3.141592653589793))
    with pytest.raises(ArgumentError, match=r"'a' = 'math:e' of the group g gives 2\.7.* to a str"):
        loaded("g", str)
    with pytest.raises(ArgumentError, match=r"'c' = 'math:no' of the group g cannot be loaded"):
        load(EntryPoint("c", "math:no", "g"), "g")
