"""The floor's barrier against its definition (10)-(20) at 50 digits."""

from itertools import product

import mpmath as mp
import numpy as np
import pytest

from benchmarks.hand_c import HandC
from benchmarks.native import floor_toolchain
from benchmarks.setup import Setup
from tests.control.barrier.test_stable import close, exact, points
from wmr_ctrl.core.errors import CompilerError

try:
    floor_toolchain()
except CompilerError as missing:
    pytest.skip(str(missing), allow_module_level=True)


@pytest.fixture(scope="module")
def hand():
    return HandC()


@pytest.mark.parametrize("axis", [0, 1])
def test_barrier_is_exact_in_every_region(hand, axis):
    """w, V1/A and q, and their limits where the velocity is its target."""
    u1, u2 = Setup().v_u1[axis], Setup().v_u2[axis]
    with mp.workdps(50):
        for c, v in points(u1, u2, 1500, 1e-3):
            quotient, q, target, _ = exact(c, v, u1, u2)
            found = hand.barrier(axis, v, c)
            assert all(map(close, found.tolist(), (v - target, quotient, q))), (c, v, found)


def test_barrier_is_never_nan_for_v_c0_up_to_1e150(hand):
    speeds = [0.0, -0.0, 5e-324, 0.8, 1.3, 1.0, 1.5, 1e308, float("inf")]
    sizes = [0.0, -0.0, 5e-324, 0.8, 1.3, 5.8, 6.3, 1e3, 1e6, 1e100, 1e150]
    for axis, v, c, s, z in product((0, 1), speeds, sizes, (1, -1), (1, -1)):
        assert np.isfinite(hand.barrier(axis, s * v, z * c)).all(), (axis, v, c)
