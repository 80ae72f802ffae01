"""Logs of a plant of the tests' own, simulated once: four robots, 24 s each."""

from contextlib import contextmanager

import numpy as np
import pytest

from benchmarks.own_plant import Truth, log_of, simulate
from wmr_ctrl.codegen import build
from wmr_ctrl.identification import identify

TRUTH = Truth(delay=0.036)
STEP = 4e-3
"""A ninth of its delay, and a quarter of the fastest time constant, that of friction [s]."""
KNOWN = {"robot.r": TRUTH.r, "robot.l": TRUTH.l, "encoder.counts": TRUTH.counts}
POSED = ("t", "wheel_counts[1]", "wheel_counts[2]", "tau_right", "tau_left", "x", "y", "theta")


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
    """In this folder alone: a fixture of the session would last for all tests after it."""
    with filters_at_level_one():
        yield


@pytest.fixture(scope="session")
def driven():
    return simulate(TRUTH, 4, 24.0, seed=0, step=STEP)


@pytest.fixture(scope="session")
def found(driven):
    """What the first robot's log tells."""
    with filters_at_level_one():
        return identify(log_of(driven, 0), overrides=KNOWN)


@pytest.fixture
def posed(driven):
    """Columns of a log with poses, as arrays that may be spoilt."""
    return {key: np.array(value) for key, value in log_of(driven, 0, POSED).items()}
