"""Match on bases that take velocities: laws and filters with the same knowledge.

``python -m benchmarks.velocity_match [--quick] [--out docs/match.md]``. Each law gets BUDGET sets
of gains, drawn in the same way around its own start, on a training base; then every column on bases
that no contender knows.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from benchmarks.parts import page_parser, renew
from wmr_ctrl.api import simulate
from wmr_ctrl.control.laws import LAWS
from wmr_ctrl.control.laws.prox import guide
from wmr_ctrl.control.setup import Setup, settle
from wmr_ctrl.results import Run, percent, position_rms
from wmr_ctrl.simulation.tuning.search import tunable
from wmr_ctrl.world.scenario import load_scenario, override

NAME = "velocity"
"""Name of the page's part that this module writes."""
PLAYERS = ("kanayama", "pursuit", "prox", "mb")
BUDGET, SPREAD = 12, 0.5
LIMIT = (1.0, 2.0)
SPEED = 0.5
"""Speed of the reference [m/s]."""
LATE = 0.02
"""Delay of commands [s]."""
START = guide(0.05, LATE + 0.1, SPEED)
"""Initial poles of all laws, for the period, the delay and half of the base's time constant."""
TRAIN, TEST = 1, 7101
Changes = Mapping[str, Any]

SHARED: Changes = {
    "changes": [],
    "clock": {"control": 0.05, "duration": 30.0},
    "limits": {"v_u1": list(LIMIT), "v_u2": [0.9, 1.8]},
    "reference.rate": SPEED / 2.0,
    "robot.mu": 0.0,
    "sensor.pose_noise": 0.005,
    "gains.kinematics.k": list(START.k),
    "gains.prox": {"rho": list(START.rho), "wo": START.wo},
    "gains.mb.rho": list(START.rho),
    "gains.kanayama.k": [START.k[0], START.k[1], 2 * START.k[1] ** 0.5],
}


@dataclass(frozen=True)
class Place:
    """Base: its true numbers, the bounds given to filters, and the worst base within these."""

    title: str
    base: Changes
    told: Changes
    ways: tuple[str, ...]
    worst: tuple[Changes, ...]


FIRST_ORDER = Place(
    "a first-order base, 20 ms late",
    {"base": {"kind": "velocity", "tau": [0.22, 0.28], "tau_believed": [0.25, 0.25],
              "gain": [1.05, 0.95], "delay": LATE}, "disturbance.push": [5.0, 0.5]},
    {"tau": [0.2, 0.3], "gain": [0.9, 1.1], "d": [0.04, 0.05], "odometry": [0.0, 0.0],
     "delay": [0.0, 0.03]},
    ("none", "clip", "governor"),
    tuple(
        {"base.gain": [gain] * 2, "base.tau": [tau] * 2, "disturbance.push": [6.0, 0.8]}
        for gain, tau in itertools.product((0.9, 1.1), (0.2, 0.3))
    ),
)  # fmt: skip
OVERSHOOTING = Place(
    "a PI base that overshoots",
    {"base": {"kind": "velocity", "loop": "pi", "kp": 150.0, "ki": 300.0,
              "tau_believed": [0.25, 0.25]}, "robot.m": 60.0, "robot.I": 5.0},
    {"loop": "pi", "mass": [50.0, 65.0], "inertia": [4.0, 6.0], "kp": [140.0, 160.0],
     "ki": [280.0, 320.0]},
    ("none", "clip", "band"),
    tuple(
        {"base.kp": kp, "base.ki": ki, "robot.m": m, "robot.I": inertia}
        for (m, inertia), kp, ki in itertools.product(
            ((50.0, 4.0), (65.0, 6.0)), (140.0, 160.0), (280.0, 320.0)
        )
    ),
)  # fmt: skip
PLACES = (FIRST_ORDER, OVERSHOOTING)
STARTS = ([-5.0, -5.0, -0.7], [3.0, -4.0, 2.0], [0.0, 6.0, -2.5])


@dataclass(frozen=True)
class Result:
    """Worst |v| over its limit less 1, usable speed [m/s], RMS [m], change of the command [m/s]."""

    law: str
    way: str
    excess: float
    speed: float
    position: float
    change: float


def play(place: Place, law: str, way: str, budget: int = BUDGET) -> Result:
    """Tune on the training base, then fill every column on the other bases."""
    filtering = {} if way == "none" else {"filter": {**place.told, "kind": way}}
    case = override(load_scenario("paper-simulation-noise-free"), {**SHARED, **place.base})
    case = override(case, filtering)

    def run(changes: Changes, seed: int = TEST) -> Run:
        return simulate(override(case, changes), law, seed=seed)

    def tracked(gains: Changes, seed: int) -> tuple[float, float]:
        found = run({**gains, "initial.pose": [-0.5, -0.5, -0.7]}, seed)
        return _rms(found), _change(found)

    def cost(gains: Changes) -> float:
        position, change = tracked(gains, TRAIN)
        return float(np.hypot(position, 0.1 * change))

    best = min(_drawn(settle(case, law), law, budget), key=cost)
    position, change = tracked(best, TEST)
    tops = []
    for worst, start in itertools.product(place.worst, STARTS):
        found = run({**best, **worst, "clock.duration": 12.0, "initial.pose": start})
        tops += [top / limit for top, limit in zip(found.monitor.max_abs_v, LIMIT, strict=True)]
    line = {"reference.kind": "line", "reference.speed": 2.0, "initial.pose": [0.0, 0.0, -1.5]}
    fast = run({**best, **line, "clock.duration": 20.0})
    speed = float(np.mean(fast["v1"][len(fast["v1"]) // 2 :]))
    return Result(law, way, max(tops) - 1, speed, position, change)


def _rms(run: Run) -> float:
    found = position_rms(run)["last_quarter"]
    return np.inf if found is None else float(found)


def _change(run: Run) -> float:
    """RMS of the command's change from sample to sample, in the last quarter [m/s]."""
    sent = run["v_command"][3 * run.rows // 4 :]
    return float(np.sqrt(np.mean(np.diff(sent) ** 2)))


def _drawn(setup: Setup, law: str, count: int) -> list[Changes]:
    """Default gains, and random ones around them."""
    draw = np.random.default_rng(0)
    start = {key: setup.value(key) for key in tunable(LAWS[law])}
    found = []
    for spread in (0.0, *[SPREAD] * (count - 1)):
        own = {
            key: [float(x * np.exp(draw.normal(0.0, 1.0) * spread)) for x in value]
            for key, value in start.items()
        }
        found.append({key: value if len(value) > 1 else value[0] for key, value in own.items()})
    return found


def table(place: Place, results: Sequence[Result]) -> str:
    """Markdown table of one base; the best figure of a column is bold."""
    lines = [
        f"### {place.title[0].upper()}{place.title[1:]}", "",
        "| law | filter | worst \\|v\\| beyond its limit | usable speed [m/s] | position RMS [mm] "
        "| change of v's command [mm/s] |", "|---|---|---|---|---|---|",
    ]  # fmt: skip
    rows = [(r.speed, -1e3 * r.position, -1e3 * r.change) for r in results]
    best = np.argmax(rows, axis=0)
    for k, result in enumerate(results):
        kept = "none" if result.excess <= 1e-9 else percent(result.excess)
        cells = [f"{abs(value):.3g}" for value in rows[k]]
        shown = [f"**{c}**" if best[i] == k else c for i, c in enumerate(cells)]
        lines.append(f"| {result.law} | {result.way} | {kept} | {' | '.join(shown)} |")
    return "\n".join(lines)


def main(arguments: Sequence[str] | None = None) -> None:
    """Play all, print the tables, and with ``--out`` renew their part of the page."""
    given = page_parser(__doc__, "one law, one set of gains").parse_args(arguments)
    players, budget = (PLAYERS[:1], 1) if given.quick else (PLAYERS, BUDGET)
    parts = []
    for place in PLACES:
        results = []
        for law, way in itertools.product(players, place.ways):
            results.append(play(place, law, way, budget))
            print(results[-1], flush=True)
        parts.append(table(place, results))
    made = "\n\n".join(parts)
    print(made)
    if given.out:
        renew(given.out, NAME, made)


if __name__ == "__main__":
    main()
