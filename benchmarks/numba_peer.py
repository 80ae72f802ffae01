"""numba as a peer, where it is installed: the network law's step and its closed loop.

`pip install wmr_ctrl[bench]` brings numba.  It is imported when candidates are asked for and not
before; without it, or with one that does not go with this NumPy, there are none.
"""

from __future__ import annotations

from functools import partial
from importlib import import_module
from typing import Any

import numpy as np

from .inputs import tracking_rows
from .setup import Case, Setup
from .timing import Candidate


def loops() -> Any:
    """The module `numba_loop`, None where numba cannot be imported."""
    try:
        return import_module(".numba_loop", __package__)
    except ImportError:
        return None


def step_candidates(setup: Setup, steps: int) -> dict[str, Candidate]:
    """``nn_numba``: steps in a loop inside numba, over the ring of tracking inputs."""
    numba, rows, scratch = loops(), tracking_rows(), np.empty(64)
    if numba is None:
        return {}
    law, W = numba.law_of(setup), np.zeros((2, 64))
    return {"nn_numba": Candidate(partial(numba.repeat, law, steps, rows, W, scratch), steps)}


def loop_candidates(setup: Setup, case: Case) -> dict[str, Candidate]:
    """``nn_loop_numba``: whole runs, noise drawn by NumPy at once; a step is one control sample."""
    numba = loops()
    if numba is None:
        return {}
    return {"nn_loop_numba": Candidate(partial(numba.closed_loop, setup, case), case.samples)}
