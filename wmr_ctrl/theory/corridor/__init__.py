"""The certified corridor: how far from its path a robot can be pushed, with a proof.

Start with `find_corridor`; docs/explanation/corridor.md has the theorem and its limits.
"""

import math

from wmr_ctrl.control.laws.registry import LAWS
from wmr_ctrl.control.setup import settle
from wmr_ctrl.core.fields.arguments import checks_arguments
from wmr_ctrl.results import Run
from wmr_ctrl.results.verdicts import CorridorLeft
from wmr_ctrl.theory.checks.outlook import scenario_of_run
from wmr_ctrl.theory.door import LEFT_OUT, is_open, proofs
from wmr_ctrl.world.model.system import System
from wmr_ctrl.world.registry import EFFECTS
from wmr_ctrl.world.scenario import Scenario

from .answer import Corridor as Corridor
from .clearance import find_clearance

NOT_CHECKED = f"NOT_CHECKED: {LEFT_OUT}"
ASKED = "corridor.asked"
"""Module of wmr_proofs that works them out."""


@checks_arguments
def find_corridor(
    scenario: Scenario, law: str, *, whole: bool = False, work: float = math.inf
) -> Corridor:
    """The Corridor of ``law`` on ``scenario``; raises the errors of `settle`.

    On a circle or a line it is valid for ever, or until the robot changes.  ``whole``: also for the
    scenario's whole run, along any path, with all changes and with the initial state of drives and
    commands of a run.  That takes some seconds; if it needs more than this ``work``
    (`wmr_ctrl.theory.checks.budget`), it is refused as "not checked". Without python-flint (the
    extra ``proofs``) ``refused`` is NOT_CHECKED.
    """
    setup = settle(scenario, law)
    if not is_open():
        clear = find_clearance(setup.scenario, None)
        return Corridor(setup.name, refused=NOT_CHECKED, clearance=clear)
    answer: Corridor = proofs(ASKED).corridor_of(setup, whole, work)
    return answer


def certified_corridor(scenario: Scenario, law: str) -> Corridor:
    """The corridor that is valid for ever; if it is refused, smaller inputs are not tried."""
    answer: Corridor = proofs(ASKED).certified_corridor(settle(scenario, law))
    return answer


def corridor_course(scenario: Scenario, law: str, *, whole: bool = True) -> Corridor | None:
    """The Corridor of the scenario's runs, with its ``course``; None without one.

    The course (2, n) has one column if it is valid ``until`` the robot changes, or for ever.  If no
    such corridor is valid for all of a run that begins on its path, the course has one column per
    sample of that run.  That takes some seconds, and is omitted without ``whole``.
    """
    setup = settle(scenario, law)
    return proofs(ASKED).course_of(setup, whole) if is_open() else None


def corridor_monitor(scenario: Scenario, law: str) -> System:
    """The monitor of a law's corridor for a robot's measurements; to be stepped at every sample.

    Raises ScenarioError if there is no corridor, or none that can be monitored, and
    MissingExtraError without the extra proofs.
    """
    return proofs(ASKED).monitor_of(scenario, law)


def is_covered(run: Run) -> bool:
    """True if the plane model moved the robot, with the torque delays of the scenario."""
    return run.settings.plant_kind == "ode" and run.provenance.get("master") != "jacobi"


def left_corridor(run: Run) -> CorridorLeft | None:
    """First time at which a run leaves the corridor in which it had settled; None if it never does.

    It is for runs that no proof covers: on the rigid body, on another author's plant, under a
    master that delays torques, and with effects of other packages.  None without python-flint.
    """
    scenario = scenario_of_run(run)
    if scenario is None or run.law not in LAWS or LAWS[run.law].inside is None:
        return None
    foreign = any(item.present(scenario) for item in EFFECTS.plugins)
    if not is_open() or (is_covered(run) and not foreign):
        return None
    return proofs(ASKED).left_by(run, scenario)
