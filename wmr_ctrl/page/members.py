"""Robots of the page: one for each law, or for a base that takes velocities one for each filter.

There what is to be seen is the filter: the same law asks for all of the limit, and its commands are
clipped, smoothed as is usual, or filtered in each way that the scenario's numbers admit.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from wmr_ctrl.control.setup import Setup, settle
from wmr_ctrl.errors import ScenarioError
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
SMOOTH = [2.5, 3.2]
"""Rates of Nav2's velocity smoother as it ships [m/s2, rad/s2]."""
WAYS: Mapping[str, tuple[str, str, Dash, str]] = {
    "clipped": ("at the limit", "#d6336c", "-", "commands clipped at the limit"),
    "smoothed": ("smoothed", "#e69f00", DASHED, "the usual smoother, then clipped at the limit"),
    "clip": ("filter, clip", "#1f77c9", DASH_DOT, "command filter, memoryless"),
    "governor": ("filter, governor", "#00956d", DOTTED, "command filter, from odometry"),
    "band": ("filter, band", "#5b0e3b", DASHED, "command filter, from what it sent"),
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
    yield "clipped", {**whole, "filter.kind": "none"}
    if whole:
        yield "smoothed", {**whole, "filter.kind": "none", f"gains.{law}.a_max": SMOOTH}
    for kind in ("clip", "governor", "band"):
        changes = {**whole, "filter.kind": kind}
        try:
            settle(override(scenario, changes), law)
        except ScenarioError:
            if kind == scenario.filter.kind:
                raise
            continue
        yield kind, changes
