"""Worth of a run's verdict: remarks against labels by a written rule on columns.

``python -m benchmarks.verdicts [--runs 310] [--out docs/verdicts.md]``.  Random scenarios over
laws, presets, periods, encoders, windows, lags, delays, noise, masses, torque limits and references
are run; an engineer's rule on the logged columns, `faults`, says which runs are bad, and the run's
own remarks say which of them are told.  The rule shares no code with the remarks.  Thresholds were
chosen on the runs of CHOSEN_ON; the table is of other runs.
"""

from __future__ import annotations

import argparse
import random
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.parts import renew
from wmr_ctrl.api import simulate
from wmr_ctrl.control.given import scenario_of
from wmr_ctrl.control.laws.registry import NAMES
from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.results import Run
from wmr_ctrl.world.scenario import Scenario

CHOSEN_ON, REPORTED_ON = (1_000_000, 2_000_000), 3_000_000
"""First number of the runs for choosing rule and thresholds, and of the reported runs."""
NAME = "verdicts"
"""Name of the page's part that this module writes."""
OF_SCENARIO = ("objected", "exact-pose", "assumption-void", "bounds-left")
"""Remarks about the scenario or the guarantee; all others are about the course of the run."""
PATHS = (
    [[0.0, 0.0], [2.0, 0.0], [3.0, 1.0], [3.0, 3.0], [1.0, 4.0]],
    [[0.0, 0.0], [1.5, 0.0], [1.5, 1.5], [3.0, 1.5]],
)


@dataclass(frozen=True)
class Trial:
    """A numbered run: its preset, law, seed and changes to the preset."""

    number: int
    preset: str
    law: str
    changed: Mapping[str, object]


def trial(number: int) -> Trial:
    """The run of that number, the same on every machine."""
    draw = random.Random(number)
    preset = draw.choice(("safe-simulation", "safe-experiment", "robot-10ms", "robot-100ms",
                          "paper-simulation-no-switch", "paper-experiment"))  # fmt: skip
    changed: dict[str, object] = {"changes": [], "clock.duration": draw.choice((30.0, 40.0, 60.0))}
    parts = (_clock, _robot, _sensors, _drives, _noise, _reference)
    for part in draw.sample(parts, draw.randint(1, 4)):
        changed |= part(draw)
    return Trial(number, preset, draw.choice(NAMES), changed)


def _clock(draw: random.Random) -> dict[str, object]:
    return {"clock.control": draw.choice((0.005, 0.01, 0.02, 0.05, 0.1))}


def _robot(draw: random.Random) -> dict[str, object]:
    """Random robot with a mass of a third to three times the believed one."""
    m, ratio = 50 * 4 ** draw.uniform(-0.5, 0.5), 3 ** draw.uniform(-1, 1)
    return {"robot.m": m, "robot.I": 0.108 * m, "model.m": m * ratio, "model.I": 0.108 * m * ratio}


def _sensors(draw: random.Random) -> dict[str, object]:
    if draw.random() < 0.5:
        return {"encoder.counts": 2 ** draw.randint(8, 14), "encoder.window": 0.0}
    return {"sensor.velocity_noise": [0.1 * draw.random() ** 3, 0.3 * draw.random() ** 3]}


def _drives(draw: random.Random) -> dict[str, object]:
    if draw.random() < 0.5:
        return {"actuator.lag": draw.choice((0.01, 0.03, 0.08))}
    if draw.random() < 0.5:
        return {"actuator.delay": draw.choice((0.005, 0.02, 0.05))}
    return {"actuator.tau_max": 20 * 10 ** draw.uniform(-1.2, 0)}


def _noise(draw: random.Random) -> dict[str, object]:
    return {
        "disturbance.std": 3 * draw.random() ** 2,
        "sensor.pose_noise": 0.05 * draw.random() ** 2,
    }


def _reference(draw: random.Random) -> dict[str, object]:
    kind = draw.choice(("lemniscate", "line", "rounded-square", "stop-and-go", "waypoints"))
    speed = draw.choice((0.1, 0.3, 0.6, 0.9))
    if kind == "lemniscate":
        return {"reference.kind": kind, "reference.rate": speed / 2.5}
    if kind != "waypoints":
        return {"reference.kind": kind, "reference.speed": speed}
    return {"reference.kind": kind, "reference.points": draw.choice(PATHS),
            "reference.speed": speed, "reference.tolerance": 0.2,
            "initial.pose": [0.0, -0.1, -1.5708]}  # fmt: skip


def faults(run: Run, scenario: Scenario) -> Iterator[str]:
    """Faults that an engineer finds in a run, from its columns and its scenario's numbers.

    Windows: a motion without end is judged over its last half, its position over the last quarter;
    a path that stops from half of its way in time until it arrives, and afterwards.
    """
    if run.monitor.violations or len(run.time) < run.settings.samples:
        yield "left the limit, or ended early"
        return
    c = {name: np.asarray(run[name]) for name in ("t", "x", "y", "x_d", "y_d", "v1", "omega",
         "v1_d", "v2_d", "v1_d_dot", "v2_d_dot", "tau_right", "tau_left", "noise_right",
         "noise_left")}  # fmt: skip
    t, end, goal = c["t"], scenario.clock.duration, scenario.reference.arrival
    drive = t >= end / 2 if goal is None else (t >= goal / 2) & (t < goal)
    late = t >= 0.75 * end if goal is None else drive
    if not drive.any():
        yield "not at its goal"
        return
    tau = np.stack((c["tau_right"], c["tau_left"]))
    away2 = (c["x"] - c["x_d"]) ** 2 + (c["y"] - c["y_d"]) ** 2
    if np.sqrt(away2[late].mean()) > scenario.metrics.tolerance:
        yield "position RMS above metrics.tolerance while driving"
    if goal is not None and (goal >= end or away2[-1] > scenario.metrics.tolerance**2):
        yield "not at its goal"
    r, l, m, inertia = (getattr(scenario.robot, name) for name in ("r", "l", "m", "I"))
    rolling = scenario.robot.mu * m * scenario.robot.g * np.tanh(c["v1_d"] / scenario.robot.v_s)
    thrust, moment = m * c["v1_d_dot"] + rolling, inertia * c["v2_d_dot"]
    needs = np.stack((r / 2 * (thrust + moment / l), r / 2 * (thrust - moment / l)))
    pushes = np.stack((c["noise_right"], c["noise_left"]))
    most = min(scenario.actuator.tau_max, 20.0 if run.law == "prox" else np.inf)
    still = np.zeros_like(drive) if goal is None else t >= goal
    usual = max(_rms(needs[:, drive]), _rms(pushes), 0.1 * most if np.isfinite(most) else 0.0)
    parts = [part for part in (drive, still) if part.any()]
    if max(_rms(np.diff(tau, axis=1)[:, part[1:]]) for part in parts) > usual:
        yield "torques change more from sample to sample than the motion needs in all"
    if max(_restless((tau - needs)[:, part], scenario.clock.control) for part in parts) > usual:
        yield "torques swing within 2 s by more than the motion needs in all"
    if (np.abs(tau).max(axis=0)[drive] > 0.999 * most).mean() > 0.2:
        yield "torques at their limit in a fifth of the samples"
    v1_limit, omega_limit = scenario.limits.v_u1
    for name, wanted, limit in (("v1", "v1_d", v1_limit), ("omega", "v2_d", omega_limit)):
        if _rms((c[name] - c[wanted])[drive]) > 0.2 * limit:
            yield f"{name} off by a fifth of its limit RMS"
    if np.abs(c["v1_d"]).max() > v1_limit or np.abs(c["v2_d"]).max() > omega_limit:
        yield "asked to exceed a limit"
    if run.guard and np.asarray(run["clip_active"])[late].mean(axis=0).max() > 0.3:
        yield "the guard drives in 30 % of the samples"
    if ((c["v1"] * c["v1_d"])[drive] < 0).mean() > 0.3:
        yield "drives backwards in 30 % of the samples"


def _restless(torques: np.ndarray, period: float) -> float:
    """RMS of torques (2, N) about their mean over 2 s [N m]."""
    slow = np.stack([_moving_mean(wheel, round(2 / period)) for wheel in torques])
    return _rms(torques - slow)


def _moving_mean(values: np.ndarray, count: int) -> np.ndarray:
    """Moving mean over ``count`` samples, over fewer at the ends."""
    weights = np.ones(min(count, len(values)))
    size = np.convolve(np.ones_like(values), weights, "same")
    return np.convolve(values, weights, "same") / size


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))


@dataclass(frozen=True)
class Judged:
    """A run's faults by the rule, and the keys of its remarks."""

    trial: Trial
    faults: tuple[str, ...]
    keys: tuple[str, ...]

    @property
    def seen(self) -> bool:
        """True if a remark says that the run went badly."""
        return any(key not in OF_SCENARIO for key in self.keys)


def judged(first: int, runs: int) -> Iterator[Judged]:
    """Judge ``runs`` runs from number ``first``; an impossible scenario is skipped."""
    number, made = first, 0
    while made < runs:
        one, number = trial(number), number + 1
        try:
            scenario = scenario_of(one.preset, one.changed)
            run = simulate(scenario, one.law, seed=one.number)
        except ScenarioError:
            continue
        made += 1
        yield Judged(one, tuple(faults(run, scenario)), tuple(item.key for item in run.remarks))


def table(rows: Sequence[Judged]) -> str:
    """Markdown tables: misses and false alarms, counts of each remark and of each fault."""
    bad, good = [row for row in rows if row.faults], [row for row in rows if not row.faults]
    unseen, untold = [row for row in bad if not row.seen], [row for row in bad if not row.keys]
    alarmed = [row for row in good if row.seen]
    noted = [row for row in good if row.keys and not row.seen]
    lines = [
        f"{len(rows)} runs, {len(bad)} bad and {len(good)} good by the rule.", "",
        "| | runs | share |", "|---|---|---|",
        f"| missed: bad, and no remark | {len(untold)} | {_share(untold, bad)} of the bad |",
        f"| of these and of those that only `check` reports | {len(unseen)} | "
        f"{_share(unseen, bad)} of the bad |",
        f"| false alarm: good, and a remark on how it went | {len(alarmed)} | "
        f"{_share(alarmed, good)} of the good |",
        f"| good, and a remark on scenario or guarantee alone | {len(noted)} | "
        f"{_share(noted, good)} of the good |", "",
        "| remark | of bad runs | of good runs |", "|---|---|---|",
    ]  # fmt: skip
    of_bad, of_good = (
        Counter(key for row in part for key in set(row.keys)) for part in (bad, good)
    )
    lines += [f"| `{k}` | {of_bad[k]} | {of_good[k]} |" for k in sorted({*of_bad, *of_good})]
    lines += ["", "| fault by the rule | runs |", "|---|---|"]
    lines += [f"| {text} | {count} |" for text, count in
              Counter(text for row in bad for text in row.faults).most_common()]  # fmt: skip
    return "\n".join(lines)


def _share(part: Sequence[Judged], whole: Sequence[Judged]) -> str:
    return f"{100 * len(part) / len(whole):.1f} %" if whole else "-"


def main(arguments: Sequence[str] | None = None) -> None:
    """Run all, print the tables, and with ``--out`` renew those on the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=310)
    parser.add_argument("--first", type=int, default=REPORTED_ON)
    parser.add_argument("--out", type=Path)
    parser.add_argument("--each", action="store_true", help="print every run that is misjudged")
    asked = parser.parse_args(arguments)
    rows = list[Judged]()
    for row in judged(asked.first, asked.runs):
        rows.append(row)
        if asked.each and (bool(row.faults) != bool(row.keys) or row.seen != bool(row.faults)):
            print(row, flush=True)
    text = table(rows)
    print(text)
    if asked.out:
        renew(asked.out, NAME, text)


if __name__ == "__main__":
    main()
