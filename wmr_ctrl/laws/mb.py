"""Model-based barrier law of the paper.

Source: Eq. (9), Theorem 1.  Differences from the paper: V1/A and q = (v - v_c1)/A are evaluated by
cancellation-free forms and take their limits where A = 0 (the printed A^-1 := 0 drops the
feed-forward there); rho is one gain per axis, as Section V uses it.  Choose it when mass, inertia
and friction are known and the control period is well below the stable limit.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from wmr_ctrl.laws.sample import Sample
from wmr_ctrl.model.system import System
from wmr_ctrl.scenario import Scenario
from wmr_ctrl.scenario.fields import Section, quantity


@dataclass(frozen=True)
class Gains(Section):
    """Gains of the model-based law."""

    KEY: ClassVar[str] = "gains.mb"

    rho: tuple[float, float] = quantity(
        (15.0, 57.6), unit="1/s", doc="decay rate of V1 per axis, Eq. (9)", above=0.0
    )


def build(scenario: Scenario) -> System:
    """F = M1 (-rho V1/A + q vc0') + F1, Eq. (9)."""
    sample = Sample("mb", scenario)
    command = (
        -sample.gain("rho") * sample.per_axis("V1_over_A") + sample.per_axis("q") * sample.v_c0_dot
    )
    return sample.system("model-based (MB)", sample.mass * command + sample.friction)
