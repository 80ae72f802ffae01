"""Gains of a scenario as checked dataclasses of the laws that own them."""

from __future__ import annotations

from typing import Any

from wmr_ctrl.errors import UnknownNameError
from wmr_ctrl.fields.section import build
from wmr_ctrl.laws.registry import LAWS
from wmr_ctrl.model import auxiliary
from wmr_ctrl.scenario import Scenario

KINEMATICS = "kinematics"


def gains_of(scenario: Scenario, law: str) -> Any:
    """The law's Gains with what the scenario sets; raises on unknown names and bad values."""
    return build(LAWS[law].gains, scenario.gains.get(law, {}), f"gains.{law}")


def kinematic_gains(scenario: Scenario) -> auxiliary.Gains:
    """k_1, k_2, k_3 of Eq. (7)."""
    return build(auxiliary.Gains, scenario.gains.get(KINEMATICS, {}), f"gains.{KINEMATICS}")


def check_gains(scenario: Scenario) -> None:
    """Raise where the scenario names a law or a gain that does not exist, or a bad value."""
    kinematic_gains(scenario)
    for name in scenario.gains:
        if name == KINEMATICS:
            continue
        if name not in LAWS:
            raise UnknownNameError("section of gains", name, (*LAWS, KINEMATICS))
        gains_of(scenario, name)
