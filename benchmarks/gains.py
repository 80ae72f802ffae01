"""Which gains: the certified corridor beside torque change, untold delay and noise.

``python -m benchmarks.gains [--quick] [--work build/gains]``.  Gains of ``safe-simulation``: with
the k that laws share and with prox's own, that which ships, each with other bandwidths of the
observer, and what `wmr_ctrl.tune` finds for prox and for kanayama with merit = "corridor", with the
same trials and with all errors at once: prox from what the same search finds for the RMS, kanayama
from its defaults.  Then prox on ``safe-experiment``: poles of `guide`, slower and faster.  What a
search found stays in ``--work``.
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from benchmarks.parts import millimetres
from wmr_ctrl.api import simulate_many
from wmr_ctrl.control.given import scenario_of
from wmr_ctrl.control.laws.prox import Guide, guide
from wmr_ctrl.control.setup import settle
from wmr_ctrl.core.fields.units import rounded
from wmr_ctrl.results import RunTable
from wmr_ctrl.simulation.tuning import tune
from wmr_ctrl.theory.corridor import Corridor, find_corridor
from wmr_ctrl.world.scenario import Scenario, override

Fields = Mapping[str, object]
POSES: Fields = {"sensor.pose_noise": 5e-4}
VELOCITIES: Fields = {"sensor.velocity_noise": [2e-3, 5e-3]}
LATE: Fields = {"actuator.unmodelled_delay": 5e-3, "guard.enabled": False}
ALL: Fields = {**POSES, **VELOCITIES, **LATE}
ERRORS: Sequence[Fields] = ({}, POSES, VELOCITIES, LATE, ALL)
BRIEF: Fields = {"clock.duration": 20.0, "metrics.split": 10.0, "metrics.rms_from": 0.0}
"""Duration of a search's runs: the initial transient ends within 5 s."""


def sharing(wo: float) -> Fields:
    """Gains with the shared k, k1 = 16.8, and this wo; a search for the RMS found the others."""
    return {"gains.prox": {"rho": [42.9, 21.74], "wo": wo}}


FOUND = 2.301
"""Observer bandwidth wo [1/s] that a search for the RMS finds."""
SHARED, OWN = (FOUND, 5.0, 10.0, 20.0), (5.0, 13.0, 20.0)
"""Bandwidths of the observer, with the k that laws share and with prox's own."""
SEEDS, TRAIN, TEST = range(8), range(1, 3), range(7101, 7103)
TRIALS, WEIGHT, SPEED = 180, 5e-3, 0.2
"""Number of a search's sets of gains, its weight of torque change [m/(N m)], and v1_d [m/s]."""
EXACT: Fields = {"sensor.pose_period": 0.0, "sensor.pose_noise": 0.0, "sensor.correction": 1.0}
PACES = (1.5, 0.7)
"""Periods for which `guide` places poles, divided by the preset's period."""


def width(tube: Corridor) -> str:
    """Text with a corridor's width [mm], or that there is none."""
    return "none" if tube.position is None else millimetres(tube.position)


def runs_of(scenario: Scenario, law: str, seeds: Sequence[int], more: Fields) -> RunTable:
    """Figures of the runs of all seeds."""
    return simulate_many(override(scenario, more), law, seeds)


def row(words: str, scenario: Scenario, law: str, seeds: Sequence[int]) -> str:
    """Row for a set of gains on the robot without changes: corridors [mm] and figures of runs."""
    steady = override(scenario, {"changes": []})
    widths = [width(find_corridor(override(steady, more), law)) for more in ERRORS]
    exact, noisy = (
        runs_of(scenario, law, seeds, more)
        for more in ({"guard.enabled": True}, {**POSES, **VELOCITIES, "guard.enabled": True})
    )
    changes = [f"{table['torque_change_rms'].mean():.3f}" for table in (exact, noisy)]
    far = f"{1e3 * exact['position_max'].mean():.2f}"
    return f"| {words} | {' | '.join([*widths, *changes, far])} |"


def searched(law: str, work: Path, trials: int) -> Scenario:
    """Gains that a search finds with all errors at once."""
    path = work / f"{law}-{trials}.toml"
    if not path.exists():
        start = scenario_of("safe-simulation", {"changes": [], **sharing(FOUND), **ALL, **BRIEF})
        tune(start, law, path, seeds=TRAIN, test_seeds=TEST, trials=trials, weight=WEIGHT,
             merit="corridor")  # fmt: skip
    found = scenario_of(path).gains
    return scenario_of("safe-simulation", {"gains": found})


def told(scenario: Scenario, law: str) -> str:
    """Text with the gains of a law."""
    setup = settle(scenario, law)
    own = {"k": setup.kinematics.k, **vars(setup.gains)}
    names = {"prox": ("k", "rho", "wo"), "kanayama": ("k", "rate", "wo", "a_max")}[law]
    listed = [(name, np.atleast_1d(own[name])) for name in names]
    return "; ".join(f"{name} {', '.join(f'{x:.4g}' for x in values)}" for name, values in listed)


def first(work: Path, quick: bool) -> str:
    """The table of safe-simulation."""
    seeds, trials = (SEEDS[:2], 8) if quick else (SEEDS, TRIALS)
    ships = scenario_of("safe-simulation")
    sets = [override(ships, sharing(wo)) for wo in SHARED]
    sets += [override(ships, {"gains.prox.wo": wo}) for wo in OWN]
    rows = []
    for one in sets[-2:] if quick else sets:
        words = f"prox{', as it ships' if one == ships else ''}: {told(one, 'prox')}"
        rows.append(row(words, one, "prox", seeds))
        print(rows[-1], flush=True)
    rows.append(row("kanayama, as it ships", ships, "kanayama", seeds))
    print(rows[-1], flush=True)
    for law in ("prox",) if quick else ("prox", "kanayama"):
        found = searched(law, work, trials)
        rows.append(row(f"{law}, searched: {told(found, law)}", found, law, seeds))
        print(rows[-1], flush=True)
    head = ("gains", "corridor [mm]", "poses", "velocities", "delay", "all of them",
            "torque change [N m]", "with noise", "farthest in runs [mm]")  # fmt: skip
    return "\n".join([f"| {' | '.join(head)} |", "|---" * len(head) + "|", *rows])


def poles(gains: Guide) -> Fields:
    """Fields of a guide's gains."""
    own = {"gains.prox.rho": list(gains.rho), "gains.prox.wo": gains.wo}
    return {"gains.kinematics.k": list(gains.k), **own}


def second(quick: bool) -> str:
    """Table of safe-experiment: the share of its noise with a corridor, and figures of runs."""
    ships = scenario_of("safe-experiment")
    period = ships.clock.control
    sets: dict[str, Fields] = {f"as it ships, poles for {1e3 * period:g} ms": {}}
    for pace in PACES[:1] if quick else PACES:
        sets[f"poles for {1e3 * pace * period:g} ms"] = poles(guide(pace * period, 0.0, SPEED))
    rows = []
    for words, own in sets.items():
        scenario = override(ships, own)
        shares = [_share(find_corridor(override(scenario, more), "prox")) for more in ({}, EXACT)]
        table = simulate_many(scenario, "prox", SEEDS[:2] if quick else SEEDS)
        change, most = table["torque_change_rms"].mean(), 1e3 * table["position_max"].mean()
        rms = 1e3 * np.median(table["tracking_drive_rms"])
        rows.append(f"| {words} | {' | '.join(shares)} | {change:.2f} | {rms:.1f} | {most:.1f} |")
        print(rows[-1], flush=True)
    head = ("gains", "closes with", "closes with exact poses", "torque change [N m]",
            "RMS in runs [mm]", "farthest [mm]")  # fmt: skip
    return "\n".join([f"| {' | '.join(head)} |", "|---" * len(head) + "|", *rows])


def _share(tube: Corridor) -> str:
    """Share of pushes and errors for which there is a corridor."""
    share = 1.0 if tube.position is not None else tube.closes
    return "nothing" if share is None else f"{rounded(100 * share, 2, up=False)} %"


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the missing searches, and print both tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true", help="few gains, few trials")
    parser.add_argument("--work", type=Path, default=Path("build/gains"), help="what is kept")
    given = parser.parse_args(arguments)
    given.work.mkdir(parents=True, exist_ok=True)
    first(given.work, given.quick)
    second(given.quick)


if __name__ == "__main__":
    main()
