"""Warnings of a setup by key, without checks that never report that key; a loop's matrix."""

from wmr_ctrl.theory.checks import CHECKS
from wmr_ctrl.theory.checks.sample_time import sample_time
from wmr_ctrl.theory.checks.sending import loop_of

STABILITY = ("clock.control", "model.m")
"""Keys of what `sample_time` tells, which takes longer than all others together."""


def told_of(setup, key=""):
    """Return the warnings about one key, or all warnings."""
    asked = [c for c in CHECKS if key in ("", *STABILITY) or c is not sample_time]
    found = (warning for check in asked for warning in check(loop_of(setup)))
    return [warning for warning in found if key in ("", warning.key)]


def closed(loop, v_d, period, theta=0.0, **known):
    """Matrix of the loop from one sample to the next, on the reference at v_d (2)."""
    return loop.closed(loop.on_reference(v_d, theta), period, **known)
