"""numba as a peer, where it is installed: the network law's step and its closed loop.

`pip install 'wmr_ctrl[bench]'` brings numba.  It is imported when a candidate is asked for.
"""

from __future__ import annotations

from functools import partial
from importlib import import_module
from typing import Any

import numpy as np

from wmr_ctrl.core.errors import library

from .inputs import tracking_rows
from .setup import Case, Setup
from .timing import Candidate


def loops() -> Any:
    """The module `numba_loop`; raises MissingExtraError where numba cannot be imported."""
    library("numba", "bench")
    return import_module(".numba_loop", __package__)


def step(setup: Setup, steps: int) -> Candidate:
    """Steps in a loop inside numba, over the ring of tracking inputs."""
    numba, rows, scratch = loops(), tracking_rows(), np.empty(64)
    law, W = numba.law_of(setup), np.zeros((2, 64))
    return Candidate(partial(numba.repeat, law, steps, rows, W, scratch), steps)


def loop(setup: Setup, case: Case) -> Candidate:
    """Whole runs, noise drawn by NumPy at once; a step is one control sample."""
    return Candidate(partial(loops().closed_loop, setup, case), case.samples)
