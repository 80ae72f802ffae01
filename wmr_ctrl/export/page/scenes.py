"""Scenes of the page, a story or one scenario to try, their variants and their robots.

Numbers are parameters of a loop and change while it runs.  Structural choices do not: the law, the
guard, the number of commands in transit.  A variant is a combination of those; it has a loop for
each law, and the numbers that the product derives for it, such as the guard's.

There is a robot for each law, or for a base that takes velocities one for each filter.  Such pages
demonstrate the filter: one law requests the full limit, and its commands are clipped, smoothed as
usual, or filtered in each way that the scenario's numbers allow.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

from wmr_ctrl.control.filter.band import check_beat
from wmr_ctrl.control.filter.filter import worthwhile_slew
from wmr_ctrl.control.laws import LAWS
from wmr_ctrl.control.laws.velocity_loop import VelocityLoopGains
from wmr_ctrl.control.numbers import structure_of
from wmr_ctrl.control.setup import Setup, settle
from wmr_ctrl.core.data import data
from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.core.fields.values import multiple
from wmr_ctrl.report.style import DASHES, Look, look, look_of
from wmr_ctrl.world.scenario import Scenario, load_scenario, override, preset_titles, title_of

from .approach import approaching


@dataclass(frozen=True)
class PageMember:
    """A robot: its name, law, look, caption, and its overrides of the scenario.

    ``approaches``: whether its law is behind the rule of `approach`.
    """

    name: str
    law: str
    look: Look
    title: str
    overrides: Mapping[str, object] = field(default_factory=dict)
    approaches: bool = False

    def settled(self, scenario: Scenario) -> Setup:
        """Setup of this robot; raises as `settle` does."""
        own = override(scenario, self.overrides) if self.overrides else scenario
        setup = settle(own, self.law)
        return replace(setup, law=approaching(setup.control_law)) if self.approaches else setup


APPROACH = "approach"
UNLIMITED = 1e3
"""Rate of commands [m/s2, rad/s2] that nothing holds back."""
SLOW = 0.25
"""Slew that is shown where none is stated, as a share of that from which on it is worth nothing."""
SMOOTH = [2.5, 3.2]
"""Rates of Nav2's velocity smoother as it ships [m/s2, rad/s2]."""
WAYS = data(__package__, "ways.toml")
"""Look and title of each way to limit commands; several laws dash as laws."""


def stops(scenario: Scenario) -> bool:
    """True if a scenario's filter stops before obstacles, which the page then compares."""
    return bool(scenario.obstacles) and scenario.filter.free_error is not None


def members_of(scenario: Scenario, laws: Sequence[str]) -> tuple[PageMember, ...]:
    """Robots of a scenario's page for these laws; raises ScenarioError if none can drive."""
    if not scenario.takes_velocity:
        return tuple(PageMember(law, law, look(law), LAWS[law].title) for law in laws)
    several = len(laws) > 1
    members = []
    for number, law in enumerate(laws):
        for way, overrides in _ways(scenario, law):
            own, title = look_of(WAYS[way]), f"{law}: {WAYS[way]['title']}"
            if several:
                dash = DASHES[number % len(DASHES)]
                own = replace(own, label=f"{law}, {own.label}", dash=dash)
            members.append(PageMember(f"{law}-{way}", law, own, title, overrides, way == APPROACH))
    return tuple(members)


def _ways(scenario: Scenario, law: str) -> Iterator[tuple[str, Mapping[str, object]]]:
    """Ways to limit the commands of a law, with their overrides."""
    whole: dict[str, object] = {}
    if issubclass(LAWS[law].gains, VelocityLoopGains):
        whole = {f"gains.{law}.share": 1.0, f"gains.{law}.a_max": [UNLIMITED, UNLIMITED]}
    bare = {**whole, "filter.kind": "none", "filter.slew": None}
    yield "clipped", bare
    if stops(scenario):
        yield APPROACH, bare
        yield scenario.filter.kind, whole
        return
    if whole:
        yield "smoothed", {**bare, f"gains.{law}.a_max": SMOOTH}
    for way, own in _filters(scenario):
        changes = {**bare, **own}
        try:
            changed = override(scenario, changes)
            settle(changed, law)
            if changed.filter.kind == "band":
                check_beat(changed)
        except ScenarioError:
            own_filter = scenario.filter
            if way == ("slew" if own_filter.slew else own_filter.kind):  # the scenario's own way
                raise
            continue
        yield way, changes


def _is_swinging(scenario: Scenario) -> bool:
    """True if the filter has the numbers for a band: the loop's oscillation and the timing."""
    own = scenario.filter
    known = "second-order" not in own.loop or own.frequency is not None
    return "first-order" not in own.loop and known and own.jitter < scenario.clock.control


def _filters(scenario: Scenario) -> Iterator[tuple[str, Mapping[str, object]]]:
    """Filters that the scenario's numbers allow, with their overrides."""
    own = scenario.filter
    yield "clip", {"filter.kind": "clip"}
    if own.slew:
        yield "slew", {"filter.kind": "clip", "filter.slew": own.slew}
    elif _is_swinging(scenario):
        slew = [float(f"{SLOW * most:.3g}") for most in worthwhile_slew(scenario)]
        yield "slew", {"filter.kind": "clip", "filter.slew": slew}
    yield "governor", {"filter.kind": "governor"}
    yield "band", {"filter.kind": "band"}


@dataclass(frozen=True)
class PageScene:
    """A start of the page: its scenario, its text, and the laws shown first.

    ``speed``: simulated seconds per second.
    """

    key: str
    title: str
    text: str
    scenario: Scenario
    shown: tuple[str, ...]
    speed: float = 1.0


def story() -> tuple[PageScene, ...]:
    """Steps of the story, from the file beside this one: presets with overrides."""
    steps = []
    for step in data(__package__, "story.toml")["step"]:
        own = load_scenario(step.pop("preset"), step.pop("overrides", {}))
        steps.append(PageScene(scenario=own, **{**step, "shown": tuple(step["shown"])}))
    return tuple(steps)


def is_story(scenario: Scenario) -> bool:
    """True for the scenario that the story begins with."""
    return scenario == story()[0].scenario


def scenes(scenario: Scenario, laws: tuple[str, ...]) -> tuple[PageScene, ...]:
    """The story for ``laws`` if it begins with this scenario, else a single scene."""
    steps = story()
    if scenario != steps[0].scenario:
        most = MOST_WAYS if scenario.takes_velocity else MOST_SHOWN
        shown = tuple(member.name for member in members_of(scenario, laws))[:most]
        text = data(__package__, "story.toml")["stops"] if stops(scenario) else ""
        return (PageScene("own", _own_title(scenario), text, scenario, shown),)
    return tuple(
        replace(step, shown=tuple(name for name in step.shown if name in laws) or laws[:2])
        for step in steps
    )


def _own_title(scenario: Scenario) -> str:
    """A scenario's title, or its name if the title belongs to an unmodified preset."""
    title, name = title_of(scenario), scenario.name
    own = title == scenario.title or name in preset_titles()
    return title if own and title else name


MOST_SHOWN = 4
"""Robots that one scenario's page shows first."""
MOST_WAYS = 6
"""The same number for a base that takes velocities: all filters beside clipped and smoothed
commands."""
PERIODS = (0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1)
"""Control periods [s] that are offered where no part of the loop counts its steps."""
LATE = (0, 2, 5)
"""Delays of the drives that are offered, in control periods of the scenario."""


@dataclass(frozen=True)
class Variant:
    """One combination; period and delay [s]."""

    guard: bool
    period: float
    delay: float

    @property
    def overrides(self) -> Mapping[str, object]:
        """Overrides that make this variant from a scenario."""
        times = {"clock.control": self.period, "actuator.delay": self.delay}
        return {"guard.enabled": self.guard, **times}


@dataclass(frozen=True)
class SettledVariant:
    """A variant with the setup of each robot, or the reason for its refusal."""

    variant: Variant
    setups: Mapping[str, Setup]
    refusal: str = ""


def settled_variants(scenario: Scenario, members: Sequence[PageMember]) -> Iterator[SettledVariant]:
    """All variants of a scenario, its own first; on a base that takes velocities only that one.

    Raises as `settle` does if its own is refused.
    """
    own = Variant(scenario.guard.enabled, scenario.clock.control, scenario.actuator.delay)
    yield SettledVariant(own, {member.name: member.settled(scenario) for member in members})
    if scenario.takes_velocity:
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
    """Possible control periods of the scenario's loop: several, unless it counts its steps."""
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
