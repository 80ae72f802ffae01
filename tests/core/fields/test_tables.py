"""Users' tables: separators, names, units, and wrong rows."""

import math

import pytest

from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.core.fields.tables import TableReader

READER = TableReader("way", {"t": "s", "x": "m", "w": "rad/s"}, ("t",), unnamed=("t", "x"))


def columns(*lines):
    return {name: list(values) for name, values in READER.read(lines).columns.items()}


@pytest.mark.parametrize(
    "lines",
    [
        ("t,x", "0.5,1.25", "1.0,2.5"),
        ("t;x", "0,5;1,25", "1,0;2,5"),
        ("t x [mm]", "0.5 1250", "1.0 2500"),
        ("# t (ms),x_cm", "", "500,125", "1000,250"),
        ("0.5,1.25", "1.0,2.5"),
        ("T,x [km]", "0.5,0.00125", "1.0,0.0025"),
        ("\ufeffT\tx\tnote", "0.5\t1.25\t7", "# between", "1.0\t2.5\t8"),
    ],
)
def test_a_table_is_the_same_in_every_form(lines):
    found = columns(*lines)

    assert found["t"] == pytest.approx([0.5, 1.0])
    assert found["x"] == pytest.approx([1.25, 2.5])


def test_what_is_not_read_empty_or_cut_off_is_told():
    table = READER.read(["t,x,note", "0,,1", "1,2,3", "2,"])

    assert math.isnan(table.columns["x"][0])
    assert (list(table.lines), table.unread, table.cut) == ([2, 3], ("note",), 4)


@pytest.mark.parametrize(
    "lines, words",
    [
        (["a,x", "1,2"], "no column is named t. There are a, x."),
        (["t,T", "1,2"], "two columns are named t"),
        (["t,x [%]", "1,2"], "in per cent"),
        (["t,x [rad]", "1,2"], "column x is in"),
        (["t_ms [s],x", "1,2"], "says ms, and its unit s"),
        (["t,x", "1,2,3"], "line 2: it has another number of cells than the 2"),
        (["t,x", "1", "1,2"], "line 2: it has another number of cells"),
        (["t,x", "1,east"], 'line 2, column x: "east" is not a number'),
        (["t,x", '1,"2', "3,4"], "a quotation mark is not closed in its line"),
    ],
)
def test_what_is_wrong_is_placed(lines, words):
    with pytest.raises(ScenarioError) as caught:
        READER.read(lines)
    assert str(caught.value).startswith("way")
    assert words in str(caught.value)


def test_columns_are_named_by_hand_with_their_unit():
    named = TableReader("way", {"t": "s"}, ("t",), columns={"t": "stamp [ms]"})

    scaled = named.scaled({"stamp": [500.0, 750.0], "t2": [1.0, 2.0]})

    assert (list(scaled.columns["t"]), list(scaled.lines)) == ([0.5, 0.75], [1, 2])
    with pytest.raises(ScenarioError, match='no columns are named "stamp", which is to be t'):
        named.read(["time", "1"])


def test_columns_without_names_are_called_by_their_place():
    named = TableReader("way", {"t": "s", "x": "m"}, ("t",), columns={"x": "1", "t": "3 [ms]"})
    found = named.read(["7,8,500", "9,8,1000"]).columns

    assert list(found["t"]) == [0.5, 1.0]
    assert list(found["x"]) == [7.0, 9.0]
