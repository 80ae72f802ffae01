"""Knowledge about a run in advance: objections, and the torque that its motion needs.

A run's verdict uses it besides the log: a run is not good if `wmr-ctrl check` would object, and
torques are large or restless only relative to what the motion needs.  It is computed once for each
scenario, law and plant, when a run's remarks are first read; making runs costs nothing.
"""

from collections.abc import Sequence
from dataclasses import replace
from enum import StrEnum
from functools import lru_cache

import numpy as np

from wmr_ctrl.control.given import default_law
from wmr_ctrl.control.laws.law import Law
from wmr_ctrl.control.laws.registry import LAWS
from wmr_ctrl.control.setup import settle
from wmr_ctrl.core.errors import WmrError
from wmr_ctrl.results import NOT_CHECKED, OBJECTED, Floats, Run
from wmr_ctrl.results.verdicts import Outlook, Warning
from wmr_ctrl.world.encoder import Encoder
from wmr_ctrl.world.phases import needed_torque
from wmr_ctrl.world.pose_delay import PoseDelay
from wmr_ctrl.world.pose_sensor import PoseSensor
from wmr_ctrl.world.scenario import Scenario, loads_scenario, unknown_keys

from . import grip_warnings, warnings_heard
from .base import causes
from .torques import GRIP

TEXT = "scenario_toml"
"""Provenance key of a run's scenario."""
IN_PART = ("assumption-void", "exact-pose")
"""Remarks that narrow what a run shows but report no fault."""
OF_THEORY = (OBJECTED, NOT_CHECKED)
"""Remarks that repeat what theory says without a run."""


def outlook(scenario: Scenario, law: str, plant: str = "ode") -> Outlook:
    """The Outlook of a law on a scenario and a plant; raises the errors of `settle`.

    A law other than the scenario's `default_law` counts as named by the user.
    """
    setup = settle(scenario, law)
    grip = grip_warnings(setup) if plant == "mujoco" else ()
    begins = scenario.limits.v_u2 if LAWS[law].traits.barrier else None
    asked = law != default_law(scenario).name
    warned = (*warnings_heard(setup, asked), *grip)
    exact, assumed = _has_exact_pose(scenario), scenario.assumed
    return Outlook(setup.tau_max, warned, exact, barrier=begins, assumed=assumed)


def _has_exact_pose(scenario: Scenario) -> bool:
    """True if the pose is perfect while velocities come from encoders."""
    counts = scenario.section(Encoder).counts
    late = scenario.section(PoseDelay).pose_delay > 0
    return counts is not None and scenario.section(PoseSensor).perfect and not late


def outlook_of(run: Run) -> Outlook | None:
    """The Outlook of a run; None if its scenario or law is not known here.

    For an unknown law, such as another author's controller, theory says nothing.
    """
    scenario = scenario_of_run(run)
    if scenario is None:
        return None
    if run.law not in LAWS:
        return Outlook(scenario.actuator.tau_max, (), _has_exact_pose(scenario), known=False)
    known = _outlook(scenario, LAWS[run.law], run.settings.plant_kind)
    return replace(known, causes=causes(scenario, run))


def needed_by(run: Run) -> Floats | None:
    """Wheel torques (rows, 2) [N m] that the desired motion needs.

    None as in `outlook_of`, and if the robot is not known.
    """
    scenario = scenario_of_run(run)
    if scenario is None or unknown_keys(scenario):
        return None
    desired, rates = (
        np.stack([run[name] for name in names], axis=1)
        for names in (("v1_d", "v2_d"), ("v1_d_dot", "v2_d_dot"))
    )
    return needed_torque(scenario, run.time, desired, rates)


def scenario_of_run(run: Run) -> Scenario | None:
    """The scenario of a run; None if it was not saved, or needs packages that are not installed."""
    try:
        text = run.provenance.get(TEXT)
        return None if text is None else _scenario(text, run.scenario)
    except WmrError:
        return None


@lru_cache(maxsize=64)
def _scenario(text: str, name: str) -> Scenario:
    """Load a run's scenario; with its name it equals the original, so cached results are reused."""
    return loads_scenario(text, name)


@lru_cache(maxsize=256)
def _outlook(scenario: Scenario, law: Law, plant: str) -> Outlook:
    """`outlook`, cached for each law object, since another law may later have the same name."""
    return outlook(scenario, law.name, plant)


class CheckVerdict(StrEnum):
    """One-word verdict of `check`."""

    HOLDS = "holds"
    IN_PART = "holds-in-part"
    NOT_CHECKED = "not-checked"
    OBJECTED = "objected"


def verdict(warnings: Sequence[Warning], run: Run | None) -> CheckVerdict:
    """Verdict from theory's warnings and one run; ``objected`` if either finds a fault.

    ``not-checked`` if neither does, and theory was not evaluated completely.

    The grip of tyres, which the plane model does not have, is reported, but does not count.
    """
    theory = [item for item in warnings if item.equation != GRIP]
    keys = [item.key for item in run.remarks if item.key not in OF_THEORY] if run else []
    if any(item.objects for item in theory) or any(key not in IN_PART for key in keys):
        return CheckVerdict.OBJECTED
    if any(item.key == NOT_CHECKED for item in theory):
        return CheckVerdict.NOT_CHECKED
    return CheckVerdict.IN_PART if theory or keys else CheckVerdict.HOLDS
