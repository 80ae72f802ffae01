"""All checks in the order in which they are told: what ends a run first comes first."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import lru_cache

from wmr_ctrl.checks.barrier import pushed_through
from wmr_ctrl.checks.guard_price import guard_price
from wmr_ctrl.checks.loop import Loop
from wmr_ctrl.checks.mismatch import wrong_model
from wmr_ctrl.checks.network import network
from wmr_ctrl.checks.not_covered import drives, noise
from wmr_ctrl.checks.preconditions import preconditions
from wmr_ctrl.checks.sample_time import sample_time
from wmr_ctrl.checks.start import start
from wmr_ctrl.checks.warning import Warning
from wmr_ctrl.control.setup import Setup

CHECKS: tuple[Callable[[Loop], Iterator[Warning]], ...] = (
    start,
    sample_time,
    preconditions,
    pushed_through,
    wrong_model,
    network,
    drives,
    noise,
    guard_price,
)


@lru_cache(maxsize=256)
def warnings_for(setup: Setup) -> tuple[Warning, ...]:
    """What theory says against a law on a scenario; empty where it has no objection."""
    loop = Loop(setup)
    return tuple(warning for check in CHECKS for warning in check(loop))
