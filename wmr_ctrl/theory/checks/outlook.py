"""Prior knowledge of a run: objections, the torque that its motion needs.

A run's verdict rests on it beside the log: it is not well where `wmr-ctrl check` would object, and
whether torques are large or restless is judged by what the motion needs.  Judged once for each
scenario, law and plant, when a run's remarks are first asked for; making runs costs nothing.
"""

from collections.abc import Sequence
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
from .torques import GRIP

TEXT = "scenario_toml"
"""Provenance key of a run's scenario."""
IN_PART = ("assumption-void", "exact-pose")
"""Remarks that narrow what a run shows, and blame it for nothing."""
OF_THEORY = (OBJECTED, NOT_CHECKED)
"""Remarks that repeat what theory says without a run."""


def outlook(scenario: Scenario, law: str, plant: str = "ode") -> Outlook:
    """The Outlook of a law on a scenario and a plant; raises what `settle` raises.

    A law that is not the scenario's `default_law` was asked for.
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
    """The Outlook of a run; None where its scenario is not known here.

    Of a law that is not known here, such as somebody else's controller, theory says nothing.
    """
    scenario = scenario_of_run(run)
    if scenario is None:
        return None
    if run.law not in LAWS:
        return Outlook(scenario.actuator.tau_max, (), _has_exact_pose(scenario), known=False)
    return _outlook(scenario, LAWS[run.law], run.settings.plant_kind)


def needed_by(run: Run) -> Floats | None:
    """Wheel torques (rows, 2) [N m] that the desired motion needs.

    None as `outlook_of`, and where the robot is not known.
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
    """The scenario of a run; None where it was not kept, or has parts that are not installed."""
    try:
        text = run.provenance.get(TEXT)
        return None if text is None else _scenario(text, run.scenario)
    except WmrError:
        return None


@lru_cache(maxsize=64)
def _scenario(text: str, name: str) -> Scenario:
    """With its name, it equals the scenario that was run, and nothing is worked out again."""
    return loads_scenario(text, name)


@lru_cache(maxsize=256)
def _outlook(scenario: Scenario, law: Law, plant: str) -> Outlook:
    """`outlook`, judged once for each law, of which another may have its name later."""
    return outlook(scenario, law.name, plant)


class CheckVerdict(StrEnum):
    """Verdict of `check` in a word."""

    HOLDS = "holds"
    IN_PART = "holds-in-part"
    NOT_CHECKED = "not-checked"
    OBJECTED = "objected"


def verdict(warnings: Sequence[Warning], run: Run | None) -> CheckVerdict:
    """Of what theory says and one run shows; ``objected`` where either finds a fault.

    ``not-checked`` where neither does, and theory was not asked to the end.

    The grip of tyres, which the plane model does not have, is reported and not part of it.
    """
    theory = [item for item in warnings if item.equation != GRIP]
    keys = [item.key for item in run.remarks if item.key not in OF_THEORY] if run else []
    if any(item.objects for item in theory) or any(key not in IN_PART for key in keys):
        return CheckVerdict.OBJECTED
    if any(item.key == NOT_CHECKED for item in theory):
        return CheckVerdict.NOT_CHECKED
    return CheckVerdict.IN_PART if theory or keys else CheckVerdict.HOLDS
