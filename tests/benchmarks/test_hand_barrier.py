"""The floor's barrier against its definition (10)-(20) at 50 digits."""

import mpmath as mp
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
