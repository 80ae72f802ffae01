"""Scenes of the page, a story or one scenario to play with, and their variants.

Numbers are parameters of a loop and change while it runs.  What decides the form of its graphs does
not: the law, the guard, how many commands are in flight.  A variant is a choice of those; it has a
loop for each law, and the numbers that the product derives for it, such as the guard's.
"""

import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from importlib.resources import files

from wmr_ctrl.control.setup import Setup, settle
from wmr_ctrl.control.structure import structure_of
from wmr_ctrl.errors import ScenarioError
from wmr_ctrl.fields.values import multiple
from wmr_ctrl.page.members import PageMember, members_of
from wmr_ctrl.scenario import Scenario, load_scenario, override
from wmr_ctrl.world.speed_loop import takes_velocity


@dataclass(frozen=True)
class PageScene:
    """A start of the page: its scenario, what is said about it, and which laws are shown first.

    ``speed``: simulated seconds in one of the clock.
    """

    key: str
    title: str
    text: str
    scenario: Scenario
    shown: tuple[str, ...]
    speed: float = 1.0


@dataclass(frozen=True)
class StoryStep:
    """A step of the story: a preset with overrides."""

    key: str
    title: str
    text: str
    preset: str
    shown: tuple[str, ...]
    overrides: Mapping[str, object] = field(default_factory=dict)


def story() -> tuple[StoryStep, ...]:
    """Steps of the story, from the file beside this one."""
    text = files("wmr_ctrl.page").joinpath("story.toml").read_text(encoding="utf-8")
    steps = tomllib.loads(text)["step"]
    return tuple(StoryStep(**{**step, "shown": tuple(step["shown"])}) for step in steps)


def scenes(scenario: Scenario, laws: tuple[str, ...]) -> tuple[PageScene, ...]:
    """The story for ``laws`` where a scenario is the one it begins with, else one scene of it."""
    steps = story()
    if scenario != load_scenario(steps[0].preset):
        most = MOST_WAYS if takes_velocity(scenario) else MOST_SHOWN
        shown = tuple(member.name for member in members_of(scenario, laws))[:most]
        return (PageScene("own", scenario.title or scenario.name, "", scenario, shown),)
    listed = []
    for step in steps:
        own = override(load_scenario(step.preset), step.overrides)
        shown = tuple(name for name in step.shown if name in laws) or laws[:2]
        listed.append(PageScene(step.key, step.title, step.text, own, shown))
    return tuple(listed)


MOST_SHOWN = 4
"""Robots that one scenario's page shows first."""
MOST_WAYS = 6
"""The same of a base that takes velocities: all filters beside clipped and smoothed commands."""
PERIODS = (0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1)
"""Control periods [s] that are offered where no part of the loop counts its steps."""
LATE = (0, 2, 5)
"""Delays of the drives that are offered, in control periods of the scenario."""


@dataclass(frozen=True)
class Variant:
    """One choice; period and delay [s]."""

    guard: bool
    period: float
    delay: float

    @property
    def overrides(self) -> Mapping[str, object]:
        """Fields that make it of a scenario."""
        return {
            "guard.enabled": self.guard,
            "clock.control": self.period,
            "actuator.delay": self.delay,
        }


@dataclass(frozen=True)
class SettledVariant:
    """A variant with the setup of each robot, or why the product refuses it."""

    variant: Variant
    setups: Mapping[str, Setup]
    refusal: str = ""


def settled_variants(scenario: Scenario, members: Sequence[PageMember]) -> Iterator[SettledVariant]:
    """All variants of a scenario, its own first; of a base that takes velocities that one alone.

    Raises as `settle` does where its own is refused.
    """
    own = Variant(scenario.guard.enabled, scenario.clock.control, scenario.actuator.delay)
    yield SettledVariant(own, {member.name: member.settled(scenario) for member in members})
    if takes_velocity(scenario):
        return
    for variant in _others(scenario, own, members[0].law):
        try:
            changed = override(scenario, variant.overrides)
            yield SettledVariant(variant, {item.name: item.settled(changed) for item in members})
        except ScenarioError as error:
            yield SettledVariant(variant, {}, str(error))


def _others(scenario: Scenario, own: Variant, law: str) -> Iterator[Variant]:
    delays = {own.delay, *(round(count * own.period, 12) for count in LATE)}
    places = [(period, own.delay) for period in _periods(scenario, own, law)]
    places += [(own.period, delay) for delay in sorted(delays - {own.delay})]
    variants = (Variant(guard, *place) for guard in (own.guard, not own.guard) for place in places)
    return (variant for variant in variants if variant != own)


def _periods(scenario: Scenario, own: Variant, law: str) -> tuple[float, ...]:
    """Periods that the scenario's loop may have: its own, and more if nothing counts its steps."""
    clock = scenario.clock
    fitting = [p for p in PERIODS if multiple(p, clock.plant) and multiple(clock.duration, p)]
    try:
        other = next(p for p in fitting if p != own.period)
        changed = override(scenario, {"clock.control": other, "guard.enabled": False})
        still = override(scenario, {"guard.enabled": False})
        same = structure_of(settle(changed, law)) == structure_of(settle(still, law))
    except (ScenarioError, StopIteration):
        same = False
    return tuple(sorted({own.period, *(fitting if same else ())}))
