"""The law that drives where a caller names none."""

from dataclasses import dataclass

from wmr_ctrl.world.scenario import Scenario

from .laws.given import law_name

UNSTATED = "kanayama"
"""The law of a scenario that states none: it needs no model of the robot."""


@dataclass(frozen=True, slots=True)
class DefaultLaw:
    """The law that drives where a caller names none, and whether the scenario states it."""

    name: str
    stated: bool

    @property
    def why(self) -> str:
        """Where the name is from, in words."""
        return "stated in the scenario" if self.stated else "not stated"


def default_law(scenario: Scenario) -> DefaultLaw:
    """The law of a scenario where none is named: its own, else kanayama."""
    stated = scenario.law is not None
    return DefaultLaw(law_name(scenario.law) if scenario.law else UNSTATED, stated)


def law_of(scenario: Scenario, law: str | None) -> str:
    """The law that a caller names, else the scenario's `default_law`."""
    return default_law(scenario).name if law is None else law


def judges_gains(scenario: Scenario, law: str, asked: bool) -> bool:
    """Whether gains of ``law`` are somebody's choice, so that they are objected to.

    They are where the law was asked for or is stated, or is the default and its gains are stated.
    """
    own = default_law(scenario)
    return asked or (law == own.name and (own.stated or law in scenario.gains))
