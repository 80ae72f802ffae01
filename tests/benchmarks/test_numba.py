"""The peer in numba computes what the NumPy step computes; without numba it is simply not there."""

from __future__ import annotations

import sys

import numpy as np
import pytest

from benchmarks import numba_peer
from benchmarks.inputs import mixed_rows, tracking_rows
from benchmarks.numpy_loop import closed_loop
from benchmarks.numpy_step import NumpyLaws
from benchmarks.setup import Case, Setup

TOLERANCE = 1e-11
SETUP = Setup()
numba = numba_peer.loops()
needs_numba = pytest.mark.skipif(
    numba is None, reason="NOT RUN: numba is not installed (extra `bench`)"
)


@needs_numba
@pytest.mark.parametrize(
    "rows", [tracking_rows(64), mixed_rows(3000, seed=1)], ids=["tracking", "mixed"]
)
def test_network_step_equals_numpy_with_any_weights(rows: np.ndarray) -> None:
    laws, law, rng = NumpyLaws(SETUP), numba.law_of(SETUP), np.random.default_rng(2)
    for row in rows:
        W = rng.normal(0, 100, (2, 64))
        mine = W.copy()
        expected, W_expected = laws.nn_step(row[:7], row[7:10], row[10:], W)
        actual = numba.nn_step(law, row, mine, np.empty(64))

        np.testing.assert_allclose(actual, expected, rtol=TOLERANCE, atol=TOLERANCE)
        np.testing.assert_allclose(mine, W_expected, rtol=TOLERANCE, atol=TOLERANCE)


@needs_numba
@pytest.mark.parametrize("noise", [0.0, 1.0])
def test_closed_loop_equals_a_plain_python_loop(noise: float) -> None:
    case = Case(duration=3.0, t_change=1.0, noise_std=noise, seed=4)
    state, weights = numba.closed_loop(SETUP, case)

    expected = closed_loop("nn", SETUP, case)[0]

    np.testing.assert_allclose(state, expected, rtol=0, atol=TOLERANCE)
    assert np.any(weights != 0)


@needs_numba
def test_candidates_are_there_and_run() -> None:
    case = Case(duration=0.1)
    found = numba_peer.step_candidates(SETUP, 10) | numba_peer.loop_candidates(SETUP, case)

    assert {name: item.steps for name, item in found.items()} == {
        "nn_numba": 10, "nn_loop_numba": 10
    }  # fmt: skip
    for item in found.values():
        item.run()


def test_without_numba_there_are_no_candidates(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("benchmarks.numba_loop", "benchmarks.numba_step"):
        monkeypatch.delitem(sys.modules, name, raising=False)
    monkeypatch.setitem(sys.modules, "numba", None)

    assert numba_peer.step_candidates(SETUP, 10) == {}
    assert numba_peer.loop_candidates(SETUP, Case()) == {}
