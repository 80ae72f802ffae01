"""Runs as bags: the topics that a base would publish."""

import math
import sys

import numpy as np
import pytest
from click.testing import CliRunner

from tests.results.conftest import build
from wmr_ctrl.cli import root
from wmr_ctrl.core.errors import MissingExtraError
from wmr_ctrl.results.bag import run_as_mcap
from wmr_ctrl.results.bag_topics import read_topics


def test_a_run_is_what_a_base_would_publish(tmp_path):
    """Columns that went out as topics come back: poses and speeds, counts, torques, commands."""
    rng = np.random.default_rng(1)
    t = np.arange(100) * 0.01
    run = build(
        x=0.3 * t, y=-0.1 * t, theta=4 * t - 3, v1=rng.normal(size=100), omega=rng.normal(size=100),
        tau_right=rng.normal(size=100), tau_left=rng.normal(size=100),
    )  # fmt: skip
    (tmp_path / "run.mcap").write_bytes(run_as_mcap(run))

    told = read_topics(tmp_path / "run.mcap")

    for name in ("x", "y", "v1", "omega"):
        assert np.array_equal(told.columns[f"{name}_measured"], run[name])
    turned = (told.columns["theta_measured"] - run["theta"]) / math.tau
    assert turned == pytest.approx(np.full(100, round(turned[0])), abs=1e-12)
    assert np.array_equal(told.columns["tau_left"], run["tau_left"])
    assert told.times["tau_left"] == pytest.approx(t, abs=1e-9)
    assert "recorded 0 ms after its stamps" in " ".join(told.remarks)


def test_without_rosbags_the_extra_is_named(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "rosbags.rosbag2", None)

    with pytest.raises(MissingExtraError, match=r"wmr_ctrl\[logs\]"):
        build().save(tmp_path / "run.mcap")
    assert list(tmp_path.iterdir()) == []
    done = CliRunner().invoke(root, f"run --out {tmp_path}/run.mcap")
    assert done.exit_code == 2
    assert "wmr_ctrl[logs]" in done.stderr
