"""Requested corridors, each computed once, by one thread at a time."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import lru_cache
from threading import RLock

import numpy as np
from flint import ctx

from wmr_ctrl.control.setup import Setup, settle
from wmr_ctrl.results import Run
from wmr_ctrl.results.verdicts import CorridorLeft
from wmr_ctrl.theory.checks.budget import OverBudgetError, budget
from wmr_ctrl.theory.corridor.answer import Corridor
from wmr_ctrl.theory.corridor.clearance import find_clearance
from wmr_ctrl.world.model.system import System
from wmr_ctrl.world.scenario import Scenario

from . import latch, masses, whole
from .inputs import is_steady

TOO_MUCH = (
    "not checked: over the whole run it takes more work than is allowed here; "
    "wmr_ctrl.corridor(scenario, law, whole=True) has no such limit"
)
BITS = 53
"""Python-flint's precision where a certificate asks for none of its own."""
_ONE = RLock()


@contextmanager
def _alone() -> Iterator[None]:
    """Context for one thread at a time, as python-flint's precision is global and must be set."""
    with _ONE, ctx.workprec(BITS):
        yield


def corridor_of(setup: Setup, whole_run: bool, work: float) -> Corridor:
    """Cached result of `wmr_ctrl.theory.corridor.find_corridor`."""
    with _alone():
        return _found(setup, whole_run, work)


def certified_corridor(setup: Setup) -> Corridor:
    """The corridor that is valid for ever; if it is refused, smaller inputs are not tried."""
    with _alone():
        return masses.certified(setup, closing=False)


def run_corridor(scenario: Scenario, law: str) -> Corridor:
    """The Corridor of the scenario's whole run, with its ``course``; it takes some seconds."""
    with _alone():
        return _of_run(settle(scenario, law))


def course_of(setup: Setup, whole_run: bool) -> Corridor | None:
    """Cached result of `wmr_ctrl.theory.corridor.corridor_course`."""
    with _alone():
        return _course_of(setup, whole_run)


def monitor_of(scenario: Scenario, law: str) -> System:
    """Cached result of `wmr_ctrl.theory.corridor.corridor_monitor`."""
    with _alone():
        return latch.monitor_of(scenario, law)


def left_by(run: Run, scenario: Scenario) -> CorridorLeft | None:
    """Time at which a run first leaves the corridor that it had settled in; None without one."""
    with _alone():
        return latch.left_by(run, scenario)


@lru_cache(maxsize=16)
def _of_run(setup: Setup) -> Corridor:
    return whole.certified_run(setup, closing=False)


@lru_cache(maxsize=16)
def _course_of(setup: Setup, whole_run: bool) -> Corridor | None:
    tube = masses.certified(setup, closing=False)
    begun = tube.position is not None and not tube.late  # no run begins with what is late
    if whole_run and (not begun or tube.until is not None):
        run = _of_run(setup)
        if run.course is not None:
            return run
    if not begun:
        return None
    return replace(tube, course=np.array([[tube.position], [tube.heading]], dtype=float))


def _within(setup: Setup, work: float) -> Corridor:
    """The corridor of the whole run; "not checked" if it takes more work than ``work``."""
    try:
        with budget(work):
            return whole.certified_run(setup)
    except OverBudgetError:
        return Corridor(setup.name, refused=TOO_MUCH, run=setup.scenario.clock.duration)


@lru_cache(maxsize=256)
def _found(setup: Setup, whole_run: bool, work: float) -> Corridor:
    steady = is_steady(setup)
    tube = masses.certified(setup) if steady or not whole_run else _within(setup, work)
    ends = tube.until is not None or bool(tube.late)
    if whole_run and steady and tube.position is not None and ends:
        tube = replace(tube, whole=_within(setup, work))
    of_run = None if tube.whole is None else tube.whole.position
    position = None if tube.late and tube.run is None else tube.position  # no run begins like that
    width = position if of_run is None else of_run
    return replace(tube, clearance=find_clearance(setup.scenario, width))
