"""Numbers of a setup that its graphs do not depend on: scenarios that differ in those share C.

A graph reads numbers through its parameters.  What else decides its form is the kind of every part,
texts and flags, how long vectors are, whether a number is 0 or infinite (an effect is there or
not), and the clock where commands under way are counted in its steps.
"""

import math
from collections.abc import Hashable
from dataclasses import fields

from wmr_ctrl.control.setup import Setup
from wmr_ctrl.fields.section import Section
from wmr_ctrl.guard.bounds import LATENESS
from wmr_ctrl.laws.registry import NAMES
from wmr_ctrl.world.references.registry import OURS as OUR_REFERENCES
from wmr_ctrl.world.registry import OURS as OUR_EFFECTS


def structure_of(setup: Setup) -> Hashable:
    """Equal for setups whose graphs are the same but for the values of parameters.

    A law, effect or reference of another package may read numbers as it likes: then every number
    counts.
    """
    scenario, kind = setup.scenario, setup.scenario.reference_kind
    parts = (setup.law, tuple(item.name for item in setup.effects), kind.name)
    foreign = (
        setup.name not in NAMES
        or kind not in OUR_REFERENCES
        or any(item not in OUR_EFFECTS for item in setup.effects)
    )
    if foreign:
        return parts, tuple(vars(scenario).items())  # its text is short, and this one's is hashed
    sizes = tuple(signal.size for signal, _ in kind.numbers(scenario.reference))
    known = ["robot", "limits", "disturbance", "sensor", "actuator", "base"]
    known += [item.section.KEY for item in setup.effects if item.section.KEY not in known]
    tables = tuple(_form(scenario.table(key)) for key in known)
    shape = tuple(scenario.value(key) for item in setup.effects for key in item.shape)
    guard = (scenario.guard.enabled, scenario.guard.map)
    steps = _steps(setup), setup.predicted, _velocity(setup)
    return parts, sizes, tables, shape, guard, steps, _form(setup.gains), _form(setup.kinematics)


def _steps(setup: Setup) -> Hashable:
    """The clock, where a controller counts its steps."""
    actuator, clock, guard = setup.scenario.actuator, setup.scenario.clock, setup.guard
    times = tuple(getattr(guard, name) for name in LATENESS)
    if actuator.ideal and not any(any(pair) for pair in times):
        return None
    return clock.control, clock.plant, actuator.delay, times


def _velocity(setup: Setup) -> Hashable:
    """Filter and clock of a base that takes velocities: the filter counts in samples."""
    scenario = setup.scenario
    return (scenario.filter, scenario.clock, scenario.base) if setup.takes_velocity else None


def _form(section: Section) -> Hashable:
    return tuple(_mask(getattr(section, item.name)) for item in fields(section))  # type: ignore[arg-type]


def _mask(value: object) -> Hashable:
    if isinstance(value, tuple):
        return tuple(_mask(item) for item in value)
    if not isinstance(value, float):
        return value if isinstance(value, Hashable) else repr(value)
    return "0" if value == 0 else "inf" if math.isinf(value) else "number"
