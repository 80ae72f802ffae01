"""The front: prox and kanayama, both tuned alike, position RMS against torque change.

``python -m benchmarks.front [--quick] [--out benchmarks/results.md] [--work FOLDER]``.  Control
periods of 10, 50 and 100 ms, without delay and with half a period, which both laws predict over.
Both start from the same poles (`wmr_ctrl.control.laws.prox.guide`), and `wmr_ctrl.tune` searches
for both with the same objective, seeds and number of trials.  What is told is on seeds, and on two
references, that the search has not seen.  What a search found stays in ``--work``, and a call that
was interrupted goes on from there.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.parts import page_parser, renew
from wmr_ctrl.control.given import scenario_of
from wmr_ctrl.control.laws.prox import guide
from wmr_ctrl.results import RunTable
from wmr_ctrl.simulation.tuning import judged, tune
from wmr_ctrl.theory.checks import stability
from wmr_ctrl.world.scenario import Scenario

LAWS = ("prox", "kanayama")
TRIALS, LONG, WEIGHT = 400, 800, 1e-3
"""Sets of gains tried; the number for 100 ms; cost of 1 N m of torque change [m]."""
SEEDS, TEST_SEEDS = range(1, 4), range(7101, 7106)
SPEED = 0.2
"""Speed of the training reference [m/s]."""
NAME = "front"
"""Name of the page's part that this module writes."""


@dataclass(frozen=True)
class Case:
    """Control period and delay of the drives [s]."""

    period: float
    delay: float

    @property
    def trials(self) -> int:
        """Number of sets of gains tried."""
        return LONG if self.period >= 0.1 else TRIALS

    def start(self, law: str) -> Scenario:
        """Initial scenario: the circle with the guide's poles; the guard is switched off."""
        gains = guide(self.period, self.delay, SPEED, predicted=True)
        rates = [rate / 2 for rate in gains.rho]
        own = {
            "prox": {"gains.prox.kinematics": list(gains.k), "gains.prox.rho": list(gains.rho)},
            "kanayama": {
                "gains.kanayama.k": [gains.k[0], gains.k[1], gains.k[2] / SPEED],
                "gains.kanayama.rate": rates,
            },
        }[law]
        return scenario_of(
            "safe-simulation",
            {
                "guard.enabled": False, "clock.control": self.period,
                "actuator.delay": self.delay, f"gains.{law}.delay": self.delay,
                f"gains.{law}.wo": gains.wo, **own,
            },
        )  # fmt: skip

    def tuned(self, law: str, work: Path, trials: int) -> Path:
        """File with the gains that a search found; the search runs if there is none."""
        name = f"{law}-{1e3 * self.period:g}ms-{1e3 * self.delay:g}ms-{trials}.toml"
        if not (work / name).exists():
            tune(self.start(law), law, work / name, seeds=SEEDS, test_seeds=TEST_SEEDS,
                 trials=trials, weight=WEIGHT)  # fmt: skip
        return work / name


CASES = tuple(Case(period, share * period) for period in (0.01, 0.05, 0.1) for share in (0.0, 0.5))


@dataclass(frozen=True)
class Place:
    """One law in one case: figures by reference and mass, and the masses it is stable for."""

    case: Case
    law: str
    figures: RunTable
    masses: tuple[float, float] | None

    def of(self, mass: float) -> RunTable:
        """Figures of all references for a ratio of true to believed mass."""
        return self.figures.where(mass=mass)

    @property
    def products(self) -> np.ndarray:
        """Position RMS times torque change [mm N m] with the scenario's robot, by reference."""
        own = self.of(1.0)
        return 1e3 * own["tracking_drive_rms"] * own["torque_change_rms"]


def places(case: Case, work: Path, trials: int) -> list[Place]:
    """Figures of both laws in a case."""
    found = []
    for law in LAWS:
        scenario = scenario_of(case.tuned(law, work, trials))
        figures = judged(scenario, law, TEST_SEEDS)
        found.append(Place(case, law, figures, stability(scenario, law).masses))
        print(case, law, figures.records(), found[-1].masses, flush=True)
    return found


def table(pairs: Sequence[Sequence[Place]]) -> str:
    """A Markdown table, two rows for each case."""
    kinds = pairs[0][0].of(1.0)["reference"]
    lines = [
        "| period, delay [ms] | law | "
        + " | ".join(f"{kind}: RMS [mm], change [N m]" for kind in kinds)
        + " | product, of prox to kanayama's | stable for M/M^ | worst RMS at 0.6, 1.6 [mm] |",
        "|---|---|" + "---|" * (len(kinds) + 3),
    ]
    for pair in pairs:
        ratios = pair[0].products / pair[1].products
        for place in pair:
            case = place.case
            cells = [f"{1e3 * case.period:g}, {1e3 * case.delay:g}", place.law]
            own = place.of(1.0)
            pairs_of = zip(1e3 * own["tracking_drive_rms"], own["torque_change_rms"], strict=True)
            cells += [f"{error:.3g}, {change:.3g}" for error, change in pairs_of]
            told = ", ".join(f"{ratio:.2f}" for ratio in ratios)
            cells.append(told if place.law == LAWS[0] else "")
            cells.append("none" if place.masses is None
                         else f"{place.masses[0]:.2f} to {place.masses[1]:.2f}")  # fmt: skip
            worst = (1e3 * place.of(m)["tracking_drive_rms"].max() for m in (0.6, 1.6))
            cells.append(", ".join(f"{error:.3g}" for error in worst))
            lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines)


def main(arguments: Sequence[str] | None = None) -> None:
    """Tune what is not tuned yet, judge all, print the table, and with ``--out`` renew it."""
    parser = page_parser(__doc__, "one case, few trials")
    parser.add_argument("--work", type=Path, default=Path("build/front"), help="what is kept")
    given = parser.parse_args(arguments)
    given.work.mkdir(parents=True, exist_ok=True)
    cases = CASES[-1:] if given.quick else CASES
    made = table([places(case, given.work, 16 if given.quick else case.trials) for case in cases])
    print(made)
    if given.out:
        renew(given.out, NAME, made)


if __name__ == "__main__":
    main()
