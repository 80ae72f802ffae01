"""Guard numbers that the scenario violates: stated bounds too small, or a robot unlike the believed
one.
"""

from collections.abc import Iterator
from dataclasses import dataclass

from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.core.fields.units import rounded
from wmr_ctrl.world.effect import Bound
from wmr_ctrl.world.lag import stepped
from wmr_ctrl.world.phases import drag, phases
from wmr_ctrl.world.scenario import Robot, Scenario

from .bounds import (
    AXES,
    MASS_KEYS,
    MASS_UNITS,
    SPEED_UNITS,
    UNITS,
    GuardNumbers,
    Pair,
    mass_range,
    masses,
    pair_of,
)

ROUNDING = 1e-9
"""Share by which a stated bound may be missed without contradiction: decimals of a file."""


@dataclass(frozen=True, slots=True)
class Contradiction:
    """A stated bound that the scenario violates: its key, and a sentence with both numbers."""

    key: str
    sentence: str


def contradictions(scenario: Scenario, bound: Bound) -> Iterator[Contradiction]:
    """Each bound that is stated and violated; ``bound`` is the effects' sum.

    Bounds that are not stated are derived from the scenario and cannot contradict it.
    """
    yield from _disturbance(scenario, bound)
    yield from _sensor(scenario, bound)
    yield from _drives(scenario, bound)
    yield from _friction(scenario)


def refuse_contradictions(scenario: Scenario, bound: Bound) -> None:
    """Raise ScenarioError for the first contradiction, unless guard.trust is set."""
    if scenario.guard.trust:
        return
    for item in contradictions(scenario, bound):
        raise ScenarioError(
            f"{item.sentence} The guard would rely on a bound that this scenario breaks. If that "
            "is intended, as in a trial of a broken bound, set guard.trust = true."
        )


def _disturbance(scenario: Scenario, bound: Bound) -> Iterator[Contradiction]:
    model, most = scenario.guard.d_model, bound.dbar
    for i in AXES:
        needed = most[i] + model[i]
        if _below(scenario.guard.dbar, i, needed):
            least = rounded(needed, 6)
            yield Contradiction(
                "guard.dbar",
                f"guard.dbar[{i + 1}] = {pair_of(scenario.guard.dbar)[i]:g} {UNITS[i]} is below "
                f"the {least} {UNITS[i]} that all disturbances of the scenario and guard.d_model "
                f"add up to. State at least {least}, leave it out, or lower the disturbance.",
            )


def _sensor(scenario: Scenario, bound: Bound) -> Iterator[Contradiction]:
    for i in AXES:
        if _below(scenario.guard.nbar, i, bound.nbar[i]):
            yield Contradiction(
                "guard.nbar",
                f"guard.nbar[{i + 1}] = {pair_of(scenario.guard.nbar)[i]:g} {SPEED_UNITS[i]} is "
                f"below the {rounded(bound.nbar[i], 6)} {SPEED_UNITS[i]} by which the sensors may "
                "be wrong. State at least that, leave it out, or measure better.",
            )


def _drives(scenario: Scenario, bound: Bound) -> Iterator[Contradiction]:
    """Objections to delays and time constants that the stated ones do not cover.

    A constant is covered by any larger constant, a varying one only by its range.
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
                f"guard.{name} = [{stated[0]:g}, {stated[1]:g}] s does not cover the scenario's "
                f"drives, which have {what} between {rounded(least, 6, up=False)} and "
                f"{rounded(high, 6)} s. State at least that range, or leave it out.",
            )


def _friction(scenario: Scenario) -> Iterator[Contradiction]:
    """Objections to claimed friction that exceeds the friction in the laws' model."""
    believed = _sure_friction(scenario, scenario.believed)
    for i in AXES:
        if scenario.guard.f_min[i] > believed[i] * (1 + ROUNDING):
            yield _too_much_friction(scenario, i, believed, "the laws believe in")


def beyond_belief(scenario: Scenario, guard: GuardNumbers, bound: Bound) -> Iterator[Contradiction]:
    """Differences of the true robot, also after its changes, from the guard's numbers.

    Laws and guard receive the believed numbers (model.*, guard.*), so this is an ordinary
    experiment: it is run, without a guarantee.
    """
    for i in AXES:
        yield from _mass(scenario, guard, bound, i)
    believed = _sure_friction(scenario, scenario.believed)
    there = _sure_friction(scenario, *(phase.robot for phase in phases(scenario)))
    for i in AXES:
        if there[i] * (1 + ROUNDING) < scenario.guard.f_min[i] <= believed[i] * (1 + ROUNDING):
            yield _too_much_friction(scenario, i, there, "the robot certainly has")


def _mass(scenario: Scenario, guard: GuardNumbers, bound: Bound, i: int) -> Iterator[Contradiction]:
    (low, high), spread, unit = mass_range(guard, i), bound.mass[i], MASS_UNITS[i]
    for t, mass in masses(scenario, i):
        light = mass - spread < low * (1 - ROUNDING)
        if light or mass + spread > high * (1 + ROUNDING):
            since = f" from t = {t:g} s on" if t else ""
            yield Contradiction(
                MASS_KEYS[0 if light else 1],
                f"The robot's {('mass', 'inertia')[i]} {mass:.6g} {unit}{since} lies outside what "
                f"the guard assumes, {low:.4g} to {high:.4g} {unit}. State "
                f"{' and '.join(MASS_KEYS)} around it for a guarantee.",
            )


def _too_much_friction(scenario: Scenario, i: int, there: Pair, whose: str) -> Contradiction:
    guard = scenario.guard
    return Contradiction(
        "guard.f_min",
        f"guard.f_min[{i + 1}] = {guard.f_min[i]:g} {UNITS[i]} is above the {there[i]:.4g} "
        f"{UNITS[i]} of friction that {whose} from guard.f_speed[{i + 1}] = {guard.f_speed[i]:g} "
        f"{SPEED_UNITS[i]} on. Lower it, or raise guard.f_speed where that helps.",
    )


def _sure_friction(scenario: Scenario, *robots: Robot) -> Pair:
    """Least friction [N, N m] above guard.f_speed; 0 for turning."""
    slowest = (scenario.guard.f_speed[0], 0.0)
    return min(drag(robot, slowest)[0].item() for robot in robots), 0.0


def _below(stated: Pair | None, axis: int, needed: float) -> bool:
    return stated is not None and stated[axis] < needed * (1 - ROUNDING)
