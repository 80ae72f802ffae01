"""The linear loop as a function of time along a reference, frozen at each instant."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import control as ct

from wmr_ctrl.theory.linear import closed_loop, on_reference
from wmr_ctrl.theory.linear.state_space import constant_speed
from wmr_ctrl.world.scenario import Scenario


@dataclass(frozen=True)
class TimeInvariant:
    """One StateSpace for the whole reference: in error coordinates nothing depends on time."""

    system: ct.StateSpace

    def __call__(self, t: float) -> ct.StateSpace:
        """The same system at every time ``t`` [s]."""
        return self.system


@dataclass(frozen=True)
class TimeVarying:
    """The linear loop as a function of time; every call is one exact linearisation.

    Poles of frozen instants are no proof of stability, only a picture.
    """

    scenario: Scenario
    law: str
    period: float | None = None

    def __call__(self, t: float) -> ct.StateSpace:
        """The loop near the reference's point at time ``t`` [s]."""
        return _at(self.scenario, self.law, self.period, float(t))


@lru_cache(maxsize=512)
def _at(scenario: Scenario, law: str, period: float | None, t: float) -> ct.StateSpace:
    return closed_loop(scenario, law, on_reference(scenario, law, t), period)


def along_reference(
    scenario: Scenario, law: str, period: float | None = None
) -> TimeInvariant | TimeVarying:
    """The linear loop of ``law`` along the reference, e = 0 and v = v_d; sampled if ``period``."""
    if constant_speed(scenario):
        return TimeInvariant(closed_loop(scenario, law, period=period))
    return TimeVarying(scenario, law, period)
