"""What the guard's bounds of a case mean: usable speed, the slowest sample, the refusal's words."""

from __future__ import annotations

from dataclasses import dataclass

from wmr_ctrl.campaign.ours import BASES, overrides_of
from wmr_ctrl.campaign.ours_run import SCENARIO
from wmr_ctrl.errors import ScenarioError
from wmr_ctrl.guard.bounds import net, settled_guard, usable_speed
from wmr_ctrl.report.tables import TextTable
from wmr_ctrl.report.wording import shown
from wmr_ctrl.scenario import Scenario, load_scenario


@dataclass(frozen=True, slots=True)
class Price:
    """Thrust axis of a case: friction and dbar [N], M_min [kg], T [s], v_use [m/s].

    ``standstill`` is the period from which on v_use is negative [s].
    """

    friction: float
    dbar: float
    mass: float
    period: float
    usable: float
    standstill: float


def price_of(base: str, factor: str) -> Price:
    """v_use of a case against the largest friction of the paper's robot."""
    scenario = _scenario(base, factor)
    guard = settled_guard(scenario, scenario.actuator.tau_max)
    friction = largest_friction(load_scenario(SCENARIO))
    usable = usable_speed(scenario, (friction, 0.0), scenario.actuator.tau_max)[0]
    mass, dbar = (guard.M_min or (0.0, 0.0))[0], (guard.dbar or (0.0, 0.0))[0]
    room = scenario.limits.v_u1[0] - (guard.nbar or (0.0, 0.0))[0]
    standstill = mass * room / (friction + net(guard, 0))
    return Price(friction, dbar, mass, scenario.clock.control, usable, standstill)


def price_table(cases: tuple[tuple[str, str], ...]) -> TextTable:
    """The usable speed under the bounds of each case."""
    priced = [(base, factor, price_of(base, factor)) for base, factor in cases]
    body = tuple(
        (f"{factor}, {base}", *map(shown, (p.mass, p.dbar, p.friction, p.usable)),
         shown(1e3 * p.standstill))
        for base, factor, p in priced
    )  # fmt: skip
    head = ("bounds of", "M_min [kg]", "d̄ [N]", "friction f [N]", "v_use [m/s]",
            "T with v_use = 0 [ms]")  # fmt: skip
    return TextTable("Largest steady speed that the guard admits", head, body)


def largest_friction(scenario: Scenario) -> float:
    """Largest mu m g over the robot and its changes [N]."""
    robot = scenario.robot
    pairs = [(robot.mu, robot.m), *((c.mu, c.m) for c in scenario.changes)]
    return max((mu or 0.0) * (m or 0.0) * robot.g for mu, m in pairs)


def start_ratio(factor: str) -> float:
    """Largest |v|/limit at the start of a case."""
    scenario = load_scenario(SCENARIO, overrides_of(next(iter(BASES)), factor))
    pairs = zip(scenario.initial.velocity, scenario.limits.v_u1, strict=True)
    return max(abs(v) / limit for v, limit in pairs)


def refusal_of(base: str, factor: str) -> str:
    """The words with which the guard refuses a case; empty if it does not."""
    try:
        scenario = _scenario(base, factor)
        settled_guard(scenario, scenario.actuator.tau_max)
    except ScenarioError as error:
        return str(error)
    return ""


def _scenario(base: str, factor: str) -> Scenario:
    return load_scenario(SCENARIO, {**overrides_of(base, factor), "guard.enabled": True})
