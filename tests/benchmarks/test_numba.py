"""The peer in numba computes what the NumPy step computes; without numba it says so."""

import sys
from functools import partial
from importlib.util import find_spec

import numpy as np
import pytest

from benchmarks import numba_peer
from benchmarks.inputs import mixed_rows, tracking_rows
from benchmarks.numpy_loop import closed_loop
from benchmarks.numpy_step import NumpyLaws
from benchmarks.setup import Case, Setup
from wmr_ctrl.core.errors import MissingExtraError

TOLERANCE = 1e-11
SETUP = Setup()
needs_numba = pytest.mark.skipif(
    find_spec("numba") is None, reason="NOT RUN: numba is not installed (extra `bench`)"
)
numba = numba_peer.loops() if find_spec("numba") else None


@needs_numba
@pytest.mark.parametrize(
    "rows", [tracking_rows(64), mixed_rows(3000, seed=1)], ids=["tracking", "mixed"]
)
def test_network_step_equals_numpy_with_any_weights(rows):
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
def test_closed_loop_equals_a_plain_python_loop(noise):
    case = Case(duration=3.0, t_change=1.0, noise_std=noise, seed=4)
    state, weights = numba.closed_loop(SETUP, case)

    expected = closed_loop("nn", SETUP, case)[0]

    np.testing.assert_allclose(state, expected, rtol=0, atol=TOLERANCE)
    assert np.any(weights != 0)


@needs_numba
def test_candidates_are_there_and_run():
    case = Case(duration=0.1)
    for item in (numba_peer.step(SETUP, 10), numba_peer.loop(SETUP, case)):
        assert item.steps == 10
        item.run()


def test_without_numba_the_extra_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "numba", None)

    for build in (partial(numba_peer.step, SETUP, 10), partial(numba_peer.loop, SETUP, Case())):
        with pytest.raises(MissingExtraError, match=r"numba, .*wmr_ctrl\[bench\]"):
            build()
