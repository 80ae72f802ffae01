"""How well `wmr-ctrl identify` judges itself: logs of many kinds of bases, half with faults.

    python -m benchmarks.identify                      # all kinds, some 20 minutes
    python -m benchmarks.identify --logs 2 --kind dead --kind first --json

The bases are those of benchmarks/own_axes.py, their kinds those of base_kinds.py.  Four numbers
are told, each with its bound:

- missed: share of the intervals called "determined" from which the truth is further than 1 % or
  1.5 ms (0.02);
- accused: share of good logs with an axis that is not "explained" or with a row left out (0.03);
- broken: logs whose written filter lets the base pass a limit, of the log or 1.5 times it (0);
- usable: by kind of good logs, the speed that the filter lets the base hold, over its limit; with
  --release FOLDER also over that of another release with the same limits (0.95).
"""

from __future__ import annotations

import argparse
import json
import math
import subprocess
import sys
import warnings
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import partial
from itertools import product
from pathlib import Path

import numpy as np

from benchmarks.base_kinds import GOOD, KINDS, first_seed
from benchmarks.hostile import driven
from benchmarks.own_axes import Drive, Truth, recorded
from wmr_ctrl import command_filter, identify
from wmr_ctrl.core.errors import WmrError
from wmr_ctrl.identification import BaseIdentification
from wmr_ctrl.world.scenario import Scenario, loads_scenario

NEAR, NEAR_SECONDS, TOLERATED = 0.01, 1.5e-3, 1.001


@dataclass
class Score:
    """Findings from one log: determined and missed intervals; largest speed over its limit."""

    kind: str
    seed: int = 0
    determined: int = 0
    missed: list[str] = field(default_factory=list)
    accused: bool = False
    refused: str = ""
    told: list[str] = field(default_factory=list)
    largest: float | None = None
    held: float | None = None
    largest_beyond: float | None = None
    limits: list[float] = field(default_factory=list)
    held_by_release: float | None = None


def truths(truth: Truth, axis: int, most: float) -> dict[str, set[float]]:
    """True values of an axis's parameters, by name; several if a parameter is not one number."""
    a = truth.axes[axis]
    then = truth.then[2] if truth.then and truth.then[1] == axis else 1.0
    gains = {a.gain * g * f for g, f in product((1.0, a.back), (1.0, then))}
    gains |= {g * (1 + a.curve * most) for g in gains}
    numbers = {
        "gain": gains, "delay": {truth.delay[axis]}, "accel": {a.accel}, "offset": {a.offset},
        "decel": {a.accel if a.decel is None else a.decel}, "dead": {a.dead}, "sat": {a.most},
        "back": {a.back}, "bias": {a.bias}, "curve": {a.curve}, "then": {then},
    }  # fmt: skip
    numbers |= (
        {"tau": {a.first}} if a.loop == "first-order" else {"wn": {a.first}, "zeta": {a.zeta}}
    )
    if truth.sensor:
        for name in ("wn", "zeta", "delay", "tau"):
            numbers.pop(name, None)
    return numbers


def missed(found: BaseIdentification, truth: Truth, drive: Drive) -> tuple[int, list[str]]:
    """Number of determined intervals, and those that miss the truth."""
    count, names = 0, []
    for key, item in found.parameters.items():
        axis, name = int(key[-1]) - 1, key[:-1]
        known = truths(truth, axis, drive.most[axis])
        if item.verdict != "determined" or (truth.sensor and name not in known):
            continue
        count += 1
        near = NEAR_SECONDS if name == "delay" else NEAR * abs(item.value)
        values = known.get(name, {math.nan}) if drive.scale[axis] == 1 else {math.nan}
        if not all(item.low - near <= x <= item.high + near for x in values):
            names.append(key)
    return count, names


def scored(kind: str, seed: int) -> Score:
    """Score of one log."""
    truth, drive = KINDS[kind](np.random.default_rng(seed))
    log = recorded(truth, drive, seed)
    score = Score(kind, seed)
    try:
        found = identify(log, base="velocity")
    except WmrError as error:
        score.refused = str(error)
        return score
    score.determined, score.missed = missed(found, truth, drive)
    shown = found.to_json()
    explained = {*dict(shown["explained"]).values()}
    score.told = sorted({f"{row['key']} {row['axis']}" for row in shown["diagnosis"]})
    score.accused = explained != {"explained"} or bool(shown.get("left_out"))
    scenario = loads_scenario(found.to_toml())
    score.limits = list(scenario.limits.v_u1)
    if scenario.filter.kind == "none":
        return score
    score.largest, score.held = behind_filter(scenario, truth)
    beyond = [float(f"{1.5 * x:.3g}") for x in score.limits]
    further = identify(log, base="velocity", overrides={"limits.v_u1": beyond}).scenario
    if further.filter.kind != "none":
        score.largest_beyond = behind_filter(further, truth)[0]
    return score


def behind_filter(scenario: Scenario, truth: Truth) -> tuple[float, float]:
    """Largest speed and final speed of the true base behind a written filter, over the limit."""
    fresh = partial(command_filter, scenario)
    return driven(fresh, scenario.limits.v_u1, scenario.clock.control, truth)


def ask_release(scores: Sequence[Score], folder: str) -> None:
    """Add the speeds that good bases hold behind filters of a release, with the same limits."""
    asked = [item for item in scores if item.kind in GOOD and item.limits]
    logs = [(item.kind, item.seed, item.limits) for item in asked]
    command = [sys.executable, str(Path(__file__).with_name("hostile.py")), folder]
    told = subprocess.run(command, input=json.dumps(logs), stdout=subprocess.PIPE, text=True,
                          check=True)  # fmt: skip
    for item, held in zip(asked, json.loads(told.stdout), strict=True):
        item.held_by_release = held


def over_release(scores: Sequence[Score]) -> dict[str, float]:
    """Usable speed against that of the release, kind by kind, of logs for which it has a filter."""
    ratios = {}
    for kind in GOOD:
        own = [item for item in scores if item.kind == kind and item.held_by_release is not None]
        if own:
            theirs = sum(item.held_by_release or 0.0 for item in own)
            ratios[kind] = sum(item.held or 0.0 for item in own) / max(theirs, 1e-9)
    return ratios


def summary(scores: Sequence[Score]) -> dict[str, object]:
    """The four figures, and the counts behind them."""
    good = [item for item in scores if item.kind in GOOD]
    determined = sum(item.determined for item in scores)
    wrong = [name for item in scores for name in item.missed]
    broken = [
        item for item in scores if max(item.largest or 0.0, item.largest_beyond or 0.0) > TOLERATED
    ]
    usable = {
        kind: float(np.mean(held))
        for kind in GOOD
        if (held := [item.held for item in good if item.kind == kind and item.held is not None])
    }
    return {
        "logs": len(scores), "determined": determined,
        "missed": len(wrong) / max(determined, 1),
        "accused": sum(item.accused or bool(item.refused) for item in good) / max(len(good), 1),
        "broken": len(broken), "driven": sum(item.largest is not None for item in scores),
        "usable": usable, "usable_over_release": over_release(scores),
    }  # fmt: skip


def table(scores: Sequence[Score]) -> str:
    """Table with one line for each kind."""
    head = ["kind", "logs", "determined", "missed", "accused", "refused", "off", "broken", "told"]
    rows = [head, ["---"] * len(head)]
    for kind in dict.fromkeys(item.kind for item in scores):
        own = [item for item in scores if item.kind == kind]
        told = sorted({name for item in own for name in item.told})
        broken = sum(max(i.largest or 0, i.largest_beyond or 0) > TOLERATED for i in own)
        cells = [len(own), sum(i.determined for i in own), sum(len(i.missed) for i in own)]
        cells += [sum(i.accused for i in own), sum(bool(i.refused) for i in own)]
        cells += [sum(i.largest is None for i in own), broken]
        rows.append([kind, *map(str, cells), ", ".join(told)])
    return "\n".join("| " + " | ".join(row) + " |" for row in rows)


def main(arguments: Sequence[str] | None = None) -> None:
    """Score logs of all kinds, and print the four numbers."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--logs", type=int, help="of each kind; default: 13 of good, 7 of bad ones")
    parser.add_argument("--kind", action="append", choices=[*KINDS], help="default: all")
    parser.add_argument("--release", help="folder of another release, to compare usable speeds")
    parser.add_argument("--json", action="store_true")
    given = parser.parse_args(arguments)
    warnings.simplefilter("ignore")
    scores = []
    for kind in given.kind or KINDS:
        count = given.logs or (13 if kind in GOOD else 7)
        for seed in range(first_seed(kind), first_seed(kind) + count):
            scores.append(scored(kind, seed))
            print(f"{kind} {seed}: {scores[-1]}", file=sys.stderr)
    if given.release:
        ask_release(scores, given.release)
    told = summary(scores)
    print(json.dumps(told, indent=2) if given.json else f"{table(scores)}\n{told}")


if __name__ == "__main__":
    main()
