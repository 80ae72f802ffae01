"""Numbers on pages and pictures: cells of tables, bodies, bands, views, running means."""

import json
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from matplotlib.figure import Figure

from tests.papers_robot import paper
from tests.results.conftest import build
from wmr_ctrl.core.errors import ArgumentError, ResultFileError
from wmr_ctrl.report import course, scene
from wmr_ctrl.report.course import Course, band, course_of
from wmr_ctrl.report.drawing import FAR, running_mean, target_of, view_limits
from wmr_ctrl.report.scene import outline, scene_of
from wmr_ctrl.report.study_table import PREFERRED, StudyTable, read_study
from wmr_ctrl.report.tables import _Line, ranged, stress_table
from wmr_ctrl.results.table import spread, table_of_rows
from wmr_ctrl.world.scenario import override, to_toml


def test_a_cell_has_its_range_only_where_numbers_differ():
    assert ranged(spread([0.5, 2.0, 1.0])) == "1.00 (0.500 … 2.00)"
    assert ranged(spread([1.0, 1.0])) == "1.00"
    assert ranged(spread([0.001, 0.003]), 1e3) == "2.00 (1.00 … 3.00)"
    assert ranged(spread([None])) == "–"


@pytest.mark.parametrize(
    "figure, factor, unit",
    [("position_rms", 1e3, "mm"), ("e3_rms_70_80", 1e3, "mrad"), ("tau_peak", 1.0, "N m")],
)
def test_lengths_and_angles_are_in_thousandths(figure, factor, unit):
    line = _Line(figure, "a figure")

    assert line.factor == factor
    assert line.name(build().settings) == f"a figure [{unit}]"


def test_seeds_beyond_the_limit_are_counted_in_their_own_case():
    rows = [
        {"case": case, "law": "mb", "seed": k, "violated": float(ratio > 1), "limit_ratio": ratio}
        for case, ratios in (("one", (0.9, 1.2)), ("other", (1.5, 1.5)))
        for k, ratio in enumerate(ratios)
    ]

    table = stress_table(table_of_rows(rows), {"one": "one", "other": "other"})

    assert table.rows == (
        ("one", "1 of 2: 1.050 (0.9000 … 1.200)"), ("other", "2 of 2: 1.500"),
    )  # fmt: skip


def test_a_body_looks_along_its_heading_and_right_is_right():
    ahead = outline(np.array([1.0, 2.0, 0.0]), 0.8, 0.5, 0.25)
    turned = outline(np.array([1.0, 2.0, -np.pi / 2]), 0.8, 0.5, 0.25)

    assert ahead.mean(axis=0) == pytest.approx([1.25, 2.0])
    assert np.ptp(ahead, axis=0) == pytest.approx([0.5, 0.8])
    assert turned.mean(axis=0) == pytest.approx([1.0, 1.75])
    assert np.ptp(turned, axis=0) == pytest.approx([0.8, 0.5])


def test_a_band_is_as_wide_on_both_sides_and_widest_where_the_path_rests():
    path = np.array([[0.0, 1.0, 2.0, 2.0, 2.0, 3.0, 4.0], np.zeros(7)])
    width = np.array([0.1, 0.1, 0.1, 0.4, 0.2, 0.1, np.nan])

    left, right = np.split(band(path, width), 2, axis=1)

    assert left[0] == pytest.approx([0.0, 1.0, 2.0, 3.0])
    assert left[1] == pytest.approx([0.1, 0.1, 0.4, 0.1])
    assert right[:, ::-1] == pytest.approx(np.array([left[0], -left[1]]))
    assert band(path[::-1], width)[0, :4] == pytest.approx([-0.1, -0.1, -0.4, -0.1])
    assert band(np.zeros((2, 3)), np.ones(3)).shape == (2, 0)


@pytest.mark.parametrize("arrival, there", [(0.5, True), (0.99, True), (1.5, False)])
def test_a_goal_is_shown_once_the_desired_motion_was_there(arrival, there):
    run = build(x_d=2.0, y_d=3.0)

    goal = course_of(replace(run, settings=replace(run.settings, arrival=arrival))).goal

    assert goal == ((2.0, 3.0) if there else None)


def test_runs_of_another_limit_or_reference_are_not_in_one_picture():
    run = build(x_d=np.linspace(0, 1, 100))
    limited = replace(run, settings=replace(run.settings, v_u1=(0.9, 1.5)))
    other = build(x_d=np.linspace(0, 1.1, 100))  # begins alike

    assert len(scene_of([run, run], 10).actors) == 2
    for one in (limited, other):
        with pytest.raises(ArgumentError, match="different limits or follow different references"):
            scene_of([run, one], 10)


def test_a_view_holds_the_bodies_and_these_are_as_wide_as_the_robot():
    drawn = scene_of([build(x=np.linspace(-1, 3, 100))], 10)
    wide = replace(drawn, course=Course(half_track=0.5))

    assert drawn.view == pytest.approx((-1.7, 3.7, -2.7, 2.7))
    assert (drawn.size, wide.size) == (1.0, 2.0)


@pytest.mark.parametrize("width", [1, 4, 5])
def test_a_gliding_mean_is_centred_and_keeps_what_is_straight(width):
    line = np.arange(20.0)
    inner = slice(width, -width)

    off = 0.5 if width % 2 == 0 else 0.0
    assert running_mean(line, width)[inner] == pytest.approx(line[inner] - off)
    assert running_mean(np.ones(20), width) == pytest.approx(np.ones(20))


def test_what_is_beyond_four_times_a_limit_leaves_the_view_and_is_named():
    axes = Figure().add_subplot()
    values = np.array([0.0, 3.9, -9.0])
    axes.plot(values)

    view_limits(axes, (-1.0, 1.0), {"mb": values})

    low, high = axes.get_ylim()
    assert (FAR, low) == (4.0, -4.0)
    assert 3.9 < high <= 4.0
    assert axes.get_xlabel().strip() == "(out of view: mb ↓ −9.00)"


@pytest.mark.parametrize("guard", [False, True])
def test_a_corridor_is_that_of_the_runs_own_guard_until_the_robot_changes(monkeypatch, guard):
    told = {"scenario_toml": to_toml(override(paper(), {"guard.enabled": not guard}))}
    run = build(rows=80, labels={"law": "mb", "guard": guard}, provenance=told)
    asked = []

    def tube(scenario, law):
        asked.append((scenario.guard.enabled, law))
        return SimpleNamespace(course=np.array([[0.1, 0.2, 0.3], [1.0, 2.0, 3.0]]), until=0.5)

    monkeypatch.setattr(course, "corridor_course", tube)
    found = course.course_behind(run)

    assert asked == [(guard, "mb")]
    assert found[:, :4].tolist() == [[0.1, 0.2, 0.3, 0.3], [1.0, 2.0, 3.0, 3.0]]
    assert np.isnan(found[0]).tolist() == [False] * 50 + [True] * 30


def test_a_corridor_is_drawn_as_long_as_its_run_lasted(monkeypatch):
    whole, short = build(), build(rows=50)
    widths = np.array([np.linspace(0.1, 0.2, 100), np.zeros(100)])
    monkeypatch.setattr(scene, "course_of_tube", lambda run: widths[:, : run.rows])

    drawn = scene.with_tubes(scene_of([whole, short], 10), [whole, short])

    first, second = drawn.actors
    assert not np.isnan(first.tube).any()
    assert np.isnan(second.tube).tolist() == (drawn.t > short.time[-1]).tolist()


def test_a_course_has_what_is_to_be_kept_out_of():
    shapes = [[1.0, 1.0, 0.3], [[-1.0, -2.0], [3.0, -2.0], [3.0, -1.0]]]
    wall = ((4.0, -1.0), (4.0, 1.0))
    given = {"reference.keep_out": shapes, "world.wall": wall, "body.radius": 0.2}
    text = to_toml(override(paper(), given))

    assert course_of(build(duration=1.0, provenance={"scenario_toml": text})).keep_out == (
        (1.0, 1.0, 0.3), ((-1.0, -2.0), (3.0, -2.0), (3.0, -1.0)), wall,
    )  # fmt: skip


def test_a_picture_may_have_any_case_and_is_looked_at_where_it_is_written(tmp_path):
    (tmp_path / "file").touch()
    inside = tmp_path / "file" / "plot.png"

    assert target_of(tmp_path / "PLOT.PNG", (".png",), "one") == tmp_path / "PLOT.PNG"
    assert target_of(inside, (".png",), "one", write=False) == inside
    with pytest.raises(ResultFileError):
        target_of(inside, (".png",), "one")


@pytest.mark.parametrize(
    "figures, drawn",
    [
        (["tau_peak", "violated"], "tau_peak"), (["tau_peak", PREFERRED[1]], PREFERRED[1]),
        ([PREFERRED[1], PREFERRED[0]], PREFERRED[0]),
    ],
)  # fmt: skip
def test_without_a_figure_of_tracking_the_first_of_the_plan_is_drawn(figures, drawn):
    none = np.array([])

    assert StudyTable({"figures": figures}, {}, none, none, none, {}).figure == drawn


def test_rows_of_a_study_are_of_a_law_with_or_without_the_guard(tmp_path):
    plan = {"figures": ["violated"], "grid": {}, "sample": None}
    (tmp_path / "study.json").write_text(json.dumps({"plan": plan}))
    (tmp_path / "columns.csv").write_text("name,unit\nviolated,1\n")
    (tmp_path / "table.csv").write_text(
        "index,law,guard,outcome,refusal,violated\n0,mb,true,completed,,0\n"
        "1,mb,false,completed,,1\n"
    )

    found = read_study(tmp_path)
    assert found.group.tolist() == ["mb, guarded", "mb"]
    assert found.numbers["violated"].tolist() == [0.0, 1.0]
