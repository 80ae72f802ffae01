"""What the guard leaves in the cases of the comparison, and how often it acted there."""

from __future__ import annotations

from dataclasses import dataclass

from wmr_ctrl.campaign.comparison import SCENARIO, GuardComparison, overrides_of
from wmr_ctrl.control.setup import settle
from wmr_ctrl.guard.bounds import net, usable_speed
from wmr_ctrl.guard.price import speed_price
from wmr_ctrl.report.style import shown
from wmr_ctrl.report.tables import TextTable, clip_shares
from wmr_ctrl.scenario import Scenario, load_scenario
from wmr_ctrl.world.friction import largest_friction


@dataclass(frozen=True, slots=True)
class GuardPrice:
    """What the guard leaves in a case: friction and dbar [N], M_min [kg], T [s].

    ``usable`` speed and turn rate beside those ``asked`` of it [m/s, rad/s]; ``standstill`` is the
    period from which on the usable speed is negative [s].
    """

    friction: float
    dbar: float
    mass: float
    period: float
    usable: tuple[float, float]
    asked: tuple[float, float]
    standstill: float


def price_of(base: str, factor: str) -> GuardPrice:
    """Usable speeds of a case against the largest friction of the paper's robot."""
    scenario = _scenario(base, factor)
    guard = settle(scenario, None).guard
    friction = largest_friction(load_scenario(SCENARIO))
    usable, asked = (
        usable_speed(scenario, guard, (friction, 0.0)),
        speed_price(scenario, guard).asked,
    )
    mass, dbar = (guard.M_min or (0.0, 0.0))[0], (guard.dbar or (0.0, 0.0))[0]
    room = scenario.limits.v_u1[0] - (guard.nbar or (0.0, 0.0))[0]
    standstill = mass * room / (friction + net(guard, 0))
    return GuardPrice(friction, dbar, mass, scenario.clock.control, usable, asked, standstill)


def price_table(rows: GuardComparison, cases: tuple[tuple[str, str], ...]) -> TextTable:
    """The usable speeds under the bounds of each case, and how often the guard acted there."""
    body = tuple(
        (f"{factor}, {base}", *_priced(price_of(base, factor)), _changed(rows, base, factor))
        for base, factor in cases
    )
    head = ("bounds of", "M_min [kg]", "d̄ [N]", "friction f [N]", "v_use [m/s]",
            "reference v₁d [m/s]", "ω_use [rad/s]", "reference |ωd| [rad/s]",
            "T with v_use = 0 [ms]", "samples changed: thrust, moment [%]")  # fmt: skip
    return TextTable(
        "Largest steady speed and turn rate that the guard admits, beside the reference's own "
        "largest; and the share of samples in which it changed the force, median over laws and "
        "seeds",
        head, body,
    )  # fmt: skip


def _priced(price: GuardPrice) -> tuple[str, ...]:
    pairs = (pair[axis] for axis in (0, 1) for pair in (price.usable, price.asked))
    known = (price.mass, price.dbar, price.friction, *pairs, 1e3 * price.standstill)
    return tuple(map(shown, known))


def _changed(rows: GuardComparison, base: str, factor: str) -> str:
    return clip_shares([r for law in rows.laws for r in rows.of(base, factor, law, True)])


def _scenario(base: str, factor: str) -> Scenario:
    return load_scenario(SCENARIO, {**overrides_of(base, factor), "guard.enabled": True})
