"""Starts from which limits act: from how far off there is a corridor, and what that costs.

``python -m benchmarks.starts [--quick] [--out docs/corridor.md]``.  prox on ``safe-simulation``
until the robot changes, as it ships, and with the k that laws share there.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from time import process_time

from benchmarks.parts import page_parser, renew
from wmr_ctrl.api import scenario_of
from wmr_ctrl.corridor import find_corridor
from wmr_ctrl.corridor.clearance import length, rounded

NAME = "starts"
"""Of the part of the page that this writes."""
Start = tuple[float, float, float]
SHIPS: Sequence[Start] = (
    (0.003, 0.003, 0.02), (0.005, 0.005, 0.02), (0.01, 0.01, 0.05), (0.02, 0.02, 0.075),
    (0.025, 0.025, 0.075), (0.03, 0.03, 0.075), (0.015, 0.04, 0.1), (0.02, 0.04, 0.1),
    (0.05, 0.01, 0.05), (0.01, 0.05, 0.15), (0.05, 0.025, 0.075), (0.05, 0.025, 0.1),
    (0.05, 0.02, 0.15), (0.02, 0.05, 0.15), (0.05, 0.05, 0.15),
)  # fmt: skip
"""Ahead, aside, turned [m, m, rad]."""


def sharing(wo: float) -> Mapping[str, object]:
    """Gains for the k that laws share, k1 = 16.8: what a search for the RMS finds, but for wo."""
    return {"gains.prox": {"rho": [42.9, 21.74], "wo": wo}}


OTHERS: Mapping[str, tuple[Mapping[str, object], Sequence[Start]]] = {
    "k1 = 16.8, wo = 10": (
        sharing(10.0),
        ((0.01, 0.01, 0.05), (0.02, 0.02, 0.075), (0.03, 0.03, 0.075), (0.05, 0.025, 0.1),
         (0.05, 0.02, 0.15)),
    ),
    "k1 = 16.8, wo = 2.301": (
        sharing(2.301),
        ((0.03, 0.03, 0.075), (0.01, 0.05, 0.15), (0.05, 0.03, 0.1)),
    ),
}  # fmt: skip
"""Other gains in words, and starts from which they are looked at."""


def row(start: Start, name: str = "", more: Mapping[str, object] | None = None) -> str:
    """A start: what the corridor of prox takes and is, with ``more`` fields of such a name."""
    begun = process_time()
    told = {"corridor.start": start, **(more or {})}
    tube = find_corridor(scenario_of("safe-simulation", told), "prox")
    spent = process_time() - begun
    ahead, aside = (f"{1e3 * x:g} mm" for x in start[:2])
    words = f"{ahead}, {aside}, {start[2]:g} rad{f', {name}' if name else ''}"
    if tube.position is None or tube.heading is None:
        return f"| {words} | {spent:.1f} s | none: {tube.refused} | | |"
    acts = f"{tube.settling:g} s" if tube.settling else "never"
    within = f"{length(tube.position)} | {rounded(tube.heading, 2)} rad"
    return f"| {words} | {spent:.2g} s | {acts} | {within} |"


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the table, and with ``--out`` renew it."""
    given = page_parser(__doc__, "the nearest two starts").parse_args(arguments)
    every = [(item, "", dict[str, object]()) for item in SHIPS]
    every += [(item, name, dict(more)) for name, (more, own) in OTHERS.items() for item in own]
    head = ("start: ahead, aside, turned", "CPU time", "limits may act for", "within", "turned")
    rows = [f"| {' | '.join(head)} |", "|---" * len(head) + "|"]
    for item in every[:2] if given.quick else every:
        rows.append(row(*item))
        print(rows[-1], flush=True)
    if given.out:
        renew(given.out, NAME, "\n".join(rows))


if __name__ == "__main__":
    main()
