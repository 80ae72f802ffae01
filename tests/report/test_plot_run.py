"""The one-page picture of a run."""

from __future__ import annotations

from html import unescape

import pytest

from tests.results.conftest import build
from wmr_ctrl.errors import ArgumentError, ResultFileError
from wmr_ctrl.report import style
from wmr_ctrl.report.plot_run import plot_run
from wmr_ctrl.report.scene import frames, scene_of
from wmr_ctrl.results import Monitor

MAGIC = {".png": b"\x89PNG", ".svg": b"<?xml", ".pdf": b"%PDF"}
STOPPED = Monitor((1000.0, 2.0), 5, (0.02, 1), (0.05, 1), "diverged")


@pytest.mark.parametrize("suffix", MAGIC)
def test_a_run_is_drawn(fake_simulate, tmp_path, suffix):
    path = tmp_path / f"run{suffix}"
    plot_run(fake_simulate("paper-simulation", "nn", 0), path)

    assert path.read_bytes().startswith(MAGIC[suffix])
    assert [p.name for p in tmp_path.iterdir()] == [path.name]


def test_a_run_that_ended_early_is_drawn(tmp_path):
    path = tmp_path / "run.svg"
    plot_run(build(duration=80.0, rows=5, monitor=STOPPED), path)

    assert path.stat().st_size > 1000


@pytest.mark.parametrize("name", [r"a$\frac$b $x_{$ \$", 'a$b\ntwo lines "<&>*/'])
def test_a_name_is_no_formula(tmp_path, monkeypatch, name):
    monkeypatch.setitem(style._COLOURS, "svg.fonttype", "none")
    path, run = tmp_path / "run.svg", build(duration=0.2, labels={"scenario": name})
    plot_run(run, path)
    next(frames(scene_of([run], 1)))

    assert name.replace("\n", " ") in unescape(path.read_text(encoding="utf-8"))


def test_an_empty_run_is_refused(tmp_path):
    with pytest.raises(ArgumentError):
        plot_run(build(rows=0, monitor=STOPPED), tmp_path / "run.png")


@pytest.mark.parametrize("name", ["run.jpg", "run", "missing/run.png"])
def test_places_that_cannot_be_written_are_refused(tmp_path, name):
    with pytest.raises(ResultFileError):
        plot_run(build(), tmp_path / name)
    assert not list(tmp_path.iterdir())
