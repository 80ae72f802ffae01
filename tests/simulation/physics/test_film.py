"""A run on the rigid body in three dimensions: what is painted is what happened."""

from __future__ import annotations

import shutil
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from tests.simulation.physics.test_run import SHORT
from wmr_ctrl import simulate
from wmr_ctrl.core.errors import ArgumentError, MissingExtraError, ResultFileError
from wmr_ctrl.export.outputs import film_run
from wmr_ctrl.simulation.engines import runnable
from wmr_ctrl.simulation.physics.film import HEIGHT, WIDTH, check_painter, moments_of, pictures
from wmr_ctrl.world.scenario import load_scenario

BRIEF = SHORT | {"clock.duration": 0.1}


def has_painter() -> bool:
    """Whether OpenGL is there."""
    try:
        check_painter()
    except MissingExtraError:
        return False
    return True


def brief_run(duration=0.1):
    """A run and the loop that it was made by."""
    brief = BRIEF | {"clock.duration": duration}
    run = simulate("paper-simulation", "mb", plant="mujoco", overrides=brief)
    return runnable(load_scenario("paper-simulation", brief), "mb", "mujoco"), run


def test_moments_are_those_of_the_log():
    loop, run = brief_run()
    moments = moments_of(loop, run, 3)
    assert moments.rows.tolist() == [0, 4, 8, 9]
    assert np.array_equal(moments.positions[:, 0], run["x"][moments.rows])
    assert np.array_equal(moments.target[:, 1], run["y_d"][moments.rows])


def test_a_run_from_elsewhere_is_refused():
    loop, run = brief_run()
    moved = {**run.columns, "x": run["x"] + 1e-15}
    with pytest.raises(ArgumentError, match="the run differs"):
        moments_of(loop, replace(run, columns=moved), 3)


@pytest.mark.slow
def test_the_film_shows_the_robot_and_its_figures(tmp_path):
    """Where neither EGL nor OSMesa is, there is none."""
    if not has_painter():
        pytest.skip("no OpenGL here")
    loop, run = brief_run(0.02)
    painted = list(pictures(moments_of(loop, run, 2)))
    assert [picture.shape for picture in painted] == [(HEIGHT, WIDTH, 3)] * 2
    blue = painted[0][HEIGHT // 2 - 60 : HEIGHT // 2 + 60, WIDTH // 2 - 60 : WIDTH // 2 + 60]
    assert (blue[..., 2] > blue[..., 0].astype(int) + 40).mean() > 0.1, "the chassis in the middle"
    run.film(tmp_path / "run.gif")
    with Image.open(tmp_path / "run.gif") as film:
        assert film.n_frames == run.rows
        assert film.size == (WIDTH, HEIGHT + 60)
    if shutil.which("ffmpeg"):
        run.film(tmp_path / "run.mp4")
        assert (tmp_path / "run.mp4").stat().st_size > 1000


@pytest.mark.slow
def test_the_film_shows_the_certified_corridor(tmp_path):
    if not has_painter():
        pytest.skip("no OpenGL here")
    near = {"clock.duration": 0.08, "initial.pose": [0.0, 0.0, -1.57], "changes": []}
    run = simulate("safe-simulation", "prox", plant="mujoco", overrides=near)
    loop = runnable(load_scenario("safe-simulation", near), "prox", "mujoco")
    moments = moments_of(loop, run, 8)
    bare, wide = (
        list(pictures(replace(moments, tube=tube)))[-1].astype(int)
        for tube in (None, np.full(len(moments.rows), 0.5))
    )
    reddened = (wide[..., 0] - wide[..., 2]) - (bare[..., 0] - bare[..., 2])
    assert (reddened > 20).sum() > 100
    run.film(tmp_path / "run.gif")
    with Image.open(tmp_path / "run.gif") as film:
        assert film.size == (WIDTH, HEIGHT + 60 + 24), "a line on the corridor"


@pytest.mark.slow
def test_what_cannot_be_filmed_is_said(tmp_path, monkeypatch):
    run = simulate("paper-simulation", "mb", overrides={"clock.duration": 0.1})
    with pytest.raises(ArgumentError, match="plant mujoco"):
        film_run(run, tmp_path / "run.gif")
    with pytest.raises(ResultFileError, match=r"\.mp4 or \.gif"):
        film_run(run, tmp_path / "run.html")
    monkeypatch.setenv("MUJOCO_GL", "nothing")
    with pytest.raises(MissingExtraError, match="libosmesa6"):
        check_painter()
    assert not any(tmp_path.iterdir())
