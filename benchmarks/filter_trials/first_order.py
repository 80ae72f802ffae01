"""Bases with first-order loops, or chains of them, against the clip and the governor."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from wmr_ctrl.world.scenario import Scenario

from .adversary import Base, fastest
from .compiled import BATCH, SAMPLES, WIDE_TURNS, Compiled, Floats, scenario

HALF_TRACK = 0.25
RIMS = {**WIDE_TURNS, "filter.wheel_speed": 1.2}
WHEELS = {**WIDE_TURNS, "filter.channels": "wheels"}
BY_SIDE: Mapping[str, Any] = {"limits.v_min": (-0.05, -0.4), "limits.v_max": (0.8, 1.0)}
"""Limits by direction; backwards no command is admitted, as a push alone reaches that limit."""
WHEEL_SIDES: Mapping[str, Any] = {
    **WIDE_TURNS, "filter.channels": "wheels", "limits.v_min": (-0.3, -4.0),
    "limits.v_max": (0.8, 3.0),
}  # fmt: skip
WORLDS: Sequence[Mapping[str, Any]] = (
    {}, {"delay": (0.03, 0.03)}, {"delay": (0.13, 0.13)}, {"delay": (0.02, 0.06)}, {"losses": 2},
    {"jitter": 0.01}, {"age": 0.08}, {"hold": 0.12, "losses": 1}, {"quantum": 0.03},
    {"age": 0.12, "delay": (0.02, 0.06), "losses": 1, "jitter": 0.004},
)  # fmt: skip


def told_of(
    kind: str, base: Base, changes: Mapping[str, Any], scale: str = "curvature"
) -> Scenario:
    """Scenario with a filter for this base."""
    V = changes.get("limits.v_u1", (1.0, 1.0))
    stated: dict[str, Any] = {
        "gain": base.gain, "scale": scale,
        "d": tuple(base.d * most + float(np.max(base.gain)) * error
                   for most, error in zip(V, _errors(kind, base), strict=True)),
    }  # fmt: skip
    changes = {
        **changes, "base.deadband": base.deadband, "base.wheel_deadband": base.wheel_deadband,
    }  # fmt: skip
    if kind == "governor":
        stated |= {
            name: getattr(base, name) for name in ("tau", "delay", "losses", "jitter", "age")
        }
        stated |= {"hold": base.hold} if base.hold < np.inf else {}
    return scenario(kind, changes, **stated)


def _errors(kind: str, base: Base) -> tuple[float, float]:
    """Largest error of the acting command, as a filter of this kind assumes it."""
    every = kind != "clip"
    rim = base.wheel_deadband * (1.0 if every else 0.5)
    v, omega = (base.quantum / 2 + every * band for band in base.deadband)
    return v + rim, omega + rim / HALF_TRACK


def first_order(
    kind: str,
    worlds: Sequence[Mapping[str, Any]],
    changes: Mapping[str, Any] = {},
    scales: Sequence[str] = ("curvature",),
    **options: Any,
) -> Callable[[int, int], Floats]:
    """Trials of first-order bases, for all worlds and scales in turn, with and without odometry.

    ``changes``: of the scenario; further ``options``: of the compiled filter.
    """

    def run(trials: int, seed: int) -> Floats:
        cases = [*itertools.product(worlds, (True, False))]
        each, found = -(-trials // len(cases)), []
        for number, (world, heard) in enumerate(cases):
            base = Base(**{"heard": heard, **world})
            stated = told_of(kind, base, changes, scales[number % len(scales)])
            found.append(_chain(stated, base, each, seed + number, **options))
        return np.concatenate(found)[:trials]

    return run


def _chain(stated: Scenario, base: Base, trials: int, seed: int, **options: Any) -> Floats:
    filtering = Compiled(stated, **options)
    batches = [min(BATCH, trials - start) for start in range(0, trials, BATCH)]
    return np.concatenate([
        fastest(stated, base, count, SAMPLES, 1000 * seed + k, lambda _, n: filtering.sender(n))
        for k, count in enumerate(batches)
    ])  # fmt: skip


def wrong(
    kind: str,
    told: Mapping[str, Any] = {},
    changes: Mapping[str, Any] = {},
    scale: str = "curvature",
    **wrongly: Any,
) -> Callable[[int, int], Floats]:
    """Trials of a first-order base beyond the bounds that the filter received."""
    base = Base(**told)
    stated = told_of(kind, base, changes, scale)
    return lambda trials, seed: _chain(stated, base.wrong(**wrongly), trials, seed)


CHAINS: Sequence[Mapping[str, Any]] = (
    *({"second_lag": lag, "delay": (0.0, 0.2), "losses": 3, "jitter": 0.02}
      for lag in (0.0, 0.005, 0.05, 0.3)),
    {"hold": 0.12, "quantum": 0.03, "second_lag": 0.05},
)  # fmt: skip
STOPPING: Mapping[str, Any] = {"accel": (2.0, 8.0), "decel": (2.0, 8.0), "loops": "alike"}
"""Ramps with which each axis stops at the rim as fast as the other starts, for l = 1/4 m."""
RAMPS: Sequence[Mapping[str, Any]] = (
    STOPPING, {**STOPPING, "delay": (0.0, 0.1), "losses": 2, "second_lag": 0.05},
    {**STOPPING, "accel": (0.5, 6.0), "decel": (3.0, 2.0)},
)  # fmt: skip
APART: Mapping[str, Any] = {"tau": ((0.1, 0.15), (0.4, 0.6)), "gain": ((0.95, 1.05), (0.8, 1.5))}
LATE_APART: Mapping[str, Any] = {
    **APART, "delay": ((0.02, 0.02), (0.02, 0.2)), "losses": 1, "jitter": 0.004, "age": 0.08,
}  # fmt: skip
"""Separate bounds of the delay for v and omega."""
WHEEL_SCALES = ("curvature", "turn", "drive")
SCALES = ("axes", *WHEEL_SCALES)
UNLIKE: Mapping[str, Any] = {"loops": "body", "tau": (0.2, 0.21), "gain": (1.1, 1.1)}
"""Time constants of v and omega 5 % apart."""


def alike(worlds: Sequence[Mapping[str, Any]], loops: str = "alike") -> list[Mapping[str, Any]]:
    """Worlds with equal loops of v and omega, or with loops of the wheels."""
    return [{**world, "loops": loops} for world in worlds]


def rims_broken(kind: str, **others: Any) -> dict[str, Callable[[int, int], Floats]]:
    """Trials that break a hypothesis of `filter.wheel_speed`, by the broken hypothesis."""
    broken = {"push": {"d": 0.0525}, "gain": {"gain": (0.9, 1.155)}, "loops 5 % apart": UNLIKE}
    return {name: wrong(kind, {"loops": "alike"}, RIMS, **what)
            for name, what in {**broken, **others}.items()}  # fmt: skip


WHEELED = {"loops": "wheels"}
FAST_TURNS: Mapping[str, Any] = {
    "limits.v_u1": (1.0, 6.0), "limits.v_u2": (0.7, 4.0), "filter.odometry": (0.02, 0.12),
}  # fmt: skip
SLOW_TURNS: Mapping[str, Any] = {
    "limits.v_u1": (1.0, 2.0), "limits.v_u2": (0.7, 1.4), "filter.odometry": (0.02, 0.04),
}  # fmt: skip
"""Limits with which one wheel may nearly stand while v, or omega, is at its limit."""
BAND, WHEEL_BAND = {"deadband": (0.05, 0.2)}, {"wheel_deadband": 0.05}
CHAINED = {"second_lag": 0.05, "delay": (0.0, 0.2), "losses": 3, "jitter": 0.02}
DEAD: Mapping[str, Sequence[Mapping[str, Any]]] = {
    "clip": [BAND, WHEEL_BAND, {**BAND, **CHAINED}, {**WHEEL_BAND, **CHAINED}],
    "governor": [
        BAND, WHEEL_BAND, {**BAND, "delay": (0.02, 0.06), "losses": 1},
        {**WHEEL_BAND, "delay": (0.13, 0.13), "jitter": 0.01},
    ],
}  # fmt: skip


def dead_bands(kind: str, **stated: Any) -> Callable[[int, int], Floats]:
    """Trials of bases with dead bands of v and omega, or of each wheel."""
    keys = {f"filter.{name}": value for name, value in stated.items()}
    ways = [first_order(kind, DEAD[kind], {**turns, **keys}, SCALES)
            for turns in (FAST_TURNS, SLOW_TURNS)]  # fmt: skip

    def run(trials: int, seed: int) -> Floats:
        half = -(-trials // 2)
        return np.concatenate([way(half, seed + 50 * k) for k, way in enumerate(ways)])[:trials]

    return run


def bands_broken(kind: str, **stated: Any) -> dict[str, Callable[[int, int], Floats]]:
    """Trials of bases with dead bands that break one hypothesis each, by its name."""
    keys = {f"filter.{name}": value for name, value in stated.items()}
    rows: dict[str, tuple[Mapping[str, Any], Mapping[str, Any]]] = {
        "gain": (BAND, {"gain": (0.9, 1.155)}),
    }  # fmt: skip
    if kind == "clip":
        rows["push"] = BAND, {"d": 0.0525}
        rows["dead band of wheels"] = WHEEL_BAND, {"wheel_deadband": 0.0525}
    elif not stated:  # which loses more while it lets the next command act than it hides
        rows["twice the dead band"] = BAND, {"deadband": (0.1, 0.4)}
        rows["twice that of wheels"] = WHEEL_BAND, {"wheel_deadband": 0.1}
    return {name: wrong(kind, told, {**FAST_TURNS, **keys}, **wrongly)
            for name, (told, wrongly) in rows.items()}  # fmt: skip


EXACT_CHAINS, EXACT_WORLDS = (
    [world for world in worlds if "quantum" not in world] for worlds in (CHAINS, WORLDS)
)
"""Chains and worlds without rounded commands, whose error counts as a push."""


def sides_broken(kind: str, changes: Mapping[str, Any], loops: str = "body") -> dict[str, Any]:
    """Trials behind limits by direction that break one hypothesis each by 10 %."""
    broken: dict[str, Mapping[str, Any]] = {"push": {"d": 0.055}, "gain": {"gain": (0.9, 1.21)}}
    if kind == "governor":
        broken |= {"time constant": {"tau": (0.18, 0.3)}, "odometry": {"error": 0.022}}
    told = {"loops": loops}
    return {name: wrong(kind, told, changes, **what) for name, what in broken.items()}
