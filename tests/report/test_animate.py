"""Animations of the robot."""

import json
import re
from dataclasses import replace

import pytest
from PIL import Image

from wmr_ctrl.core.errors import ResultFileError
from wmr_ctrl.report import animate
from wmr_ctrl.report.animate import animate_runs
from wmr_ctrl.report.scene import scene_of, with_tubes
from wmr_ctrl.results import Monitor

STOPPED = Monitor((1000.0, 2.0), 5, (0.02, 1), (0.05, 1), "diverged")


@pytest.fixture(scope="module")
def run(fake_simulate):
    return fake_simulate("paper-simulation", "pid", 0)


def test_a_scene_keeps_the_first_and_the_last_sample(run):
    scene = scene_of([run], 100)

    assert not with_tubes(scene, [run]).tubes
    assert len(scene.t) <= 101
    assert (scene.t[0], scene.t[-1]) == (run.time[0], run.time[-1])
    (robot,) = scene.actors
    assert robot.pose.shape == scene.target.shape == (len(scene.t), 3)
    left, right, low, high = scene.view
    assert right - left == pytest.approx(high - low)
    assert left < robot.pose[:, 0].min()
    assert high > robot.pose[:, 1].max()


def test_a_page_holds_all_that_it_shows(run, tmp_path):
    """Names of any characters cannot break it."""
    name = "</title><script>alert(1)</script>"
    animate_runs([replace(run, scenario=name)], tmp_path / "run.html")
    page, data = shown_of(tmp_path / "run.html")

    assert not re.search(r"(src|href)=|url\(|@import|https?:|<script>alert", page)
    assert len(data["rows"]) == len(data["robots"][0]) == 800
    assert (len(data["rows"][0]), len(data["robots"][0][0])) == (4, 5)
    assert data["scales"] == [1.0, 1.5]


def test_a_gif_has_all_frames_and_tells_progress(run, tmp_path, monkeypatch):
    monkeypatch.setattr("wmr_ctrl.report.animate._FRAMES", {".gif": 12})
    shares = []
    animate_runs([run], tmp_path / "run.gif", shares.append)
    with Image.open(tmp_path / "run.gif") as picture:
        assert picture.n_frames >= 12
        assert picture.info["duration"] == animate.GIF_MILLISECONDS
    assert shares == sorted(shares)
    assert shares[-1] == 1.0


@pytest.mark.parametrize("name", ["run.avi", "run", "missing/run.gif"])
def test_places_that_cannot_be_written_are_refused(run, tmp_path, name):
    with pytest.raises(ResultFileError):
        animate_runs([run], tmp_path / name)
    assert not list(tmp_path.iterdir())


def shown_of(path):
    page = path.read_text("utf-8")
    return page, json.loads(
        re.search(r"const data = (\{.*\});", page)[1], parse_constant=pytest.fail
    )
