"""From a promise to what holds it up: the chain of docs/explanation/proved.md, and its picture.

Each link is a sentence and the entries of the ledger that are that sentence; verdicts are read from
the committed record, so that the picture cannot say more than it.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from fnmatch import fnmatchcase
from functools import cache
from pathlib import Path
from textwrap import fill

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import FancyBboxPatch

RECORD = Path(__file__).resolve().parents[1] / "wmr_ctrl" / "results" / "ledger.json"
COLOURS = {
    "PROVED": ("#2e7d32", "proved by machine"),
    "LEMMA": ("#00838f", "algebra, by machine"),
    "HAND": ("#b26a00", "argued by hand"),
    "TRUSTED": ("#6b6b6b", "trusted or stated"),
}
"""Of each way in which a link may hold: its colour and its name in the legend."""


@dataclass(frozen=True)
class Link:
    """One link: what it says, and the entries (patterns; those behind a minus do not count)."""

    says: str
    patterns: tuple[str, ...] = ()

    def verdicts(self) -> dict[str, str]:
        """Verdict of each entry, by its id; raises LookupError for a pattern without any."""
        found: dict[str, str] = {}
        for pattern in self.patterns:
            matching = {id: v for id, v in record().items() if fnmatchcase(id, pattern.lstrip("-"))}
            if not matching:
                raise LookupError(f"no entry of the ledger is called {pattern}")
            if pattern.startswith("-"):
                found = {id: v for id, v in found.items() if id not in matching}
            else:
                found |= matching
        return found


@cache
def record() -> Mapping[str, str]:
    """Verdict of every entry of the committed ledger."""
    entries = json.loads(RECORD.read_text(encoding="utf-8"))["entries"]
    return {item["id"]: item["verdict"] for item in entries}


CHAINS: dict[str, tuple[Link, ...]] = {
    "The guard: wheel torques": (
        Link("The robot keeps its speed limit at every instant, whatever the law asks for."),
        Link("If mass, push, measurement error and lateness stay within the bounds you state."),
        Link(
            "From sample to sample, and at every instant between two samples.",
            ("guard.lemma", "guard.*.lemma", "guard.late.mean", "guard.late.lag",
             "guard.varying.lag", "-guard.delay.rounding.*"),
        ),
        Link(
            "One sample: from within the limit to within it, however late velocities and drives "
            "are.",
            ("guard.inside", "guard.*.inside"),
        ),
        Link(
            "There is always a force that does so.",
            ("guard.feasible", "guard.*.feasible", "guard.axes"),
        ),
        Link(
            "The wheels can deliver it within their torque limit.",
            ("guard.anchor", "guard.delay.anchor", "guard.late.anchor", "wheels.reach",
             "wheels.linear-first", "wheels.rotation-first"),
        ),
        Link(
            "The exported controller consists of exactly these formulas.",
            ("guard.assembled", "guard.assembled.*", "-guard.assembled.keeps"),
        ),
        Link(
            "Its output feasible = 1 means that every condition is met.",
            ("guard.promise", "guard.kept", "guard.delay.kept", "guard.assembled.keeps"),
        ),
        Link(
            "In double precision, to the last bit: without delay and behind a constant one alone.",
            ("guard.rounding", "guard.rounding.*", "-guard.rounding.single*",
             "guard.delay.rounding", "guard.delay.rounding.*"),
        ),
        Link("Compiler, C library and processor do what they should."),
    ),
    "The filter: (v, omega) commands": (
        Link("The base keeps its speed limit at every instant, whatever is commanded."),
        Link("If gain, time constant, push, delay and losses stay within the bounds you state."),
        Link(
            "From sample to sample, and at every instant between two samples.",
            ("filter.mean", "filter.induction"),
        ),
        Link(
            "One sample: from within the limit to within it.",
            ("filter.drive", "filter.inside", "filter.clip"),
        ),
        Link("Stopping is always allowed.", ("filter.contains-clip",)),
        Link("The bound on the speed holds for the next sample, too.", ("filter.estimate",)),
        Link(
            "The exported governor does all this; shown without delay and losses.",
            ("filter.sent", "filter.sent.*", "filter.assembled*",
             "filter.rims.*", "filter.carried"),
        ),
        Link(
            "Before a clip or a governor, the gate of the ROS 2 node sends only what these may.",
            ("gate.*",),
        ),
        Link(
            "Rounding stays below the 2^-26 of the limit that is reserved for it.",
            ("filter.rounding.*",),
        ),
        Link("Compiler, C library and processor do what they should."),
    ),
}  # fmt: skip


def picture() -> Figure:
    """Both chains side by side, the promise on top, each link with its entries."""
    figure = Figure(figsize=(7.4, 8.6), dpi=110)
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set_xlim(0, 100)
    axes.set_ylim(0, 116)
    axes.axis("off")
    for column, (title, links) in enumerate(CHAINS.items()):
        x = 2 + 49 * column
        axes.text(x, 112.6, title, fontsize=10, weight="bold", va="center")
        for row, link in enumerate(links):
            _box(axes, x, 101.2 - 10.2 * row, link, first=row == 0)
            if row:
                axes.annotate(
                    "", (x + 23, 108.9 - 10.2 * row + 1.7), (x + 23, 108.9 - 10.2 * row - 0.1),
                    arrowprops={"arrowstyle": "-|>", "color": "#444444", "lw": 1.2},
                )  # fmt: skip
    ways = {_way(link) for _, links in CHAINS.items() for link in links}
    for k, (colour, name) in enumerate(COLOURS[way] for way in COLOURS if way in ways):
        axes.add_patch(FancyBboxPatch((3 + 24 * k, 3.0), 2.2, 1.6, boxstyle="round,pad=0.2",
                                      fc=colour, ec="none"))  # fmt: skip
        axes.text(7 + 24 * k, 3.8, name, fontsize=8, va="center")
    return figure


def _way(link: Link) -> str:
    """The weakest way in which a part of a link holds."""
    verdicts = link.verdicts().values()
    return next((name for name in ("HAND", "PROVED", "LEMMA") if name in verdicts), "TRUSTED")


def _box(axes: Axes, x: float, y: float, link: Link, *, first: bool) -> None:
    """One link with its lower left corner at (x, y)."""
    counts = Counter(link.verdicts().values())
    colour = COLOURS[_way(link)][0]
    face, ink = ("#12365C", "white") if first else ("white", "#222222")
    axes.add_patch(
        FancyBboxPatch((x, y), 46, 7.4, boxstyle="round,pad=0.1,rounding_size=0.8", fc=face,
                       ec="#12365C" if first else colour, lw=1.4)
    )  # fmt: skip
    axes.text(x + 1.4, y + (4.8 if link.patterns else 3.7), fill(link.says, 54), fontsize=7.6,
              color=ink, va="center")  # fmt: skip
    if link.patterns:
        told = ", ".join(f"{n} {name}" for name, n in sorted(counts.items(), reverse=True))
        shown = ", ".join(link.patterns[:2]).replace("-guard", "without guard")
        more = " ..." if len(link.patterns) > 2 else ""
        axes.text(x + 1.4, y + 1.25, f"{told}: {shown}{more}", fontsize=6.2, color=colour,
                  va="center", family="monospace")  # fmt: skip
