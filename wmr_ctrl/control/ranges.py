"""Ranges of parameters, as the scenario's fields and the laws' gains declare them."""

from collections.abc import Iterable

from wmr_ctrl.control.setup import KINEMATICS
from wmr_ctrl.fields.section import Section, quantities
from wmr_ctrl.fields.values import Range as Admitted
from wmr_ctrl.laws import LAWS
from wmr_ctrl.model.kinematics import KinematicGains
from wmr_ctrl.scenario import Scenario
from wmr_ctrl.scenario.scenario import sections
from wmr_ctrl.signals import LARGEST
from wmr_ctrl.world.speed_loop import takes_velocity

SMALLEST = 1e-12
"""Stands for `above zero`, since FMI's ranges include their ends."""

Range = tuple[float, float]


def ranges_of(scenario: Scenario, keys: Iterable[str]) -> dict[str, Range]:
    """Lowest and highest value of each key path that is a field of the scenario or a law's gain."""
    ranges = {}
    for key, bounds in fields_of(scenario, keys).items():
        above, below = bounds.above, bounds.below
        lows = (bounds.minimum, None if above is None else above + SMALLEST, -LARGEST)
        highs = (bounds.maximum, None if below is None else below - SMALLEST, LARGEST)
        low, high = (next(float(x) for x in ends if x is not None) for ends in (lows, highs))
        ranges[key] = (low, high)
    return ranges


def fields_of(scenario: Scenario, keys: Iterable[str]) -> dict[str, Admitted]:
    """Bounds of each key path's field, open ends told apart from closed ones."""
    admitted = {}
    for key in keys:
        holder = _holder(scenario, key)
        fields = dict(quantities(holder)) if holder else {}
        if (name := key.rpartition(".")[2]) in fields:
            admitted[key] = fields[name].bounds
    return admitted


def clock_of(scenario: Scenario) -> dict[str, Range]:
    """Ranges of the clock where the drives have lag or delay: the controller counts its steps.

    So it does where it sends velocities, behind a filter or a delay.
    """
    if scenario.actuator.ideal and not takes_velocity(scenario):
        return {}
    return {f"clock.{key}": (getattr(scenario.clock, key),) * 2 for key in ("control", "plant")}


def _holder(scenario: Scenario, key: str) -> type[Section] | None:
    """The section that a key's field may stand in, or None."""
    section, *rest = key.split(".")
    if section == "gains" and rest:
        law = rest[0]
        return KinematicGains if law == KINEMATICS else LAWS[law].gains if law in LAWS else None
    return type(scenario.table(section)) if section in sections() and len(rest) == 1 else None
