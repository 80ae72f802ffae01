"""Waypoints from CSV files, good ones and bad ones."""

import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial import cKDTree

from tests.papers_robot import HEAD
from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.world.references.point_files import read_points
from wmr_ctrl.world.references.spline import simplified
from wmr_ctrl.world.references.waypoints import waypoint_path
from wmr_ctrl.world.scenario import load_scenario

GOOD = ((0.0, 0.0), (1.0, 0.5), (2.0, -1.0))


@pytest.mark.parametrize(
    "text",
    [
        "0,0\n1,0.5\n2,-1\n",
        "x,y\n0,0\n1,0.5\n2,-1",
        "x [m], y [m]\r\n0, 0\r\n1, 5e-1\r\n2, -1\r\n",
        "# a track\n\n0,0\n1,0.5\n\n2,-1\n\n",
        '"0","0"\n"1","0.5"\n"2","-1"\n',
        "y,x\n0,0\n0.5,1\n-1,2\n",
        "Y (m),X[m]\n0,0\n0.5,1\n-1,2\n",
        '"X [ m ]", "Y"\n0,0\n1,0.5\n2,-1\n',
        "# a track\n# y, x\n0,0\n0.5,1\n-1,2\n",
        "# x,y\nx [m],y [m]\n0,0\n1,0.5\n2,-1\n",
        "# x-ray, yellow\n0,0\n1,0.5\n# y,x\n2,-1\n",
        "x;y\n0;0\n1;0,5\n2;-1\n",
        "0;0\n1;0.5\n2;-1\n",
        "x\ty\n0\t0\n1\t0,5\n2\t-1\n",
        "# x y\n0.0 0.0\n1.0  0.5\n  2.0 -1.0\n",
        "# a\nx [mm],y [mm]\n0,0\n1000,500\n2000,-1000\n",
        "# x_mm,y_cm\n0,0\n1000,50\n2000,-100\n",
        "t,y,theta,x\n0,0,1,0\n1,0.5,1,1\n2,-1,1,2\n",
        "# x,y,theta\n0,0,1\n1,0.5,1\n2,-1,1\n",
        "# s_m; x_m; y_m; psi_rad\n0; 0; 0; 0\n1; 1; 0.5; 0\n2; 2; -1; 0\n",
        "x_ref_m; y_ref_m; width_m\n0; 0; 1\n1; 0.5; 1\n2; -1; 1\n",
        "time,pose.position.x,pose.position.y\n0,0,0\n1,1,0.5\n2,2,-1\n",
        "x,y,mode\n0,0,a\n0,0,a\n1,0.5,b\n2,-1,c\n2,-1,c\n",
        "# x [m]  y [m]\n0 0\n1 0.5\n2 -1\n",
    ],
)
def test_usual_ways_to_write_points(tmp_path, text):
    file = tmp_path / "way.csv"
    file.write_bytes(b"\xef\xbb\xbf" + text.encode())

    assert read_points(file) == GOOD


@pytest.mark.parametrize(
    "text",
    [
        "- {name: A, x: 0, y: 0}\n- {x: 1, y: 0.5}\n- {x: 2, y: -1}\n",
        "---\npose: {position: {x: 0, y: 0}}\n---\npose: {position: {x: 1, y: 0.5}}\n---\n"
        "pose: {position: {x: 2, y: -1}}\n---\n",
        "header: {frame_id: map}\nposes:\n- pose: {position: {x: 0, y: 0}}\n"
        "- pose: {position: {x: 1, y: 0.5}}\n- pose: {position: {x: 2, y: -1}}\n---\n",
        "goals:\n- pose: {position: {x: 0, y: 0}}\n- position: {x: 1, y: 0.5}\n- {x: 2, y: -1}\n",
        "waypoints:\n- [0, 0, 0.1]\n- [1, 0.5, 0]\n- [2, -1, 0]\n",
        "waypoints:\n  a: [0, 0, 0.1]\n  b: [1, 0.5, 0]\n  c: [2, -1, 0]\n",
        "node:\n  ros__parameters:\n    waypoints: [0, 0, 0.1, 1, 0.5, 0, 2, -1, 0.3]\n",
        '{"type": "FeatureCollection", "features": [{"geometry": {"coordinates": [0, 0]}}, '
        '{"geometry": {"coordinates": [1, 0.5]}}, {"geometry": {"coordinates": [2, -1]}}]}',
        '{"features": [{"geometry": {"coordinates": [[0, 0], [1, 0.5], [2, -1]]}}]}',
    ],
)
def test_usual_ways_of_navigation_stacks(tmp_path, text):
    pytest.importorskip("yaml")
    file = tmp_path / "way.geojson"
    file.write_text(text)

    assert read_points(file) == GOOD


@pytest.mark.parametrize(
    "text, message",
    [
        ("0,0\n", "way.csv holds 1 different point(s), but a path needs at least 2"),
        ("", "way.csv: no column is named x or y. There are no names"),
        ("x,y\n", "way.csv holds 0 different point(s), but a path needs at least 2"),
        ("0,0\n1,nan\n", "way.csv, line 2: nan is not a finite number"),
        ("0,north\n1,1\n", 'way.csv, line 1, column y: "north" is not a number'),
        ("0,0\n1\n", "way.csv, line 2 is cut off"),
        ("0,0,0\n1,1,1\n", "way.csv: no column is named x or y. There are 1, 2, 3."),
        ("x [m),y\n0,0\n1,1\n", "way.csv: no column is named x. There are x [m), y."),
        ("lat,lon\n0,0\n1,1\n", "way.csv: no column is named x or y. There are lat, lon."),
        ("0,0\n1,1e13\n", "reference.points[2][2] = 10000000000000.0 must be at most 1e+12"),
    ],
)
def test_errors_name_row_and_column(tmp_path, text, message):
    (tmp_path / "way.csv").write_text(text)
    (tmp_path / "mine.toml").write_text('[reference]\nkind = "waypoints"\nfile = "way.csv"\n')

    with pytest.raises(ScenarioError) as caught:
        load_scenario(tmp_path / "mine.toml")
    assert str(caught.value).removeprefix("reference.file: ").startswith(message)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "text, message",
    [
        ("poses: 3", "pose 1"),
        ("poses: [{x: 1}]", "pose 1"),
        ("poses: [{x: 1, y: .nan}]", "pose 1: "),
        ("poses: [{x: 1, y: true}]", "pose 1: "),
        ("poses: [{x: 1, y: 2}, {x: 1, y: 2}]", "1 different point"),
        ("", "0 different point"),
    ],
)
def test_errors_name_the_pose(tmp_path, text, message):
    pytest.importorskip("yaml")
    (tmp_path / "way.yaml").write_text(text)

    with pytest.raises(ScenarioError, match=rf"way\.yaml.*{message}"):
        read_points(tmp_path / "way.yaml")


@pytest.mark.parametrize(
    "name, message", [("none.csv", "there is no file"), (".", "is a directory")]
)
def test_files_that_are_not_there(tmp_path, name, message):
    with pytest.raises(ScenarioError, match=rf"^reference\.file: .*{message}"):
        read_points(tmp_path / name)


def bends(count):
    """A planner's path: close points of a bend, each off by half a millimetre."""
    way = np.linspace(0, 6, count)
    jitter = np.random.default_rng(1).uniform(-5e-4, 5e-4, (count, 2))
    return np.column_stack([way, np.sin(way)]) + jitter


def test_a_planners_path_is_thinned_within_the_tolerance(tmp_path):
    points = bends(20_000)
    np.savetxt(tmp_path / "way.csv", points, delimiter=",")
    (tmp_path / "mine.toml").write_text(
        f'{HEAD}[reference]\nkind = "waypoints"\nfile = "way.csv"\ntolerance = 0.05\n'
    )
    path = waypoint_path(load_scenario(tmp_path / "mine.toml").reference)
    places = path.derivatives(0, np.linspace(0, 1, 65)).reshape(-1, 2)
    from_all, _ = cKDTree(points).query(places)
    to_path, _ = cKDTree(places).query(points)

    assert len(path.coefficients) < 100
    assert from_all.max() < 0.05
    assert to_path.max() < 0.05


def test_a_way_back_on_the_same_line_is_not_left_out():
    there = np.linspace([0.0, 0.0], [5.0, 0.0], 300)
    back = np.linspace([5.0, 0.0], [2.0, 0.0], 200)[1:]
    again = np.linspace([2.0, 0.0], [6.0, 0.0], 300)[1:]
    left = simplified(np.vstack([there, back, again]), 0.01, closed=False)

    assert left.tolist() == [[0.0, 0.0], [5.0, 0.0], [2.0, 0.0], [6.0, 0.0]]


@given(st.binary(max_size=100))
def test_random_bytes_are_points_or_an_error(tmp_path_factory, data):
    file = tmp_path_factory.mktemp("csv") / "way.csv"
    file.write_bytes(data)
    try:
        good = len(read_points(file)) >= 2
    except ScenarioError as problem:
        good = re.fullmatch(r"reference\.file: [^\n]+", str(problem)) is not None
    assert good
