"""Hostile commands to a base behind the filter of a release, whose folder is the argument.

    git worktree add ../release 7121a679
    echo '[["first", 100, [0.5, 1.0]]]' | python benchmarks/hostile.py ../release

The logs are named by kind, seed and limits, and the speeds held over the limits are printed.
"""

from __future__ import annotations

import json
import sys
import warnings
from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

if __name__ == "__main__":
    # Its modules come from the release, and those of benchmarks from beside this file.
    sys.path[0] = sys.argv[1]
    import wmr_ctrl

    sys.path[0] = str(Path(__file__).parents[1])

from benchmarks.base_kinds import KINDS
from benchmarks.own_axes import STEP, Base, Truth, recorded

HOSTILE, SECONDS = ("constant", "flips", "random"), 6.0


def driven(
    fresh: Callable[[], Any], limits: Sequence[float], period: float, truth: Truth
) -> tuple[float, float]:
    """Largest speed over its limit of a base behind a fresh filter, and its steady speed."""
    inner, rng = max(1, round(period / STEP)), np.random.default_rng(7)
    largest, held = 0.0, [0.0, 0.0]
    after = [replace(truth, then=(0.0, *truth.then[1:]))] if truth.then else []
    for base_truth, kind in product([replace(truth, then=None), *after], HOSTILE):
        step, base, asked = fresh().step, Base(base_truth), np.zeros(2)
        for k in range(round(SECONDS / period)):
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


def held_by_release(kind: str, seed: int, limits: Sequence[float]) -> float | None:
    """Steady speed of a base behind the filter that the release identifies from its log."""
    truth, drive = KINDS[kind](np.random.default_rng(seed))
    # The barrier plays no part for a base that takes velocities, but it must be below the limits.
    known = {"limits.v_u1": limits, "limits.v_u2": [0.8 * limit for limit in limits]}
    scenario = wmr_ctrl.identify(
        recorded(truth, drive, seed), base="velocity", overrides=known
    ).scenario
    if scenario.filter.kind == "none":
        return None
    fresh = lambda: wmr_ctrl.command_filter(scenario)  # noqa: E731
    return driven(fresh, limits, scenario.clock.control, truth)[1]


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    print(json.dumps([held_by_release(*log) for log in json.load(sys.stdin)]))
