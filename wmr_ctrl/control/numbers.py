"""Numbers of a setup that its graphs do not depend on, and their declared ranges.

A graph reads numbers through its parameters.  Its form also depends on the kind of every part, on
texts and flags, on lengths of vectors, on whether a number is 0 or infinite (an effect is present
or not), and on the clock if commands in transit are counted in its steps.  Scenarios that differ
only in parameters share C code.  Ranges are those of the scenario's fields and of the laws' gains.
"""

import math
from collections.abc import Hashable, Iterable
from dataclasses import fields

from wmr_ctrl.core.fields.section import Section, quantities
from wmr_ctrl.core.fields.values import Range as Admitted
from wmr_ctrl.core.signals import LARGEST
from wmr_ctrl.world.model.kinematics import KinematicGains
from wmr_ctrl.world.references.registry import OURS as OUR_REFERENCES
from wmr_ctrl.world.registry import OURS as OUR_EFFECTS
from wmr_ctrl.world.scenario import Scenario, sections, unknown_keys

from .guard.bounds import LATENESS
from .laws import LAWS
from .laws.registry import NAMES
from .setup import KINEMATICS, Setup

ALWAYS_READ = frozenset((
    "disturbance.std", "disturbance.truncate", "sensor.pose_noise", "sensor.pose_period",
    "sensor.velocity_noise",
))  # fmt: skip
"""Keys of numbers of which graphs are the same where they are 0 or infinite."""


def structure_of(setup: Setup) -> Hashable:
    """Key that is equal for setups whose graphs differ at most in values of parameters.

    A law, effect or reference of another package may read any number.  Then all numbers are in the
    key.
    """
    scenario, kind = setup.scenario, setup.scenario.reference_kind
    parts = (setup.law, tuple(item.name for item in setup.effects), kind.name)
    ours = setup.name in NAMES and kind in OUR_REFERENCES
    if not (ours and all(item in OUR_EFFECTS for item in setup.effects)):
        return parts, tuple(vars(scenario).items())  # its text is short, and this one's is hashed
    sizes = tuple(signal.size for signal, _ in kind.numbers(scenario.reference))
    known = ["robot", "limits", "disturbance", "sensor", "actuator", "base"]
    known += [item.section.KEY for item in setup.effects if item.section.KEY not in known]
    tables = tuple(_form(scenario.table(key), f"{key}.") for key in known)
    shape = tuple(scenario.value(key) for item in setup.effects for key in item.shape)
    guard = (scenario.guard.enabled, scenario.guard.map)
    sent = (scenario.filter, scenario.clock, scenario.base)  # the filter counts in samples
    steps = _steps(setup), setup.predicted, sent if setup.takes_velocity else None
    nothing = bool(unknown_keys(scenario))  # unknown torques are NaN
    told = guard, nothing, scenario.limits.apart, scenario.obstacles
    return parts, sizes, tables, shape, told, steps, _form(setup.gains), _form(setup.kinematics)


def _steps(setup: Setup) -> Hashable:
    """The clock, if a controller counts its steps."""
    actuator, clock, guard = setup.scenario.actuator, setup.scenario.clock, setup.guard
    times = tuple(getattr(guard, name) for name in LATENESS)
    if actuator.ideal and not any(any(pair) for pair in times):
        return None
    return clock.control, clock.plant, actuator.delay, times


def _form(section: Section, head: str = "") -> Hashable:
    names = (item.name for item in fields(section))  # type: ignore[arg-type]
    return tuple(
        None if f"{head}{name}" in ALWAYS_READ else _mask(getattr(section, name)) for name in names
    )


def _mask(value: object) -> Hashable:
    if isinstance(value, tuple):
        return tuple(_mask(item) for item in value)
    if not isinstance(value, float):
        return value if isinstance(value, Hashable) else repr(value)
    return "0" if value == 0 else "inf" if math.isinf(value) else "number"


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
    """Bounds of each key path's field, with open and closed ends distinguished."""
    admitted = {}
    for key in keys:
        holder = _holder(scenario, key)
        fields = dict(quantities(holder)) if holder else {}
        if (name := key.rpartition(".")[2]) in fields:
            admitted[key] = fields[name].bounds
    return admitted


def clock_of(scenario: Scenario) -> dict[str, Range]:
    """Ranges of the clock if the controller counts its steps.

    It does so for drives with lag or delay, and if it sends velocities behind a filter or a delay.
    """
    if scenario.actuator.ideal and not scenario.takes_velocity:
        return {}
    return {f"clock.{key}": (getattr(scenario.clock, key),) * 2 for key in ("control", "plant")}


def _holder(scenario: Scenario, key: str) -> type[Section] | None:
    """The section that contains a key's field, or None."""
    section, *rest = key.split(".")
    if section == "gains" and rest:
        law = rest[0]
        return KinematicGains if law == KINEMATICS else LAWS[law].gains if law in LAWS else None
    return type(scenario.table(section)) if section in sections() and len(rest) == 1 else None
