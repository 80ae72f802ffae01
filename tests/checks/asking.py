"""Warnings of a setup by their key, without the checks that never tell it; a loop's matrix."""

from __future__ import annotations

import numpy as np

from wmr_ctrl.control.setup import Setup
from wmr_ctrl.results.verdicts import Warning
from wmr_ctrl.theory.checks import CHECKS
from wmr_ctrl.theory.checks.loop import Loop
from wmr_ctrl.theory.checks.sample_time import sample_time
from wmr_ctrl.theory.checks.sending import loop_of

STABILITY = ("clock.control", "model.m")
"""Keys of what `sample_time` tells, which takes longer than all others together."""


def told_of(setup: Setup, key: str = "") -> list[Warning]:
    """Those of one key, or all of them."""
    asked = [c for c in CHECKS if key in ("", *STABILITY) or c is not sample_time]
    found = (warning for check in asked for warning in check(loop_of(setup)))
    return [warning for warning in found if key in ("", warning.key)]


def closed(loop: Loop, v_d: np.ndarray, period: float, theta: float = 0.0, **known) -> np.ndarray:
    """Matrix of the loop from one sample to the next, on the reference at v_d (2)."""
    return loop.closed(loop.on_reference(v_d, theta), period, **known)
