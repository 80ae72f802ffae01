"""The certified corridor: how far from its path a robot can be pushed, with a proof.

Start with `find_corridor`; docs/explanation/corridor.md has the theorem and its limits.
"""

import math
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from functools import lru_cache
from threading import RLock

import numpy as np

from wmr_ctrl.control.laws.registry import LAWS
from wmr_ctrl.control.setup import Setup, settle
from wmr_ctrl.core.fields.arguments import checks_arguments
from wmr_ctrl.results import Run
from wmr_ctrl.results.verdicts import CorridorLeft as CorridorLeft
from wmr_ctrl.theory.checks.budget import OverBudgetError, budget
from wmr_ctrl.theory.checks.outlook import scenario_of_run
from wmr_ctrl.theory.door import LEFT_OUT, is_open, proofs
from wmr_ctrl.world.model.system import System
from wmr_ctrl.world.registry import EFFECTS
from wmr_ctrl.world.scenario import Scenario

from .answer import Corridor as Corridor
from .clearance import Clearance as Clearance
from .clearance import find_clearance

NOT_CHECKED = f"NOT_CHECKED: {LEFT_OUT}"
TOO_MUCH = (
    "not checked: over the whole run it takes more work than is allowed here; "
    "wmr_ctrl.corridor(scenario, law, whole=True) has no such limit"
)
BITS = 53
"""Python-flint's precision where a certificate asks for none of its own."""
_ONE = RLock()


@contextmanager
def _alone() -> Iterator[None]:
    """For one thread: python-flint has one precision for all, which others may have left as any."""
    with _ONE, ExitStack() as stack:
        if is_open():
            from flint import ctx

            stack.enter_context(ctx.workprec(BITS))
        yield


@checks_arguments
def find_corridor(
    scenario: Scenario, law: str, *, whole: bool = False, work: float = math.inf
) -> Corridor:
    """The Corridor of ``law`` on ``scenario``; raises what `settle` raises.

    On a circle or a line it holds for good, or until the robot changes.  ``whole``: also of the
    scenario's whole run, along any path, with all changes and with drives and commands as a run
    finds them, which takes some seconds; where that takes more than this ``work``
    (`wmr_ctrl.theory.checks.budget`), it is refused as "not checked".  Without python-flint (the
    extra ``proofs``) its ``refused`` is NOT_CHECKED.
    """
    with _alone():
        return _of(settle(scenario, law), whole, work)


def certified_corridor(scenario: Scenario, law: str) -> Corridor:
    """The corridor for good, without a search for smaller inputs that would have one."""
    certified = proofs("corridor.masses").certified

    with _alone():
        return certified(settle(scenario, law), closing=False)


def run_corridor(scenario: Scenario, law: str) -> Corridor:
    """The Corridor of the scenario's whole run, with its ``course``; where there is none, at once.

    That takes some seconds.
    """
    setup = settle(scenario, law)
    if not is_open():
        return Corridor(law, refused=NOT_CHECKED)
    with _alone():
        return _of_run(setup)


def corridor_course(scenario: Scenario, law: str, *, whole: bool = True) -> Corridor | None:
    """The Corridor that runs of the scenario are in, with its ``course``; None without one.

    The course (2, n) has one column that holds ``until`` the robot changes, or for good; or, where
    one corridor does not hold for all of a run that begins on its path, one a sample of that run,
    which takes some seconds, and is left out without ``whole``.
    """
    setup = settle(scenario, law)
    with _alone():
        return None if not is_open() else _course_of(setup, whole)


def corridor_monitor(scenario: Scenario, law: str) -> System:
    """The monitor of a law's corridor, for what a robot measures; to be stepped at every sample.

    Raises ScenarioError where there is no corridor, or none that can be watched,
    MissingExtraError without the extra proofs.
    """
    monitor_of = proofs("corridor.latch").monitor_of

    with _alone():
        return monitor_of(scenario, law)


def is_covered(run: Run) -> bool:
    """True if the plane model moved the robot, with torques as late as the scenario says."""
    return run.settings.plant_kind == "ode" and run.provenance.get("master") != "jacobi"


def left_corridor(run: Run) -> CorridorLeft | None:
    """The first leaving of the corridor by a run that was settled in it, None without one.

    Asked of runs on the rigid body, on somebody else's plant, under a master that delays torques,
    and with effects of other packages: nothing proves those; None without python-flint.
    """
    scenario = scenario_of_run(run)
    if scenario is None or run.law not in LAWS or LAWS[run.law].inside is None:
        return None
    foreign = any(item.present(scenario) for item in EFFECTS.plugins)
    if not is_open() or (is_covered(run) and not foreign):
        return None
    left_by = proofs("corridor.latch").left_by

    with _alone():
        return left_by(run, scenario)


@lru_cache(maxsize=16)
def _of_run(setup: Setup) -> Corridor:
    certified_run = proofs("corridor.whole").certified_run

    return certified_run(setup, closing=False)


@lru_cache(maxsize=16)
def _course_of(setup: Setup, whole: bool) -> Corridor | None:
    certified = proofs("corridor.masses").certified

    tube = certified(setup, closing=False)
    begun = tube.position is not None and not tube.late  # no run begins with what is late
    if whole and (not begun or tube.until is not None):
        run = _of_run(setup)
        if run.course is not None:
            return run
    if not begun:
        return None
    return replace(tube, course=np.array([[tube.position], [tube.heading]], dtype=float))


def _within(setup: Setup, work: float) -> Corridor:
    """The corridor of the whole run; "not checked" where that takes more than this work."""
    certified_run = proofs("corridor.whole").certified_run

    try:
        with budget(work):
            return certified_run(setup)
    except OverBudgetError:
        return Corridor(setup.name, refused=TOO_MUCH, run=setup.scenario.clock.duration)


@lru_cache(maxsize=256)
def _of(setup: Setup, whole: bool, work: float) -> Corridor:
    tube = Corridor(setup.name, refused=NOT_CHECKED)
    if is_open():
        is_steady = proofs("corridor.inputs").is_steady
        certified = proofs("corridor.masses").certified

        steady = is_steady(setup)
        tube = certified(setup) if steady or not whole else _within(setup, work)
        ends = tube.until is not None or bool(tube.late)
        if whole and steady and tube.position is not None and ends:
            tube = replace(tube, whole=_within(setup, work))
    of_run = None if tube.whole is None else tube.whole.position
    position = None if tube.late and tube.run is None else tube.position  # no run begins like that
    width = position if of_run is None else of_run
    return replace(tube, clearance=find_clearance(setup.scenario, width))
