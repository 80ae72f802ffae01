"""The section on the rigid body, from made-up rows: its sentences, its table, its file."""

from __future__ import annotations

import csv
import re

import pytest

from wmr_ctrl.report.report_page import report_environment
from wmr_ctrl.report.rigid_section import RigidSection, rigid_figures
from wmr_ctrl.report.write import write_runs
from wmr_ctrl.results.table import table_of_rows
from wmr_ctrl.simulation.campaign import Campaign
from wmr_ctrl.simulation.campaign.plan import PlannedCase
from wmr_ctrl.simulation.campaign.rigid import AS_PRINTED, COMPARED, E1, E1_BEFORE

LIMITED = "torque limit 10 N m"


def row(name, law, plant, seed=0, **values):
    known = {"ise_total": 1.0, E1_BEFORE: 0.001, E1: 0.001, "limit_ratio": 0.9}
    known |= {"slipped": None, "tipped": None}
    case = PlannedCase("paper-simulation", law, plant=plant, name=name)
    return {**case.labels, "seed": seed, "outcome": "completed", **known, **values}


FELL = {"ise_total": None, E1: None, "slipped": 0.003, "tipped": 4.0, "limit_ratio": 3.0}
ROWS = table_of_rows(
    (
        row(AS_PRINTED, "mb", "ode"),
        row(AS_PRINTED, "mb", "mujoco", **FELL),
        row(LIMITED, "mb", "ode"),
        row(LIMITED, "mb", "ode", 1),
        row(LIMITED, "mb", "mujoco", ise_total=1.02),
        row(LIMITED, "mb", "mujoco", 1, ise_total=0.99, slipped=0.5, limit_ratio=1.1),
    )
)


@pytest.fixture(scope="module")
def page():
    template = report_environment().get_template("rigid.html.j2")
    return template.render(rigid=RigidSection(Campaign(ROWS)), picture=str)


def rows_below(page, caption):
    """Texts of the cells of a table, row by row."""
    body = page.partition(f"<caption>{caption}")[2].partition("<tbody>")[2].partition("</tbody>")[0]
    return [tuple(re.findall(r">([^<>]+)</t[hd]>", line)) for line in body.split("<tr>")[1:]]


def test_the_sentences_are_those_of_the_rows(page):
    text = " ".join(page.split())

    assert "MB falls over in 1 of 1 runs, first after 4.00 s." in text
    assert "a tread slides in 1 of 2 runs, a limit is broken in 1, ISE within 2.0 %" in text


def test_a_fall_has_no_ise_and_what_never_slips_no_time(page):
    first, second = rows_below(page, "Plane model and rigid body")

    assert first[1:] == ("1.00", "–", "1.00", "–", "0.00300", "4.00")
    assert second[2] == "1.00 (0.990 … 1.02)"
    assert second[-1] == "–"


def test_without_whole_runs_nothing_is_drawn():
    assert rigid_figures(Campaign(ROWS)) == ()


def test_the_file_has_units_and_a_row_a_run(tmp_path):
    write_runs(tmp_path / "rigid.csv", ROWS, ("plant",), COMPARED)
    text = (tmp_path / "rigid.csv").read_text(encoding="utf-8")
    head, *rows = csv.reader(text.splitlines())

    assert all(name.endswith("]") for name in head[5:])
    assert len(rows) == ROWS.rows
    assert rows[1][5] == ""


def test_verdicts_name_law_and_numbers(page):
    rows = rows_below(page, "What a robot with tyres ought to do")
    asked = "With 10 N m the ISE is within 5 % of the plane model’s"

    assert (asked, "MB", "HOLDS", "1 to 2 %") in rows
    assert ("With a torque limit of 10 N m it stays up and within its limits", "MB",
            "DOES NOT HOLD", "0.9 to 1.1 of the limit") in rows  # fmt: skip
