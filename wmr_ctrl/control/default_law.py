"""The law to use if a caller names none."""

from dataclasses import dataclass

from wmr_ctrl.world.scenario import Scenario

from .laws.given import law_name

UNSTATED = "kanayama"
"""The law of a scenario that states none: it needs no model of the robot."""


@dataclass(frozen=True, slots=True)
class DefaultLaw:
    """The law to use if a caller names none, and whether the scenario states it."""

    name: str
    stated: bool

    @property
    def why(self) -> str:
        """Text on the origin of the law's name."""
        return "stated in the scenario" if self.stated else "not stated"


def default_law(scenario: Scenario) -> DefaultLaw:
    """Default law of a scenario: the stated one, else kanayama."""
    stated = scenario.law is not None
    return DefaultLaw(law_name(scenario.law) if scenario.law else UNSTATED, stated)


def law_of(scenario: Scenario, law: str | None) -> str:
    """The law that a caller names, else the scenario's `default_law`."""
    return default_law(scenario).name if law is None else law


def judges_gains(scenario: Scenario, law: str, asked: bool) -> bool:
    """True if somebody chose the gains of ``law``, so that checks may object to them.

    That is the case if the user or the scenario names the law, or if it is the default law and its
    gains are stated.
    """
    own = default_law(scenario)
    return asked or (law == own.name and (own.stated or law in scenario.gains))
