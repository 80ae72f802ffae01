"""Checks before a run: sample time, preconditions, start, network, barrier, bounds.

`warnings_for` checks one law on one scenario; nothing here simulates more than one control period,
and nothing is ever refused.  A law gets only findings about its own parts: Eq. (7), a theorem, a
barrier or a believed model, if its `Traits` state them.
"""

from collections.abc import Callable, Iterator
from functools import lru_cache

from wmr_ctrl.control.given import judges_gains
from wmr_ctrl.control.setup import Setup
from wmr_ctrl.results.verdicts import Warning as Warning

from .base import beyond_base
from .budget import OF_RUN, budget
from .loop import Loop
from .network import network
from .preconditions import (
    coarse_step,
    late_drives,
    noise,
    preconditions,
    start,
    units,
)
from .sample_time import sample_time
from .sending import loop_of
from .stable_ranges import Stability as Stability
from .stable_ranges import stability as stability
from .torques import first_torques as first_torques
from .torques import grip_warnings as grip_warnings
from .torques import noise_gain, weak_drives
from .torques import reference_torque as reference_torque
from .velocity_base import filter_advice as filter_advice
from .velocity_base import filter_facts as filter_facts
from .velocity_base import velocity_base
from .velocity_guard import contradicted, guard_price, violent_alpha
from .wrong_model import pushed_through, unmodelled, wrong_model

CHECKS: tuple[Callable[[Loop], Iterator[Warning]], ...] = (
    units,
    start,
    sample_time,
    preconditions,
    pushed_through,
    wrong_model,
    unmodelled,
    network,
    weak_drives,
    late_drives,
    noise,
    noise_gain,
    guard_price,
    contradicted,
    coarse_step,
    violent_alpha,
)
"""Checks in the order in which they are printed: first what ends a run first."""
OF_VELOCITY_BASES = (
    units, start, sample_time, preconditions, beyond_base, coarse_step, velocity_base,
)  # fmt: skip
"""Checks that apply to a base that takes velocities."""


@lru_cache(maxsize=256)
def warnings_for(setup: Setup, work: float = OF_RUN) -> tuple[Warning, ...]:
    """Warnings from theory for a law on a scenario; empty if there is no objection.

    A check that needs more than this ``work`` (`wmr_ctrl.theory.checks.budget`) becomes a warning
    "not-checked".
    """
    loop = loop_of(setup)
    checks = OF_VELOCITY_BASES if setup.takes_velocity else CHECKS
    with budget(work):
        return tuple(warning for check in checks for warning in check(loop))


def warnings_heard(setup: Setup, asked: bool, work: float = OF_RUN) -> tuple[Warning, ...]:
    """`warnings_for`, without warnings about gains that nobody chose (`judges_gains`).

    ``asked``: whether the caller named this law.
    """
    warnings = warnings_for(setup, work)
    if judges_gains(setup.scenario, setup.name, asked):
        return warnings
    return tuple(item for item in warnings if not item.key.startswith("gains."))
