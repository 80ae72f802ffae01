"""Columns over time from tables, each with its own times."""

import json

import pytest

from tests.tables import cases
from wmr_ctrl.core.errors import ResultFileError
from wmr_ctrl.results.tables import is_table, read_table, reader_of, timed

KNOWN = {"v1": "m/s", "omega": "rad/s"}


def read(tmp_path, content, columns=None):
    file = tmp_path / "log.csv"
    file.write_bytes(content.encode())
    reader = reader_of("log.csv", KNOWN, columns)
    return timed(read_table(file, reader), reader, ())


def test_columns_have_times_of_their_own_where_cells_are_empty(tmp_path):
    content = 't,mode,v1,omega\n0,auto,1,2\n1,"by, hand",,7\n,auto,9,9\n2,auto,3,\n3,a'
    times, columns, remarks = read(tmp_path, content)

    assert columns["v1"].tolist() == [1.0, 3.0]
    assert times["v1"].tolist() == [0.0, 2.0]
    assert columns["omega"].tolist() == [2.0, 7.0]
    assert "not read: mode" in remarks[0]
    assert "line 6 is cut off" in remarks[1]


@pytest.mark.parametrize("first, begin", [(1.7e9, 0.0), (12.0, 12.0)])
def test_times_of_a_clock_of_years_count_from_the_first_row(tmp_path, first, begin):
    times, _, _ = read(tmp_path, f"t,v1\n{first},1\n{first + 0.5},2\n")

    assert times["v1"].tolist() == [begin, begin + 0.5]


def test_a_column_without_a_number_is_none(tmp_path):
    times, columns, _ = read(tmp_path, "stamp_ms,a,omega\n500,1,\n", {"t": "stamp_ms", "v1": "a"})

    assert (list(columns), times["v1"].tolist()) == (["v1"], [0.5])


@pytest.mark.parametrize(
    "content, columns, word",
    cases("""
    t,v1,omega | {} | no rows of numbers
    t,v1;0, | {} | no rows of numbers
    time,v1,omega;0,1,2 | {} | no column is named t. There are time, v1, omega
    t,a,a;0,1,2 | {"v1": "a"} | 2 columns are named
    t,a,b;0,1,2 | {"speed": "a"} | is not read; names are t
    t,v1;0,\0;1,2 | {} | log.csv
    """),
)
def test_what_cannot_be_read_is_told_in_one_paragraph(tmp_path, content, columns, word):
    with pytest.raises(ResultFileError) as told:
        read(tmp_path, content.replace(";", "\n") + "\n", json.loads(columns))
    assert word in str(told.value)
    assert "\n" not in str(told.value)


def test_a_table_is_told_from_a_saved_run_by_its_first_line(tmp_path):
    for name, text in (("a.csv", "t,v1"), ("b.csv", "# {"), ("c.npz", "t,v1")):
        (tmp_path / name).write_text(text)

    assert [is_table(tmp_path / f"{name}") for name in ("a.csv", "b.csv", "c.npz", "d.txt")] == [
        True, False, False, False,
    ]  # fmt: skip
