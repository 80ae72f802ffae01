"""What a scenario states about disturbances, masses, sensors and friction, and itself breaks."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from wmr_ctrl.errors import ScenarioError
from wmr_ctrl.guard.bounds import AXES, UNITS, mass_range
from wmr_ctrl.scenario import Scenario
from wmr_ctrl.world.effect import Bound
from wmr_ctrl.world.friction import drag, phases
from wmr_ctrl.world.lag import stepped

Pair = tuple[float, float]
ROUNDING = 1e-9
"""Share by which a stated bound may be missed without contradiction: decimals of a file."""
MASS_UNITS, SPEED_UNITS = ("kg", "kg m2"), ("m/s", "rad/s")


@dataclass(frozen=True, slots=True)
class Contradiction:
    """A stated bound that the scenario breaks: its key, and a sentence of both numbers."""

    key: str
    sentence: str


def contradictions(scenario: Scenario, bound: Bound) -> Iterator[Contradiction]:
    """Yield each bound that is stated and broken; ``bound`` is what the effects add up to.

    What is left out is derived from the scenario and cannot contradict it.
    """
    yield from _disturbance(scenario, bound)
    yield from _masses(scenario, bound)
    yield from _sensor(scenario, bound)
    yield from _drives(scenario, bound)
    yield from _friction(scenario)


def refuse_contradictions(scenario: Scenario, bound: Bound) -> None:
    """Raise ScenarioError for the first contradiction, unless guard.trust says she means it."""
    if scenario.guard.trust:
        return
    for item in contradictions(scenario, bound):
        raise ScenarioError(
            f"{item.sentence} The guard would count on what this scenario breaks. If that is "
            "meant, as in a trial of a broken bound, set guard.trust = true."
        )


def _disturbance(scenario: Scenario, bound: Bound) -> Iterator[Contradiction]:
    model, most = scenario.guard.d_model, bound.dbar
    for i in AXES:
        needed = most[i] + model[i]
        if _below(scenario.guard.dbar, i, needed):
            yield Contradiction(
                "guard.dbar",
                f"guard.dbar[{i + 1}] = {_of(scenario.guard.dbar, i):g} {UNITS[i]} is below the "
                f"{needed:.6g} {UNITS[i]} that noise, push and guard.d_model of the scenario add "
                f"up to. State at least {needed:.6g}, leave it out, or lower the disturbance.",
            )


def _masses(scenario: Scenario, bound: Bound) -> Iterator[Contradiction]:
    least, most = mass_range(scenario, bound, margin=0.0)
    for i in AXES:
        unit, low, high = MASS_UNITS[i], scenario.guard.M_min, scenario.guard.M_max
        if low is not None and low[i] > least[i] * (1 + ROUNDING):
            yield Contradiction(
                "guard.M_min",
                f"guard.M_min[{i + 1}] = {low[i]:g} {unit} excludes the robot or a change, which "
                f"go down to {least[i]:.6g} {unit}. State at most that, or leave it out.",
            )
        if _below(high, i, most[i]):
            yield Contradiction(
                "guard.M_max",
                f"guard.M_max[{i + 1}] = {_of(high, i):g} {unit} excludes the robot or a change, "
                f"which go up to {most[i]:.6g} {unit}. State at least that, or leave it out.",
            )


def _sensor(scenario: Scenario, bound: Bound) -> Iterator[Contradiction]:
    for i in AXES:
        if _below(scenario.guard.nbar, i, bound.nbar[i]):
            yield Contradiction(
                "guard.nbar",
                f"guard.nbar[{i + 1}] = {_of(scenario.guard.nbar, i):g} {SPEED_UNITS[i]} is below "
                f"the {bound.nbar[i]:.6g} {SPEED_UNITS[i]} by which the sensors may be wrong. "
                "State at least that, leave it out, or measure better.",
            )


def _drives(scenario: Scenario, bound: Bound) -> Iterator[Contradiction]:
    """Delays and time constants that the scenario has and that were not stated.

    A constant one is covered by any constant that is as large; one that varies by its range alone.
    """
    lag, step = bound.lag, scenario.clock.plant
    there = {
        "delay": ("a delay", bound.takeover, bound.takeover[0]),
        "lag": ("a time constant", lag, lag[0] if lag[0] < lag[1] else stepped(lag[0], step)),
    }
    for name, (what, (low, high), least) in there.items():
        stated = scenario.guard.delay if name == "delay" else scenario.guard.lag
        if stated is None:
            continue
        varies = stated[0] < stated[1] or low < high
        if stated[1] < high * (1 - ROUNDING) or (varies and stated[0] * (1 - ROUNDING) > least):
            yield Contradiction(
                f"guard.{name}",
                f"guard.{name} = [{stated[0]:g}, {stated[1]:g}] s leaves out what the scenario's "
                f"drives have, {what} between {least:.6g} and {high:.6g} s. State at least that "
                "range, or leave it out.",
            )


def _friction(scenario: Scenario) -> Iterator[Contradiction]:
    there = sure_friction(scenario)
    for i in AXES:
        stated = scenario.guard.f_min[i]
        if stated > there[i] * (1 + ROUNDING):
            yield Contradiction(
                "guard.f_min",
                f"guard.f_min[{i + 1}] = {stated:g} {UNITS[i]} is above the {there[i]:.4g} "
                f"{UNITS[i]} of friction that the scenario is sure to have from guard.f_speed"
                f"[{i + 1}] = {scenario.guard.f_speed[i]:g} {SPEED_UNITS[i]} on. Lower it, or "
                "raise guard.f_speed where that helps.",
            )


def sure_friction(scenario: Scenario) -> Pair:
    """Least friction [N, N m] above guard.f_speed, over the run: the robot's turn has none."""
    slowest = (scenario.guard.f_speed[0], 0.0)
    least = min(drag(scenario.robot, phase, slowest)[0].item() for phase in phases(scenario))
    return least, 0.0


def _below(stated: Pair | None, axis: int, needed: float) -> bool:
    return stated is not None and stated[axis] < needed * (1 - ROUNDING)


def _of(stated: Pair | None, axis: int) -> float:
    assert stated is not None
    return stated[axis]
