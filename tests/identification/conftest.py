"""Logs of a plant of the tests' own, simulated once: four robots, 24 s each; and of a base."""

from contextlib import contextmanager

import numpy as np
import pytest

from benchmarks.own_axes import Axis, Drive, recorded
from benchmarks.own_axes import Truth as Base
from benchmarks.own_plant import Truth, log_of, simulate
from wmr_ctrl.codegen import build
from wmr_ctrl.identification import identify

TRUTH = Truth(delay=0.036)
STEP = 4e-3
"""A ninth of its delay, and a quarter of the fastest time constant, that of friction [s]."""
KNOWN = {"robot.r": TRUTH.r, "robot.l": TRUTH.l, "encoder.counts": TRUTH.counts}
BASE = Base((Axis(gain=0.95, first=0.25), Axis(gain=1.05, first=0.15)), (0.03, 0.03))
"""A base that takes velocities, with a loop of first order on each axis."""
NUMBERS = {"gain1": 0.95, "tau1": 0.25, "delay1": 0.03, "gain2": 1.05, "tau2": 0.15, "delay2": 0.03}
POSED = ("t", "wheel_counts[1]", "wheel_counts[2]", "tau_right", "tau_left", "x", "y", "theta")


def drive(base=BASE, seed=1, **how):
    """Return the log of a base that takes velocities; the default is 12 s of random steps."""
    return recorded(base, Drive(**{"seconds": 12.0, **how}), seed)


@contextmanager
def filters_at_level_one():
    """A fit runs its compiled filter hundreds of times: at -O1 that takes a fifth of -O0."""
    find = build.find_toolchain

    def at_level_one(**options):
        with pytest.MonkeyPatch.context() as patch:
            patch.setenv("WMR_CTRL_OPTIMIZE", "1")
            return find(**options)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(build, "find_toolchain", at_level_one)
        yield


@pytest.fixture(scope="module", autouse=True)
def level_one():
    """Keep filters at level one in this folder only.

    A fixture of the session would last for all tests after it.
    """
    with filters_at_level_one():
        yield


@pytest.fixture(scope="session")
def driven():
    return simulate(TRUTH, 4, 24.0, seed=0, step=STEP)


@pytest.fixture(scope="session")
def found(driven):
    """Identification result of the first robot's log."""
    with filters_at_level_one():
        return identify(log_of(driven, 0), overrides=KNOWN)


@pytest.fixture(scope="session")
def based():
    """Identification result of a base's log, without any number from the user."""
    return identify(drive(), base="velocity")


@pytest.fixture
def posed(driven):
    """Columns of a log with poses, as arrays that may be spoilt, by names without units."""
    return {key.split(" ")[0]: np.array(row) for key, row in log_of(driven, 0, POSED).items()}
