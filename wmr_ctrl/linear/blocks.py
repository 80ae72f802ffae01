"""Names of what is linearised, and Systems read otherwise: held, or continuously."""

from __future__ import annotations

from collections.abc import Container
from dataclasses import replace
from itertools import pairwise

import numpy as np

from wmr_ctrl.checks.loop import PERIOD as PERIOD
from wmr_ctrl.checks.loop import Loop, loop_of
from wmr_ctrl.control.setup import settle
from wmr_ctrl.linear.linearise import element_names
from wmr_ctrl.model.system import System, stack
from wmr_ctrl.scenario import Scenario
from wmr_ctrl.signals import FORCE, TRACKING_ERROR, VELOCITY, Signal

DISTURBANCE = Signal(
    "disturbance", "N, N.m", "disturbing generalised force (thrust, turning moment)", 2
)
V_D = Signal("v_d", "m/s, rad/s", "desired velocity", 2)
FORCES = element_names((FORCE,))
DISTURBANCES = element_names((DISTURBANCE,))
STATES = element_names((TRACKING_ERROR, *VELOCITY))
"""e (3), v1, omega: the robot seen from its reference."""


def law_loop(scenario: Scenario, law: str) -> Loop:
    """``law`` on ``scenario`` as the checks see it, built once."""
    return loop_of(settle(scenario, law))


def unguarded(scenario: Scenario) -> Scenario:
    """The scenario with its guard off."""
    return replace(scenario, guard=replace(scenario.guard, enabled=False))


def holding(system: System, held: Container[str]) -> System:
    """The System with the memory of the ports named in ``held`` kept at its present value."""
    moving = tuple(item for item in system.state if item.signal.name not in held)
    fixed = tuple(item for item in system.state if item.signal.name in held)
    ends = np.cumsum([0, *(item.signal.size for item in system.state)])
    names = (item.signal.name for item in system.state)
    rows = {name: system.update[a:b] for name, (a, b) in zip(names, pairwise(ends), strict=True)}
    update = stack(rows[item.signal.name] for item in moving)
    return replace(system, state=moving, params=(*system.params, *fixed), update=update)


def continuous_reading(system: System) -> System:
    """A sampled System as a continuous one: each memory's rate is its change over one period.

    For explicit Euler steps (weights, estimates) that is the law as published; a remembered sample
    (PID) becomes a first-order lag of one period.
    """
    period = next(item.sym for item in system.params if item.signal.name == PERIOD)
    return replace(system, update=(system.update - system.x) / period, period=None)
