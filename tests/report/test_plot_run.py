"""The one-page picture of a run."""

import re
from dataclasses import replace
from html import unescape

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.text import Text

from tests.results.conftest import build
from tests.tables import cases
from wmr_ctrl.api import simulate
from wmr_ctrl.core.errors import ArgumentError, ResultFileError
from wmr_ctrl.report import style
from wmr_ctrl.report.course import course_of_tube
from wmr_ctrl.report.drawing import FAR
from wmr_ctrl.report.plot_run import plot_run
from wmr_ctrl.report.plot_runs import plot_runs
from wmr_ctrl.report.run_rows import rows_of
from wmr_ctrl.report.scene import scene_of
from wmr_ctrl.report.stage import frames
from wmr_ctrl.results import Monitor
from wmr_ctrl.world.scenario import load_scenario, override, to_toml

STOPPED = Monitor((1000.0, 2.0), 5, (0.02, 1), (0.05, 1), "diverged")


@pytest.mark.parametrize("suffix, magic", [(".png", b"\x89PNG"), (".svg", b"<?xml")])
def test_a_run_is_drawn_alone_or_over_another(fake_simulate, tmp_path, suffix, magic):
    path, run = tmp_path / f"run{suffix}", fake_simulate("paper-simulation", "nn", 0)
    if suffix == ".png":
        plot_run(run, path)
    else:
        plot_runs([run, run], path)

    assert path.read_bytes().startswith(magic)
    assert [p.name for p in tmp_path.iterdir()] == [path.name]


@pytest.mark.slow
def test_a_name_is_no_formula(tmp_path, monkeypatch):
    name = 'a$\\frac$b $x_{$ \\$\ntwo lines "<&>*/'
    monkeypatch.setitem(style._COLOURS, "svg.fonttype", "none")
    path, run = tmp_path / "run.svg", build(duration=0.2, labels={"scenario": name})
    plot_run(run, path)
    next(frames(scene_of([run], 1)))

    assert name.replace("\n", " ") in unescape(path.read_text("utf-8"))


@pytest.mark.parametrize("wall", [None, ((4.0, -1.0), (4.0, 1.0))])
def test_a_run_among_obstacles_shows_where_its_body_ends(wall):
    obstacles = {"world.wall": wall} if wall else {}
    stated = override(load_scenario("paper-simulation"), {**obstacles, "body.radius": 0.2})
    run = build(duration=1.0, provenance={"scenario_toml": to_toml(stated)})
    (map_,) = (item for item in plot_run(run).axes if "ring" in item.get_title("left"))
    circles = [item for item in map_.patches if not item.get_fill()]
    assert ("circle: end" in map_.get_title("left")) is bool(circles) is (wall is not None)
    for item in circles:
        assert (*item.center, item.radius) == (run["x"][-1], run["y"][-1], 0.2)


def test_an_empty_run_is_refused(tmp_path):
    with pytest.raises(ArgumentError):
        plot_run(build(rows=0, monitor=STOPPED), tmp_path / "run.png")


@pytest.mark.parametrize("name", ["run.jpg", "run", "missing/run.png"])
def test_places_that_cannot_be_written_are_refused(tmp_path, name):
    with pytest.raises(ResultFileError):
        plot_run(build(), tmp_path / name)
    assert not list(tmp_path.iterdir())


def labels(figure):
    """Labels of the x axes of a figure."""
    return [axes.get_xlabel() for axes in figure.findobj(Axes)]


def test_a_velocity_out_of_view_is_said_and_its_limit_seen():
    wild = build(duration=1.0, v1=np.linspace(0, 30.2, 100))
    figure = plot_run(wild)
    (axes,) = [one for one in figure.findobj(Axes) if one.get_title("left").startswith("v₁")]

    assert axes.get_xlabel().endswith("(out of view: ↑ 30.2)")
    assert axes.get_ylim()[1] == pytest.approx(FAR)
    assert not any("out of view" in text for text in labels(plot_run(build())))


def test_no_remark_lies_over_curves():
    errors = np.linspace([20.0, -2.0, 3.0], [-70.0, 0.0, 0.0], 100)
    figure = plot_run(build(duration=1.0, e=errors))
    texts = [text.get_text() for axes in figure.findobj(Axes) for text in axes.texts]
    titles = [axes.get_title("left") for axes in figure.findobj(Axes)]

    assert texts == []
    assert "t [s]   (logarithmic beyond ±10 mrad)" in labels(figure)
    assert "Position errors, Eq. (8) [m]" in titles
    assert "Orientation error e₃ [mrad]" in titles


def test_the_figures_of_a_run_are_those_that_the_command_line_prints():
    run = build(duration=12.0)
    texts = "\n".join(text.get_text() for text in plot_run(run).findobj(Text))

    assert all(f"{name}: {said}"[:50] in texts for name, said in rows_of(run))


@pytest.mark.slow
def test_nothing_is_certified_of_another_plant_or_order_of_steps():
    """The certificate is about the plane model, with the torque delay of the scenario."""
    run = simulate(load_scenario("safe-simulation", {"clock.duration": 0.1}), "prox")
    other = replace(run, settings=replace(run.settings, plant_kind="fmu"))
    late = replace(run, provenance={**run.provenance, "master": "jacobi"})

    assert course_of_tube(run) is not None
    assert course_of_tube(other) is None
    assert course_of_tube(late) is None
    text = "\n".join(item.get_text() for item in plot_run(other).findobj(Text))
    assert "somebody else's plant" in text
    assert "certified" not in text


@pytest.mark.slow
def test_a_robot_that_turned_once_about_itself_stands_on_its_path_again():
    """Its orientation error is a whole turn, and its heading is the desired one."""
    told = {"initial.pose": [2.4, 0.5, 0.0], "clock.control": 0.02}
    run = simulate(override(load_scenario("safe-simulation"), told), "prox")
    figure = plot_run(run)
    tube = course_of_tube(run)
    (axes,) = (a for a in figure.findobj(Axes) if "Orientation error" in a.get_title(loc="left"))
    (drawn,) = (line.get_ydata() for line in axes.get_lines() if line.get_label() == "e₃")

    assert abs(run["e[3]"][-1]) > 6
    assert abs(drawn[-1]) <= 1e3 * tube[1, -1]


@pytest.mark.parametrize(
    "preset, law, panels",
    cases("""
    turtlebot3-burger | kanayama | Changed by, Distance from
    turtlebot3-burger | mb | Changed by, Barrier function
    paper-simulation-nominal | kanayama | Wheel torques, Distance from
    paper-simulation-nominal | mb | Wheel torques, Barrier function
    """),
)
def test_panels_are_those_of_the_base_and_the_law(preset, law, panels):
    short = {"clock.duration": 1.0, "metrics.split": 0.5, "metrics.rms_from": 0.2}
    run = simulate(load_scenario(preset, short), law, engine="numpy")
    titles = " ".join(axes.get_title("left") for axes in plot_run(run).findobj(Axes))
    known = "Changed by|Wheel torques|Distance from|Barrier function"

    assert re.findall(known, titles) == panels.split(", ")
