"""The robot as moving pictures."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from tests.results.conftest import build
from wmr_ctrl.core.errors import ResultFileError
from wmr_ctrl.report import animate
from wmr_ctrl.report.animate import animate_runs
from wmr_ctrl.report.scene import scene_of, with_tubes
from wmr_ctrl.results import Monitor
from wmr_ctrl.world.scenario import load_scenario, override
from wmr_ctrl.world.scenario.toml_io import to_toml
from wmr_proofs.corridor.asked import run_corridor

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
    """Names cannot break it."""
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


@pytest.mark.slow
def test_a_certified_corridor_is_a_band(tmp_path):
    """Past a change of the robot it is that of the whole run."""
    brief = {"changes": [{"t": 0.5, "m": 60.0}], "clock.duration": 2.0}
    scenario = load_scenario("safe-simulation", brief)
    run = build(
        labels={"law": "prox", "guard": True}, duration=1.0, y=0.004, x_d=np.linspace(0, 1, 100),
        x=np.linspace(0, 1, 100), y_d=0.0, provenance={"scenario_toml": to_toml(scenario)},
    )  # fmt: skip
    most = run_corridor(override(scenario, {"guard.enabled": True}), "prox").course[0, :100:2]

    assert most[40] > 1.05 * most[24], "wider after the change"
    animate_runs([run], tmp_path / "run.html")
    page, data = shown_of(tmp_path / "run.html")
    above = [y for _, y in data["bands"][0][:100:2]]
    assert above == pytest.approx(most, abs=1e-4)
    assert "the certified corridor from a start on it, as long as it holds" in page
