"""Scenario: everything that a run needs to know besides the law, checked and unchangeable."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TypeAlias

from wmr_ctrl.fields.frozen import Frozen
from wmr_ctrl.scenario.actuator import Actuator
from wmr_ctrl.scenario.change import Change
from wmr_ctrl.scenario.clock import Clock
from wmr_ctrl.scenario.disturbance import Disturbance
from wmr_ctrl.scenario.gains import Gains, clean_gains
from wmr_ctrl.scenario.guard import Guard
from wmr_ctrl.scenario.initial import Initial
from wmr_ctrl.scenario.limits import Limits
from wmr_ctrl.scenario.metrics import Metrics
from wmr_ctrl.scenario.reference import Circle, Reference
from wmr_ctrl.scenario.relations import check_types, relate
from wmr_ctrl.scenario.robot import Model, Robot
from wmr_ctrl.scenario.sensor import Sensor

Sections: TypeAlias = (
    Robot | Model | Limits | Initial | Disturbance | Sensor | Actuator | Guard | Clock | Metrics
)

SECTIONS: dict[str, type[Sections]] = {
    "robot": Robot,
    "model": Model,
    "limits": Limits,
    "initial": Initial,
    "disturbance": Disturbance,
    "sensor": Sensor,
    "actuator": Actuator,
    "guard": Guard,
    "clock": Clock,
    "metrics": Metrics,
}
"""Tables of a scenario that are one dataclass each, by key."""


@dataclass(frozen=True)
class Scenario:
    """A robot, what its laws believe, limits, gains, a start, a reference, and what disturbs it.

    The defaults are Section V of the paper without the change of parameters at 40 s.  SI units.
    ``gains`` holds those that the scenario names, by law and gain; numbers are floats, arrays
    tuples of floats.  A law's other gains are the law's own defaults.
    """

    name: str = "unnamed"
    title: str = ""
    robot: Robot = field(default_factory=Robot)
    model: Model = field(default_factory=Model)
    limits: Limits = field(default_factory=Limits)
    gains: Gains = field(default_factory=Frozen)
    initial: Initial = field(default_factory=Initial)
    reference: Reference = field(default_factory=Circle)
    disturbance: Disturbance = field(default_factory=Disturbance)
    sensor: Sensor = field(default_factory=Sensor)
    actuator: Actuator = field(default_factory=Actuator)
    guard: Guard = field(default_factory=Guard)
    changes: tuple[Change, ...] = ()
    clock: Clock = field(default_factory=Clock)
    metrics: Metrics = field(default_factory=Metrics)

    def __post_init__(self) -> None:
        """Freeze what is inside and check the relations between the sections."""
        check_types(self)
        object.__setattr__(self, "gains", clean_gains(self.gains))
        object.__setattr__(self, "changes", tuple(self.changes))
        relate(self)

    @property
    def believed(self) -> Robot:
        """The robot as the laws believe it to be; no change ever alters it."""
        given = {key: value for key, value in vars(self.model).items() if value is not None}
        return dataclasses.replace(self.robot, **given)

    @property
    def split(self) -> float:
        """Time that splits the run into before and after, s."""
        return self.clock.duration / 2 if self.metrics.split is None else self.metrics.split


def section_defaults() -> Mapping[str, Sections]:
    """Return each one-dataclass section with its defaults, by key."""
    return {name: cls() for name, cls in SECTIONS.items()}
