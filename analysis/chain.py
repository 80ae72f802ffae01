"""Chain from a promise to the claims behind it, as in docs/explanation/proved.md, and its picture.

Each link is a sentence and the entries of the ledger that prove it; verdicts are read from the
committed record, so that the picture cannot say more than it.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from functools import cache
from textwrap import fill

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import FancyBboxPatch

from wmr_ctrl.core.data import data
from wmr_ctrl.results.ledger import Entry, load
from wmr_ctrl.results.promises import Link, chain

COLOURS = {
    "PROVED": ("#2e7d32", "proved by machine"),
    "LEMMA": ("#00838f", "algebra, by machine"),
    "HAND": ("#b26a00", "argued by hand"),
    "TRUSTED": ("#6b6b6b", "trusted or stated"),
}
"""Colour and legend entry of each way in which a link may hold."""


@cache
def record() -> Mapping[str, Entry]:
    """Every entry of the committed ledger."""
    return load().by_id()


def verdicts(link: Link) -> dict[str, str]:
    """Verdict of each of a link's entries, by its id."""
    return {key: record()[key].verdict for key in link.ids(record())}


PROMISES = data("wmr_ctrl.results", "promises.toml")
CHAINS = {row["title"]: chain(name) for name, row in PROMISES.items() if "title" in row}
"""The two chains of the picture."""


def picture() -> Figure:
    """Draw both chains side by side, with the promise on top and each link's entries."""
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
    found = verdicts(link).values()
    return next((name for name in ("HAND", "PROVED", "LEMMA") if name in found), "TRUSTED")


def _box(axes: Axes, x: float, y: float, link: Link, *, first: bool) -> None:
    """Draw one link with its lower left corner at (x, y)."""
    counts = Counter(verdicts(link).values())
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
        named = [pattern for pattern in link.patterns if not pattern.startswith("-")]
        shown, more = ", ".join(named[:2]), " ..." if len(named) > 2 else ""
        axes.text(x + 1.4, y + 1.25, f"{told}: {shown}{more}", fontsize=6.2, color=colour,
                  va="center", family="monospace")  # fmt: skip
