"""`wmr-ctrl compare`: 0 for equal or agreeing runs, 1 for others."""

from __future__ import annotations

import json

import pytest


@pytest.fixture
def saved(short_run, tmp_path):
    def save(name, *args):
        path = tmp_path / name
        assert short_run("paper-simulation", *args, "--out", path).exit_code == 0
        return path

    return save


def test_equal_runs_in_different_formats(wmr, saved):
    found = wmr("compare", saved("a.npz"), saved("a.csv"))

    assert found.exit_code == 0
    assert "EQUAL" in found.stdout


def test_differing_runs(wmr, saved):
    found = wmr("compare", saved("a.npz"), saved("b.npz", "--seed", 1))

    assert found.exit_code == 1
    assert "DIFFER" in found.stdout
    assert found.stderr == ""


def test_tolerance_decides(wmr, saved):
    found = wmr("compare", saved("a.npz"), saved("b.npz", "--seed", 1), "--tolerance", 10)

    assert found.exit_code == 0
    assert "AGREE" in found.stdout


def test_json(wmr, saved):
    found = wmr("compare", saved("a.npz"), saved("b.npz", "--seed", 1), "--json")
    document = json.loads(found.stdout)

    assert found.exit_code == 1
    assert document["verdict"] == "differ"
    assert document["rows"] == 20
    assert {"name": "seed", "in_a": "0", "in_b": "1"} in document["facts"]


@pytest.mark.parametrize("tolerance", ["-1", "nan"])
def test_tolerance_must_make_sense(wmr, saved, tolerance):
    path = saved("a.npz")
    found = wmr("compare", path, path, "--tolerance", tolerance)

    assert found.exit_code == 2
    assert "tolerance" in found.stderr
