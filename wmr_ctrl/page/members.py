"""Robots of the page: one for each law, or for a base that takes velocities one for each filter.

There what is to be seen is the filter: the same law asks for all of the limit, and its commands are
clipped, smoothed as is usual, or filtered in each way that the scenario's numbers admit.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from wmr_ctrl.control.setup import Setup, settle
from wmr_ctrl.errors import ScenarioError
from wmr_ctrl.filter.band import check_beat
from wmr_ctrl.filter.filter import worthwhile_slew
from wmr_ctrl.laws import LAWS
from wmr_ctrl.laws.velocity_loop import VelocityLoopGains
from wmr_ctrl.report.style import DASH_DOT, DASHED, DASHES, DOTTED, Dash, Look, look
from wmr_ctrl.scenario import Scenario, override
from wmr_ctrl.world.speed_loop import takes_velocity


@dataclass(frozen=True)
class PageMember:
    """A robot: its name, law, look, what is said of it, and what of the scenario it changes."""

    name: str
    law: str
    look: Look
    title: str
    overrides: Mapping[str, object] = field(default_factory=dict)

    def settled(self, scenario: Scenario) -> Setup:
        """Setup of this robot; raises as `settle` does."""
        return settle(override(scenario, self.overrides), self.law)


SENDING = ("pursuit",)
"""Laws that a page of a base that takes velocities has, unless others are named."""
UNLIMITED = 1e3
"""Rate of commands [m/s2, rad/s2] that nothing holds back."""
SLOW = 0.25
"""Slew that is shown where none is stated, as a share of that from which on it is worth nothing."""
SMOOTH = [2.5, 3.2]
"""Rates of Nav2's velocity smoother as it ships [m/s2, rad/s2]."""
WAYS: Mapping[str, tuple[str, str, Dash, str]] = {
    "clipped": ("at the limit", "#d6336c", "-", "commands clipped at the limit"),
    "smoothed": ("smoothed", "#e69f00", DASHED, "the usual smoother, then clipped at the limit"),
    "clip": ("filter, clip", "#1f77c9", DASH_DOT, "command filter, memoryless"),
    "slew": (
        "filter, slow clip",
        "#6b7a1e",
        DASHED,
        "command filter, of commands that change slowly",
    ),
    "governor": ("filter, governor", "#00956d", DOTTED, "command filter, from odometry"),
    "band": ("filter, band", "#5b0e3b", DASHED, "command filter, from what it sent"),
    "force": (
        "filter, band, force",
        "#8a5a2b",
        DASH_DOT,
        "command filter, within the motors' force",
    ),
}
"""Label, colour, dashes and title of each way to limit commands; several laws dash as laws."""


def members_of(scenario: Scenario, laws: Sequence[str]) -> tuple[PageMember, ...]:
    """Robots of a scenario's page for these laws; raises ScenarioError where none can drive."""
    if not takes_velocity(scenario):
        return tuple(PageMember(law, law, look(law), LAWS[law].title) for law in laws)
    several = len(laws) > 1
    members = []
    for number, law in enumerate(laws):
        for way, overrides in _ways(scenario, law):
            label, colour, dash, title = WAYS[way]
            if several:
                label, dash = f"{law}, {label}", DASHES[number % len(DASHES)]
            own = Look(label, colour, dash)
            members.append(PageMember(f"{law}-{way}", law, own, f"{law}: {title}", overrides))
    return tuple(members)


def _ways(scenario: Scenario, law: str) -> Iterator[tuple[str, Mapping[str, object]]]:
    """Ways to limit the commands of a law, with what each changes."""
    whole: dict[str, object] = {}
    if issubclass(LAWS[law].gains, VelocityLoopGains):
        whole = {f"gains.{law}.share": 1.0, f"gains.{law}.a_max": [UNLIMITED, UNLIMITED]}
    bare = {**whole, "filter.kind": "none", "filter.slew": None, "filter.force": None}
    yield "clipped", bare
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
            if way == _own_way(scenario):
                raise
            continue
        yield way, changes


def _own_way(scenario: Scenario) -> str:
    """The way that the scenario itself limits commands."""
    own = scenario.filter
    return "slew" if own.slew else "force" if own.force else own.kind


def _is_swinging(scenario: Scenario) -> bool:
    """Whether the filter knows how fast a loop swings that overshoots, and when commands come."""
    own = scenario.filter
    known = own.loop == "pi" or (own.loop == "second-order" and own.frequency is not None)
    return known and own.jitter < scenario.clock.control


def _filters(scenario: Scenario) -> Iterator[tuple[str, Mapping[str, object]]]:
    """Filters that the scenario's numbers are enough for, with what each changes."""
    own = scenario.filter
    yield "clip", {"filter.kind": "clip"}
    if own.slew:
        yield "slew", {"filter.kind": "clip", "filter.slew": own.slew}
    elif _is_swinging(scenario):
        slew = [float(f"{SLOW * most:.3g}") for most in worthwhile_slew(scenario)]
        yield "slew", {"filter.kind": "clip", "filter.slew": slew}
    yield "governor", {"filter.kind": "governor"}
    yield "band", {"filter.kind": "band"}
    if own.force:
        yield "force", {"filter.kind": "band", "filter.force": own.force}
