"""The peer in numba computes what the NumPy step computes; without numba it says so."""

import sys
from functools import partial
from importlib.util import find_spec

import numpy as np
import pytest

from benchmarks import numba_peer
from benchmarks.numpy_loop import closed_loop
from benchmarks.setup import Case, Setup
from wmr_ctrl.core.errors import MissingExtraError

TOLERANCE = 1e-11
SETUP = Setup()
needs_numba = pytest.mark.skipif(
    find_spec("numba") is None, reason="NOT RUN: numba is not installed (extra `bench`)"
)
numba = numba_peer.loops() if find_spec("numba") else None


@needs_numba
@pytest.mark.parametrize("noise", [0.0, 1.0])
def test_closed_loop_equals_a_plain_python_loop(noise):
    case = Case(duration=3.0, t_change=1.0, noise_std=noise, seed=4)
    state, weights = numba.closed_loop(SETUP, case)

    expected = closed_loop("nn", SETUP, case)[0]

    np.testing.assert_allclose(state, expected, rtol=0, atol=TOLERANCE)
    assert np.any(weights != 0)


def test_without_numba_the_extra_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "numba", None)

    for build in (partial(numba_peer.step, SETUP, 10), partial(numba_peer.loop, SETUP, Case())):
        with pytest.raises(MissingExtraError, match=r"numba, .*wmr_ctrl\[bench\]"):
            build()
