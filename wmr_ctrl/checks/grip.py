"""Torques that a law and the reference ask for, against those at which wheels spin or lift."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from wmr_ctrl.checks.warning import Warning
from wmr_ctrl.control.controller import controller
from wmr_ctrl.control.setup import Setup
from wmr_ctrl.scenario import Scenario
from wmr_ctrl.signals import PLANT_STATE, REFERENCE
from wmr_ctrl.world.grip import Grip, grip
from wmr_ctrl.world.phases import needed_torque
from wmr_ctrl.world.references import sample

KEY = "actuator.tau_max"
PLACE = "grip, docs/physics.md"
_INSTANTS = 400
"""Times at which the reference's torques are looked at."""


def first_torques(setup: Setup) -> tuple[float, float]:
    """Torques (right, left) [N m] that a law commands at t = 0, without noise."""
    scenario, system = setup.scenario, controller(setup)
    names = (*REFERENCE, *PLANT_STATE)
    numbers = (
        *sample(scenario, np.zeros(1))[0],
        *scenario.initial.pose,
        *scenario.initial.velocity,
    )
    known = dict(zip((item.name for item in names), numbers, strict=True))
    given = [known.get(name, 0.0) for item in system.inputs for name in item.signal.elements]
    torque = system.function("first", [system.y])(given, system.x0, system.p0)
    right, left = np.asarray(torque).ravel().tolist()
    return right, left


def reference_torque(scenario: Scenario) -> float:
    """Largest wheel torque [N m] with which the plane model stays on the reference."""
    times = np.linspace(0.0, scenario.clock.duration, _INSTANTS)
    rows = sample(scenario, times)
    return float(np.abs(needed_torque(scenario, times, rows[:, 3:5], rows[:, 5:7])).max())


def grip_warnings(setup: Setup) -> tuple[Warning, ...]:
    """What the tyres of [body] have against a law on a scenario; the plane model has none."""
    return tuple(_told(setup, grip(setup.scenario)))


def _told(setup: Setup, seen: Grip) -> Iterator[Warning]:
    first, steady = max(map(abs, first_torques(setup))), reference_torque(setup.scenario)
    if first > seen.spin:
        end = "on a rigid body they slide, and fling it when they bite again"
        if first > seen.lift:
            end = f"and beyond {seen.lift:.3g} N m the robot turns over on its caster"
        yield Warning(
            KEY,
            f"At its first sample {setup.name} asks a wheel for {first:.3g} N m; the wheels of "
            f"[body] spin from {seen.spin:.3g} N m on, {end}. {_remedy(seen)}",
            PLACE,
        )
    if steady > seen.keep:
        yield Warning(
            KEY,
            f"The reference asks a wheel for up to {steady:.3g} N m, and the tyres of [body] are "
            f"sure of {seen.keep:.3g} N m at limits.v_u1. Ask for a slower or smoother reference.",
            PLACE,
        )


def _remedy(seen: Grip) -> str:
    if seen.keep <= 0:
        return (
            "At limits.v_u1 no torque is sure of its grip: lower the limits or state better tyres."
        )
    return (
        f"Up to {KEY} = {math.floor(100 * seen.keep) / 100:g} no wheel slides within limits.v_u1 "
        "(actuator.traction = true keeps to that); --plant mujoco shows a run on tyres."
    )
