"""How late drives and sensors are, in words, and what a linear loop leaves out of them."""

from __future__ import annotations

import casadi as ca

from wmr_ctrl.control.setup import Setup
from wmr_ctrl.model.graph import rounds
from wmr_ctrl.model.system import System
from wmr_ctrl.scenario import Scenario
from wmr_ctrl.signals import SAMPLE, STEP, TIME
from wmr_ctrl.world.pose_delay import PoseDelay
from wmr_ctrl.world.pose_sensor import PoseSensor
from wmr_ctrl.world.registry import EFFECTS


def delays_by_name(setup: Setup) -> dict[str, float]:
    """What is late [s], by word; a window of one sample goes with the period itself."""
    bound, late = setup.bound, setup.scenario.section(PoseDelay).pose_delay
    window = max(bound.window)
    parts = {
        "delay": bound.delay, "lag": bound.lag[1], "velocity's age": max(bound.age),
        "velocity's window": window if window >= 1.5 * setup.scenario.clock.control else 0.0,
        "pose's age": late,
    }  # fmt: skip
    return {word: value for word, value in parts.items() if value}


def oldest_shown(setup: Setup) -> float:
    """Age of the oldest velocity or pose that a sensor still shows [s]."""
    bound = setup.bound
    ages = [age + window for age, window in zip(bound.age, bound.window, strict=True)]
    return max(*ages, setup.scenario.section(PoseDelay).pose_delay)


def is_sampled(setup: Setup) -> bool:
    """Whether there is more than a lag: what a differential equation has no place for."""
    sensor = setup.scenario.section(PoseSensor)
    filtered = sensor.correction < 1 or sensor.pose_period > 0
    return setup.bound.delay > 0 or oldest_shown(setup) > 0 or filtered


def lost_poses(scenario: Scenario) -> str:
    """What the linear loop leaves out of the pose sensor, in words; empty if nothing."""
    lost = scenario.section(PoseSensor).pose_dropout
    return f"as if all poses came, though {lost:.0%} of them do not" if lost > 0 else ""


def rounded_effects(scenario: Scenario) -> str:
    """Which effects round, which has no derivative, in words; empty if none."""
    named = " and ".join(f"[{item.section.KEY}]" for item in EFFECTS.present(scenario)
                         if _rounds(item.system(scenario)))  # fmt: skip
    return f"as if there were no rounding in {named}" if named else ""


def _rounds(system: System) -> bool:
    clocks = (TIME, SAMPLE, STEP)
    seen = (item.sym for item in system.inputs if item.signal not in clocks)
    return rounds(ca.vertcat(system.update, system.y), ca.vertcat(*seen, system.x))


def rare_poses(scenario: Scenario) -> str:
    """What a loop that is the same at every sample leaves out of the pose sensor, in words."""
    sensor, period = scenario.section(PoseSensor), scenario.clock.control
    parts = [f"a pose comes every {sensor.pose_period:g} s"] * (sensor.pose_period > period)
    parts += [f"{sensor.pose_dropout:.0%} of them do not come"] * (sensor.pose_dropout > 0)
    said = " and ".join(parts)
    return f"as if a pose came at every sample, though {said}" if said else ""
