"""The certified corridor against an adversary and against random runs.

``python -m benchmarks.corridor [--runs 8000] [--row 1] [--out PAGE]``: a table of
benchmarks/results.md. Each case is a preset with changes.  The adversary
(`benchmarks.corridor_adversary`) drives a loop that shares no code with the certificate, by the
worst signs for 8 directions at the bound and a fifth beyond it.  Random runs are native ones from
a start on the path, with pushes and errors drawn uniformly from within the bound.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from benchmarks.corridor_adversary import farthest
from benchmarks.corridor_attacks import farthest_displaced, farthest_misled, farthest_on_the_way
from benchmarks.gains import sharing
from benchmarks.parts import millimetres, renew
from wmr_ctrl.api import simulate_many
from wmr_ctrl.control.given import scenario_of
from wmr_ctrl.theory.corridor import find_corridor
from wmr_ctrl.world.references import sample
from wmr_ctrl.world.scenario import Scenario, override

NAME = "corridor"
"""Name of the page's part that this module writes."""
EXACT = {"sensor.pose_period": 0.0, "sensor.pose_noise": 0.0, "sensor.correction": 1.0}
NARROW = 1e-3
"""Truncation [standard deviations] that makes a Gaussian uniform to one part in 1e6."""
ENDS = (0.06, 0.08, 0.16, 0.5, 1.0)
"""Attacked ends among the samples for a heavier robot; the effect of its mass decays soon."""
LASTS = 10.0
"""Duration of a random run [s]."""


@dataclass(frozen=True)
class Case:
    """A row: a preset with changes, a law, and the control samples that an attack takes.

    ``kind``: what the adversary has, "push", errors of "pose" or "velocity", a place within
    `corridor.start` ("start"), pushes on a robot of the heaviest "mass" that counts, or pushes on
    the way of a whole "run", with its changes, of which ``samples`` are attacked.
    """

    words: str
    preset: str
    law: str
    samples: int
    changed: Mapping[str, object]
    kind: str = "push"

    @property
    def scenario(self) -> Scenario:
        """Scenario, without changes during the run except those that the case names."""
        return scenario_of(self.preset, {"changes": [], **self.changed})

    def robot(self, times: float = 1.0) -> Scenario:
        """Scenario of one robot; for "mass" the heaviest, ``times`` as heavy."""
        if self.kind != "mass":
            return self.scenario
        m, inertia = (times * most for most in self.scenario.guard.M_max or ())
        alone = {"robot.m": m, "robot.I": inertia, "corridor.cells": 0}
        return override(self.scenario, alone)


def _slow(period: float, wheel: float) -> dict[str, object]:
    return {**EXACT, "clock.control": period, "disturbance.std": wheel / 3}


HEAVY = {"robot.m": 65.0, "robot.I": 7.0, "model.m": 50.0, "model.I": 5.4, "model.mu": 0.08}
RUN = {"clock.control": 0.02, "clock.duration": 12.0}
EIGHT = {**RUN, "reference.kind": "lemniscate", "disturbance.std": 0.5}
HEAVIER = {**RUN, "changes": [{"t": 4.0, "m": 65.0, "I": 7.0, "mu": 0.15}]}
BELIEVED = {key: HEAVY[key] for key in ("model.m", "model.I", "model.mu")}
MASSES = {
    **BELIEVED, "robot.m": 62.5, "robot.I": 6.5, "guard.M_min": [60.0, 6.0],
    "guard.M_max": [65.0, 7.0], "corridor.cells": 4, "disturbance.std": 0.05,
}  # fmt: skip
FILTERED = {"guard.enabled": False, "disturbance.std": 0.06, "sensor.pose_noise": 0.0}
QUICK = {
    "gains.kinematics.k": [12.0, 196.0, 5.0], "gains.prox": {"rho": [24.0, 16.0], "wo": 12.0},
}  # fmt: skip
CALM = {"disturbance.std": 0.0, "guard.enabled": False}
CASES = (
    Case("safe-simulation, prox, 10 ms", "safe-simulation", "prox", 500, {}),
    Case("the same, 65 kg where 50 are believed", "safe-simulation", "prox", 500, HEAVY),
    Case("the same, k1 = 16.8, rho = (42.9, 21.74), wo = 2.301", "safe-simulation", "prox", 500,
         sharing(2.301)),
    Case("safe-simulation, prox, 20 ms", "safe-simulation", "prox", 250, {"clock.control": 0.02}),
    Case("safe-simulation, kanayama, 10 ms", "safe-simulation", "kanayama", 700, {}),
    Case("safe-simulation, mb, 10 ms", "safe-simulation", "mb", 500, {}),
    Case("safe-experiment, exact pose, 50 ms, 1 N m", "safe-experiment", "prox", 150,
         _slow(0.05, 1.0)),
    Case("safe-experiment, exact pose, 100 ms, 1 N m", "safe-experiment", "prox", 100,
         _slow(0.1, 1.0)),
    Case("the same, 50 ms, 3 N m, k = (12, 196, 5), rho = (24, 16), wo = 12", "safe-experiment",
         "prox", 150, {**_slow(0.05, 3.0), **QUICK}),
    Case("safe-simulation, prox, 10 ms, no push, poses off by 1 mm an axis", "safe-simulation",
         "prox", 500, {**CALM, "sensor.pose_noise": 1e-3}, "pose"),
    Case("the same, velocities off by 2 mm/s and 5 mrad/s", "safe-simulation", "prox", 500,
         {**CALM, "sensor.velocity_noise": [2e-3, 5e-3]}, "velocity"),
    Case("safe-experiment, poses corrected in part, exact, 100 ms, 0.18 N m", "safe-experiment",
         "prox", 100, FILTERED),
    Case("the same, no push, poses off by 1 mm an axis", "safe-experiment", "prox", 100,
         {**FILTERED, "disturbance.std": 0.0, "sensor.pose_noise": 1e-3}, "pose"),
    Case("safe-simulation, prox, 10 ms, 0.15 N m, masses of 60 to 65 kg where 50 are believed",
         "safe-simulation", "prox", 200, MASSES, "mass"),
    Case("safe-simulation, prox, 10 ms, no push, starts within 1 mm, 1 mm and 0.005 rad",
         "safe-simulation", "prox", 100,
         {"disturbance.std": 0.0, "corridor.start": [1e-3, 1e-3, 5e-3]}, "start"),
    Case("safe-simulation, prox, 20 ms, whole run on a figure of eight, 1.5 N m, where it is "
         "slowest", "safe-simulation", "prox", 512, EIGHT, "run"),
    Case("the same, where it turns fastest", "safe-simulation", "prox", 160, EIGHT, "run"),
    Case("safe-simulation, prox, 20 ms, whole run in which 15 kg are added at 4 s, just after",
         "safe-simulation", "prox", 209, HEAVIER, "run"),
)  # fmt: skip


def on_the_path(scenario: Scenario) -> list[float]:
    """Pose and velocity (5) of the reference at t = 0."""
    row: list[float] = sample(scenario, [0.0])[0, :5].tolist()
    return row


def random_runs(case: Case, runs: int) -> float:
    """Largest distance [m] from the place on the path in the last quarter of random runs."""
    scenario = case.robot()
    noise = scenario.disturbance
    lasts = scenario.clock.duration if case.kind == "run" else LASTS
    uniform = {
        "disturbance.std": noise.std * noise.truncate / NARROW,
        "disturbance.truncate": NARROW,
        "clock.duration": lasts,
        "metrics.rms_from": 0.0,
        "metrics.split": lasts / 2,
    }
    start = on_the_path(scenario)
    table = simulate_many(
        scenario, case.law, range(runs), uniform, starts=[start] * runs,
    )  # fmt: skip
    return float(table["position_max"].max())


def reached(case: Case, push: float, times: float) -> float:
    """Distance [m] that the adversary reaches with bounds that are ``times`` as large."""
    if case.kind == "push":
        return farthest(case.scenario, case.law, case.samples, push, times).position
    if case.kind == "mass":
        robot, ends = case.robot(times), (round(share * case.samples) for share in ENDS)
        return max(farthest(robot, case.law, end, push).position for end in ends)
    if case.kind == "run":
        size = times * push
        return farthest_on_the_way(case.scenario, case.law, case.samples, size).position
    if case.kind == "start":
        return farthest_displaced(case.scenario, case.law, case.samples, times).position
    return farthest_misled(case.scenario, case.law, case.samples, case.kind, times).position


def row(case: Case, runs: int) -> str:
    """One line of the table, in millimetres."""
    scenario = case.scenario
    size = scenario.disturbance.std * scenario.disturbance.truncate
    tube = find_corridor(scenario, case.law, whole=case.kind == "run")
    tube = tube.whole or tube
    first, beyond = (reached(case, size, times) for times in (1.0, 1.2))
    random = 0.0 if case.kind == "start" else random_runs(case, runs)
    certified, ratio = "none", "-"
    if tube.position is not None:
        certified, ratio = millimetres(tube.position), f"{tube.position / first:.2f}"
        if max(first, random) > tube.position:
            raise SystemExit(f"{case.words}: a run left the corridor")
    else:
        ratio = f"closes up to {size * (tube.closes or math.nan):.2g} N m"
    shown = f"{1e3 * random:.2f}" if random else "-"
    left = "yes" if tube.position is not None and beyond > tube.position else "no"
    return (
        f"| {case.words} | {certified} | {1e3 * first:.2f} | {ratio} | {1e3 * beyond:.2f} | "
        f"{left} | {shown} |"
    )


def table(runs: int) -> str:
    """Whole table, and a sentence about its runs."""
    rows = []
    for case in CASES:
        rows.append(row(case, runs))
        print(rows[-1], flush=True)
    head = "| case (mm) | certified | adversary | ratio | a fifth beyond | leaves | random |"
    return "\n".join([
        head, "|---|---|---|---|---|---|---|", *rows, "",
        f"The adversary took {16 * (len(CASES) + len(ENDS) - 1)} runs, random pushes and errors "
        f"took {runs * sum(case.kind != 'start' for case in CASES)} of {LASTS:g} or 12 s, judged "
        "on their last quarter. None left its corridor except those a fifth beyond the bound, "
        "where it says so.",
    ])  # fmt: skip


def main() -> None:
    """Print the table, or put it into a page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=8_000, help="random runs of each case")
    parser.add_argument("--out", type=Path, help="page whose part is renewed")
    parser.add_argument("--row", type=int, help="only this row, from 1")
    given = parser.parse_args()
    if given.row:
        print(row(CASES[given.row - 1], given.runs))
        return
    text = table(given.runs)
    if given.out:
        renew(given.out, NAME, text)


if __name__ == "__main__":
    main()
