"""How well `wmr-ctrl identify` judges itself: logs of many kinds of bases, half with faults.

    python -m benchmarks.identify                      # all kinds, some 20 minutes
    python -m benchmarks.identify --logs 2 --kind dead --kind first --json

The bases are those of benchmarks/own_axes.py.  Four numbers are told, each with its bound:

- missed: share of the intervals called "determined" from which the truth is further than 1 % or
  1.5 ms (0.02);
- accused: share of good logs with an axis that is not "explained" or with a row left out (0.03);
- broken: logs whose written filter lets the base pass a limit, of the log or 1.5 times it (0);
- usable: by kind of good logs, the speed that the filter lets the base hold, over its limit.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import product

import numpy as np

from benchmarks.own_axes import NONE, STEP, Axis, Base, Drive, Truth, recorded
from wmr_ctrl import command_filter, identify
from wmr_ctrl.core.errors import WmrError
from wmr_ctrl.identification import BaseIdentification
from wmr_ctrl.world.scenario import Scenario, loads_scenario

Drawn = tuple[Truth, Drive]
SEEDS, LATER_SEEDS = 100, 5000
"""First seed of a kind, and of every third one."""
HOSTILE, SECONDS = ("constant", "flips", "random"), 6.0
NEAR, NEAR_SECONDS, TOLERATED = 0.01, 1.5e-3, 1.001


def first(r: np.random.Generator, loop: str = "first-order") -> Drawn:
    """A base that a scenario can say, with draws of every number."""
    low, high = (0.06, 0.3) if loop == "first-order" else (5.0, 13.0)
    gains = (1.0, 1.0) if loop == "pi" else r.uniform(0.7, 1.2, 2)
    axes = [Axis(loop, float(g), first=float(r.uniform(low, high)), zeta=float(r.uniform(0.45, 1)))
            for g in gains]  # fmt: skip
    late = round(float(r.uniform(0.01, 0.12)), 3)
    v, omega = float(r.uniform(0.3, 1.0)), float(r.uniform(0.6, 1.5))
    noise = float(10 ** r.uniform(-2.8, -2)) * np.array([v, omega])
    drive = Drive(float(r.choice([40.0, 60.0])), float(r.choice([0.01, 0.02, 0.04])),
                  most=(v, omega), noise=(noise[0], noise[1]))  # fmt: skip
    return Truth((axes[0], axes[1]), (late, late)), drive


def of(truth: Mapping[str, object] = {}, **drive: object) -> Callable[[np.random.Generator], Drawn]:
    """A kind with other numbers of the base or of the drive."""

    def drawn(r: np.random.Generator) -> Drawn:
        base, way = first(r)
        return replace(base, **truth), replace(way, **drive)

    return drawn


def both(
    numbers: Callable[[np.random.Generator, float], Mapping[str, float]], seconds: float = 60.0
) -> Callable[[np.random.Generator], Drawn]:
    """A kind with other numbers of each axis, by its largest command."""

    def drawn(r: np.random.Generator) -> Drawn:
        base, way = first(r)
        v, omega = (
            replace(a, **numbers(r, most)) for a, most in zip(base.axes, way.most, strict=True)
        )
        return replace(base, axes=(v, omega)), replace(way, seconds=seconds)

    return drawn


def pushed(r: np.random.Generator) -> Drawn:
    """A slow push."""
    base, way = first(r)
    size = r.uniform(0.02, 0.06) * np.array(way.most)
    return base, replace(way, push=(size[0], size[1], float(r.uniform(0.2, 0.8))))


def noisy(r: np.random.Generator) -> Drawn:
    """Noise of 6 % of the largest command."""
    base, way = first(r)
    return base, replace(way, noise=(0.06 * way.most[0], 0.06 * way.most[1]))


def wheels(least: float, most: float) -> Callable[[np.random.Generator], Drawn]:
    """Wheels with a least or a largest speed, as shares of what both commands ask for."""

    def drawn(r: np.random.Generator) -> Drawn:
        base, way = first(r)
        half = float(r.uniform(0.1, 0.25))
        asked = way.most[0] + half * way.most[1]
        limits = {"least_wheel": least * asked, "most_wheel": most * asked}
        return replace(base, half_track=half, **limits), replace(way, seconds=60.0)

    return drawn


def ceasing(r: np.random.Generator) -> Drawn:
    """Commands that cease, and a base that stops by itself."""
    base, way = first(r)
    way = replace(way, period=0.05, held=(0.5, 1.2), silent=(4.0, 8.0), seconds=64.0)
    return replace(base, timeout=round(float(r.uniform(0.3, 1.0)), 2)), way


def falling(r: np.random.Generator) -> Drawn:
    """A gain that falls."""
    base, way = first(r)
    return replace(base, then=(float(r.uniform(12, 28)), int(r.integers(2)), 0.8)), way


GOOD: Mapping[str, Callable[[np.random.Generator], Drawn]] = {
    "first": first,
    "ramp": both(lambda r, most: {"accel": most * r.uniform(1.5, 3)}),
    "second": lambda r: first(r, "second-order"),
    "pi": lambda r: first(r, "pi"),
    "push": pushed,
    "slow rows": of(period=0.1, held=(0.6, 2.0)),
    "short steps": of(held=(0.3, 0.8)),
    "coarse": of(quantum=0.01, period=0.01),
    "noisy": noisy,
    "levels": of(kind="levels", jitter=4e-3, period=0.02),
    "smooth": of(kind="smooth"),
    "dead band": both(lambda r, most: {"dead": most * r.uniform(0.15, 0.3)}),
}
BAD: Mapping[str, Callable[[np.random.Generator], Drawn]] = {
    "ramps apart": both(
        lambda r, m: {"accel": m * r.uniform(0.8, 1.5), "decel": m * r.uniform(3, 5)}
    ),
    "offset": both(lambda r, most: {"offset": most * r.uniform(0.12, 0.3)}),
    "ramps, offset": both(
        lambda r, m: {"accel": m * 1.2, "decel": m * 2.5, "offset": m * r.uniform(0.1, 0.2)}
    ),
    "saturation": both(lambda r, most: {"most": most * r.uniform(0.6, 0.8)}),
    "sides": both(lambda r, most: {"back": r.choice([0.8, 0.85, 1.15, 1.2])}),
    "curve": both(lambda r, most: {"curve": r.uniform(0.25, 0.6) / most}),
    "sinks": both(lambda r, most: {"curve": -r.uniform(0.2, 0.4) / most}),
    "bias": both(lambda r, most: {"bias": most * r.choice([-0.1, 0.1])}),
    "gain falls": falling,
    "least wheel": wheels(0.12, NONE),
    "most wheel": wheels(0.0, 0.6),
    "cross": of({"cross": 0.4}),
    "off once": of(off=((12.0, 22.0),), seconds=60.0),
    "off twice": of(off=((10.0, 18.0), (40.0, 50.0)), seconds=60.0),
    "zeros": of(zeros=0.08),
    "spikes": of(spikes=6),
    "cease": ceasing,
    "timer": of(timer=True, period=0.033),
    "lost": of(lost=0.3, period=0.05),
    "clock slows": of(slows=20.0),
    "millimetres": of(scale=(1000.0, 1.0)),
    "per cent": of(scale=(100.0, 1.0)),
    "equal stamps": of(twice=200),
    "sensor": lambda r: (replace(first(r, "second-order")[0], sensor=0.08), first(r)[1]),
}
KINDS = {**GOOD, **BAD}


@dataclass
class Score:
    """What one log told: determined intervals and those that miss; largest speed over its limit."""

    kind: str
    determined: int = 0
    missed: list[str] = field(default_factory=list)
    accused: bool = False
    refused: str = ""
    told: list[str] = field(default_factory=list)
    largest: float | None = None
    held: float | None = None
    largest_beyond: float | None = None


def truths(truth: Truth, axis: int, most: float) -> dict[str, set[float]]:
    """What a parameter of an axis may be: more than one where it is not one number."""
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
    """Number of determined intervals, and those that the truth is outside of."""
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


def driven(scenario: Scenario, truth: Truth) -> tuple[float, float]:
    """Largest speed over its limit of the true base behind a written filter, and that it holds."""
    limits, period = scenario.limits.v_u1, scenario.clock.control
    inner, rng = max(1, round(period / STEP)), np.random.default_rng(7)
    largest, held = 0.0, [0.0, 0.0]
    after = [replace(truth, then=(0.0, *truth.then[1:]))] if truth.then else []
    for base_truth, kind in product([replace(truth, then=None), *after], HOSTILE):
        step, base, asked = command_filter(scenario).step, Base(base_truth), np.zeros(2)
        count = round(SECONDS / period)
        for k in range(count):
            if kind == "random" and k % max(1, round(0.3 / period)) == 0:
                asked = rng.uniform(-2, 2, 2) * limits
            elif kind != "random":
                turned = kind == "flips" and k // max(4, round(0.6 / period)) % 2
                asked = np.array(limits) * (-9 if turned else 9)
            sent = step((float(asked[0]), float(asked[1])), dt=period).command
            for _ in range(inner):
                base.step((float(sent[0]), float(sent[1])))
                shares = [abs(base.v[axis]) / limits[axis] for axis in (0, 1)]
                largest = max(largest, *shares)
        if kind == "constant" and base_truth.then is None:
            held = shares
    return largest, min(held)


def scored(kind: str, seed: int) -> Score:
    """The score of one log."""
    truth, drive = KINDS[kind](np.random.default_rng(seed))
    log = recorded(truth, drive, seed)
    score = Score(kind)
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
    if scenario.filter.kind == "none":
        return score
    score.largest, score.held = driven(scenario, truth)
    beyond = [float(f"{1.5 * x:.3g}") for x in scenario.limits.v_u1]
    further = identify(log, base="velocity", overrides={"limits.v_u1": beyond}).scenario
    if further.filter.kind != "none":
        score.largest_beyond = driven(further, truth)[0]
    return score


def summary(scores: Sequence[Score]) -> dict[str, object]:
    """The four numbers, and what they are made of."""
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
        "usable": usable,
    }  # fmt: skip


def table(scores: Sequence[Score]) -> str:
    """A line a kind."""
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


def first_seed(kind: str) -> int:
    """First seed of a kind: every third kind has seeds of its own."""
    return LATER_SEEDS if [*KINDS].index(kind) % 3 == 2 else SEEDS


def main(arguments: Sequence[str] | None = None) -> None:
    """Score logs of all kinds, and print the four numbers."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--logs", type=int, help="of each kind; default: 13 of good, 7 of bad ones")
    parser.add_argument("--kind", action="append", choices=[*KINDS], help="default: all")
    parser.add_argument("--json", action="store_true")
    given = parser.parse_args(arguments)
    warnings.simplefilter("ignore")
    scores = []
    for kind in given.kind or KINDS:
        count = given.logs or (13 if kind in GOOD else 7)
        for seed in range(first_seed(kind), first_seed(kind) + count):
            scores.append(scored(kind, seed))
            print(f"{kind} {seed}: {scores[-1]}", file=sys.stderr)
    print(json.dumps(summary(scores), indent=2) if given.json else table(scores))
    if not given.json:
        print(summary(scores))


if __name__ == "__main__":
    main()
