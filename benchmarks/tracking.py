"""How well the laws track with the gains that ship: position RMS and worst case.

``python -m benchmarks.tracking [--quick] [--out benchmarks/results.md]``.  The guarded circle of
``safe-simulation`` at 10 and 20 ms, the guarded robot of ``safe-experiment`` at 50 and 100 ms, each
with the preset's own gains; then other references, a noisy pose, a noisy velocity.  RMS and largest
distance from the desired position over the last quarter: the median and the worst of all seeds.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from benchmarks.parts import page_parser, renew
from wmr_ctrl.api import simulate
from wmr_ctrl.control.laws.registry import NAMES
from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.results import position_rms
from wmr_ctrl.results.measures import position_max
from wmr_ctrl.world.scenario import load_scenario

SEEDS = range(7101, 7106)
PLACES = (("safe-simulation", 0.01), ("safe-simulation", 0.02), ("safe-experiment", 0.05),
          ("safe-experiment", 0.1))  # fmt: skip
"""Preset and control period [s]."""
CONDITIONS: tuple[tuple[str, dict[str, object]], ...] = (
    ("its circle", {}),
    ("lemniscate", {"reference.kind": "lemniscate"}),
    ("line", {"reference.kind": "line"}),
    ("pose noise 5 mm", {"sensor.pose_noise": 0.005}),
    ("velocity noise 20 mm/s, 20 mrad/s", {"sensor.velocity_noise": [0.02, 0.02]}),
)
NAME = "tracking"
"""Name of the page's part that this module writes."""


@dataclass(frozen=True)
class Cell:
    """Median RMS and worst distance [m], and how many runs ended early; None where refused."""

    rms: float
    worst: float
    lost: int

    @property
    def text(self) -> str:
        """RMS and worst distance [mm], with the number of lost runs."""
        lost = f" ({self.lost} lost)" if self.lost else ""
        return f"{1e3 * self.rms:.3g}, {1e3 * self.worst:.3g}{lost}"


def cell(preset: str, period: float, law: str, condition: dict[str, object]) -> Cell | None:
    """Figures of one law in one condition; None if the guard refuses it."""
    try:
        case = load_scenario(preset, {"clock.control": period, **condition})
        runs = [simulate(case, law, seed=seed) for seed in SEEDS]
    except ScenarioError as error:
        print(f"{preset}, {period:g} s, {law}, {condition}: {error}", flush=True)
        return None
    rms = [position_rms(run)["last_quarter"] for run in runs]
    most = [position_max(run) for run in runs]
    return Cell(
        float(np.median([np.inf if value is None else value for value in rms])),
        max(np.inf if value is None else value for value in most),
        sum(value is None for value in rms),
    )


def section(preset: str, period: float, laws: Sequence[str]) -> str:
    """A Markdown table of one preset at one period."""
    lines = [f"### {1e3 * period:g} ms, {preset}", "",
             f"| law | {' | '.join(title for title, _ in CONDITIONS)} |",
             "|---|" + "---|" * len(CONDITIONS)]  # fmt: skip
    for law in laws:
        cells = [cell(preset, period, law, condition) for _, condition in CONDITIONS]
        lines.append(f"| {law} | {' | '.join(c.text if c else 'refused' for c in cells)} |")
        print(lines[-1], flush=True)
    return "\n".join(lines)


def main(arguments: Sequence[str] | None = None) -> None:
    """Run all, print the tables, and with ``--out`` renew them."""
    given = page_parser(__doc__, "one period, one law").parse_args(arguments)
    places, laws = (PLACES[-1:], NAMES[-1:]) if given.quick else (PLACES, NAMES)
    made = "\n\n".join(section(preset, period, laws) for preset, period in places)
    if given.out:
        renew(given.out, NAME, made)


if __name__ == "__main__":
    main()
