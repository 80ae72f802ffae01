"""Margins and sample times when the robot is not what the law believes."""

from __future__ import annotations

from dataclasses import dataclass

from wmr_ctrl.linear.margins import margins_at, with_robot, worst
from wmr_ctrl.linear.sampled import largest_stable_period
from wmr_ctrl.scenario import Scenario

FACTORS = (0.5, 1.5)
PARAMETERS = ("m", "I", "mu")


@dataclass(frozen=True)
class ModelError:
    """One parameter of the robot times ``factor``, the law's model unchanged.

    Phase margin [degrees] and disk margin of the worse force; None where the loop is unstable.
    """

    parameter: str
    factor: float
    stable: bool
    phase: float | None
    disk: float | None
    max_sample_time: float


def model_errors(scenario: Scenario, law: str) -> list[ModelError]:
    """Mass, inertia and friction 50 % lower and 50 % higher, one at a time."""
    return [_one(scenario, law, key, factor) for key in PARAMETERS for factor in FACTORS]


def _one(scenario: Scenario, law: str, parameter: str, factor: float) -> ModelError:
    other = with_robot(scenario, **{parameter: factor})
    found = worst([margins_at(other, law, axis) for axis in (0, 1)])
    limit = largest_stable_period(other, law)
    if found is None:
        return ModelError(parameter, factor, False, None, None, limit)
    return ModelError(parameter, factor, True, found.phase, found.disk, limit)
