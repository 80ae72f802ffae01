"""Tables of logs are read in the forms that people have them, and what is not read is named."""

from __future__ import annotations

import pytest

from wmr_ctrl.core.errors import WmrError
from wmr_ctrl.identification.logs.log import log_of

ROWS = [(0.0, 0.5, 0.1), (0.5, 0.25, 0.2), (1.0, -1.5, 0.3)]


def text(head, separator=",", scale=(1, 1, 1), decimal=".", end="\n"):
    rows = [
        [repr(x * s).replace(".", decimal) for x, s in zip(row, scale, strict=True)] for row in ROWS
    ]
    return end.join(([head] if head else []) + [separator.join(row) for row in rows]) + end


FORMS = {
    "ours": (text("t [s],v1 [m/s],omega [rad/s]"), {}),
    "no units": (text("t,v1,omega"), {}),
    "byte order mark": ("\ufeff" + text("t,v1,omega"), {}),
    "lines of DOS": (text("t,v1,omega", end="\r\n"), {}),
    "comment": (text("# a drive\n# t [s], v1 [m/s], omega [rad/s]"), {}),
    "tabs": (text("t [s]\tv1 [m/s]\tomega [rad/s]", "\t"), {}),
    "blanks": (text("t [s]  v1 [m/s]  omega (rad/s)", "  "), {}),
    "decimal commas": (text("t;v1;omega", ";", decimal=","), {}),
    "units": (text("t (ms),v1[km/h],omega [deg/s]", scale=(1e3, 3.6, 57.29577951308232)), {}),
    "centimetres": (text("t_us,v1 [cm/s],omega [rpm]", scale=(1e6, 100, 9.549296585513721)), {}),
    "names": (text("time,cmd,turn"), {"t": "time", "v1": "cmd", "omega": "turn"}),
    "units of names": (
        text("/time_ms,/a/x,/a/z", scale=(1e3, 100, 1)),
        {"t": "/time_ms [ms]", "v1": "/a/x [cm/s]", "omega": "/a/z"},
    ),
    "no names": (text(""), {"t": "1", "v1": "2", "omega": "3"}),
}  # fmt: skip


@pytest.mark.parametrize("form", FORMS)
def test_a_table_is_the_same_in_every_form(tmp_path, form):
    content, columns = FORMS[form]
    (tmp_path / "log.csv").write_bytes(content.encode())

    log = log_of(tmp_path / "log.csv", columns=columns)

    assert log.times["v1"].tolist() == pytest.approx([0.0, 0.5, 1.0])
    assert log.columns["v1"].tolist() == pytest.approx([0.5, 0.25, -1.5])
    assert log.columns["omega"].tolist() == pytest.approx([0.1, 0.2, 0.3])
    assert log.remarks == ()


def test_columns_of_text_and_a_last_row_that_is_cut_off_are_named(tmp_path):
    (tmp_path / "log.csv").write_text(
        't,mode,v1,omega\n0,auto,1,2\n1,"by, hand",,\n2,auto,3,4\n3,a'
    )

    log = log_of(tmp_path / "log.csv")

    assert log.columns["v1"].tolist() == [1.0, 3.0]
    assert "not read: mode" in log.remarks[0]
    assert "line 5 is cut off" in log.remarks[1]


@pytest.mark.parametrize(
    ("content", "columns", "word"),
    [
        ("t,v1 [%],omega\n0,1,2\n", {}, "column v1 is in per cent"),
        ("t_ms [s],v1,omega\n0,1,2\n", {}, "the name of column t_ms says ms, and its unit s"),
        ("t,v1 [kg],omega\n0,1,2\n", {}, "which does not fit it. Give it in m/s"),
        ("time,v1,omega\n0,1,2\n", {}, "no column is named t. There are time, v1, omega"),
        ("t,a,a\n0,1,2\n", {"v1": "a"}, "2 columns are named"),
        ("t,a,b\n0,1,2\n", {"v1": "c"}, "no columns are named"),
        ("t,a,b\n0,1,2\n", {"speed": "a"}, "is not read; names are t"),
        ("t,v1,omega\n0,1,2\n1,2\n2,3,4\n", {}, "line 3: it has another number of cells"),
        ("", {}, "no column is named t"),
        ("t,v1,omega\n", {}, "no rows of numbers"),
        ("t,v1,omega\n0,\0,1\n1,2,3\n", {}, "log.csv"),
    ],
)  # fmt: skip
def test_what_cannot_be_read_is_told_in_one_paragraph(tmp_path, content, columns, word):
    (tmp_path / "log.csv").write_text(content)

    with pytest.raises(WmrError) as told:
        log_of(tmp_path / "log.csv", columns=columns)
    assert word in str(told.value)
    assert "\n" not in str(told.value)
