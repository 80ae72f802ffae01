"""Inputs that no robot has, into the C package of every law: refused, or a finite torque."""

import itertools
import math

import numpy as np
import pytest

from tests.board.emulated import HostBuild
from tests.codegen.measured import SCENARIOS
from tests.codegen.test_package import needs
from wmr_ctrl.codegen.single_precision import LARGEST_SINGLE
from wmr_ctrl.core.signals import LARGEST
from wmr_ctrl.world.scenario import load_scenario

ANGLES = (2, 9)
"""Places of theta_d and theta, which grow without end."""
GOOD = (0.1, 0.0, -1.5, 0.2, 0.1, 0.0, 0.0, -0.1, -0.2, -0.7, 0.1, 0.05)
REFUSED, TAKEN = 1, 0


@pytest.mark.parametrize(
    "law, float32, guarded", [("pid", False, False), ("smc", True, False), ("nn", True, True)]
)
@pytest.mark.slow_but("pid-False-False", "smc-True-False")
def test_what_is_too_large_is_refused_and_leaves_no_trace(law, float32, guarded, tmp_path):
    """Each bounded input, beyond its bound with either sign or NaN, gives torques of 0; then all is
    as before.
    """
    needs("cc")
    one = HostBuild(law, load_scenario(SCENARIOS[guarded]), tmp_path, float32=float32)
    sizes = (1.7e308, 1.0001 * (LARGEST_SINGLE if float32 else LARGEST), math.inf, math.nan)
    for _ in range(3):
        assert one.step(GOOD)[0] == TAKEN
    kept = one.memory.copy()
    for at, size, sign in itertools.product(range(len(GOOD)), sizes, (-1.0, 1.0)):
        given = np.array(GOOD)
        given[at] = sign * size
        if at in ANGLES and size < float(np.finfo(one.real).max):
            continue
        with np.errstate(over="ignore"):
            status, torque = one.step(given)
        assert (status, *torque) == (REFUSED, 0, 0), (at, given[at])
        assert (one.memory == kept).all()
    status, torque = one.step(GOOD)
    assert status == TAKEN
    assert np.isfinite([*one.memory, *torque]).all()
    assert torque.any()
