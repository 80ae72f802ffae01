"""Bases behind a filter with changing limits and free distances: they stop in time, and can leave.

A governor's bases are first-order; those of a clip slow down by at least ``decel`` (`RAMPS`).
"""

from __future__ import annotations

import ctypes
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import astuple, dataclass, replace
from itertools import chain
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.native import load_filter
from wmr_ctrl.world.scenario import Scenario, load_scenario

Floats = NDArray[np.float64]
Found = dict[str, Floats]
Pair = tuple[float, float]
NO_BRAKE = math.inf

RESULTS = ("over", "gap", "late", "used", "waits", "stopped", "mean", "passed", "early", "drawn")
"""Columns of `Drives.run`: fields of ``result`` in benchmarks/filter_drives.c."""
(
    PRESS,
    ANY,
    TO_AND_FRO,
    ON_AND_OFF,
    ODD,
    TURN_BACK,
    SMALL,
    BACK,
    TAPS,
    ALL_SORTS,
    SLOWLY,
    ONE_STEP,
) = range(12)
GREEDY, DRAWN, SWITCHING, EXTREMES = range(4)
CONSTANT, KEPT, NOISY, FALLING, BROKEN = range(5)
APPROACH, ROOT = 1, 2


@dataclass(frozen=True)
class Base:
    """Numbers of a base and its wires: the bounds stated to a filter, or the true values.

    ``v`` and ``omega``: largest speed forwards and backwards, or to the left and to the right.
    ``rest`` may be `NO_BRAKE`.  With ``decel`` the base slows down by at least that [m/s2, rad/s2]
    behind a lag of ``tau``, else it is of first order.
    """

    period: float = 0.05
    jitter: float = 0.0
    delay: Pair = (0.0, 0.0)
    losses: int = 0
    age: float = 0.0
    rest: float = 1.0
    nearing: float = 0.0
    error: float = 0.02
    free_age: float = 0.0
    leave: int = 1
    heard: bool = True
    hold: float = 0.0
    tau: Pair = (0.2, 0.3)
    gain: Pair = (0.9, 1.1)
    push: Pair = (0.05, 0.05)
    odometry: Pair = (0.02, 0.02)
    v: Pair = (1.0, 0.3)
    omega: Pair = (1.0, 1.0)
    decel: Pair | None = None

    def scenario(self) -> Scenario:
        """Scenario with a filter for these bounds."""
        sides = self.v, self.omega
        keys: dict[str, Any] = {
            "clock.control": self.period, "limits.v_u1": tuple(map(max, sides)),
            "limits.v_u2": tuple(0.7 * max(side) for side in sides),
            "limits.v_min": tuple(-side[1] for side in sides),
            "limits.v_max": tuple(side[0] for side in sides),
        }  # fmt: skip
        own = {
            "kind": "governor", "tau": self.tau, "gain": self.gain, "d": self.push,
            "delay": self.delay, "losses": self.losses, "jitter": self.jitter * self.period,
            "age": self.age, "changing": True, "free_error": self.error, "leave": self.leave,
            "free_age": self.free_age, "nearing": self.nearing, "hold": self.hold,
        }  # fmt: skip
        own |= {"rest": self.rest} if math.isfinite(self.rest) else {}
        own |= {"odometry": self.odometry} if self.heard else {}
        if self.decel:
            own |= {"kind": "clip", "decel": self.decel, "tau": self.tau if any(self.tau) else None}
        return load_scenario("paper-simulation", keys | {f"filter.{k}": v for k, v in own.items()})

    @property
    def numbers(self) -> Floats:
        """``numbers`` of benchmarks/filter_drives.c."""
        times = self.period, self.jitter, *self.delay, self.losses, self.age, self.rest
        told = self.nearing, self.error, self.free_age, self.leave, self.heard, self.hold
        slows = self.decel or (0.0, 0.0)
        sides = zip(self.push, self.odometry, (self.v, self.omega), slows, strict=True)
        axes = [(*self.tau, *self.gain, push, n, *limits, a) for push, n, limits, a in sides]
        return np.array([*times, *told, *axes[0], *axes[1]], float)


@dataclass(frozen=True)
class Choices:
    """Choices of a drive; -1 leaves one to chance.  Fields of ``choices`` in
    benchmarks/filter_drives.c.
    """

    seconds: float = 20.0
    axis: int = -1
    side: int = -1
    base: int = -1
    driver: int = -1
    limits: int = -1
    near: bool = False
    less: float = 0.0
    missing: float = 0.0
    rule: int = 0
    speed: float = 0.0
    rate: float = 0.0
    kept: float = 0.0
    far: Pair = (0.0, 5.0)
    apart: float = 0.0
    pauses: float = 0.0
    trusts: bool = False

    @property
    def numbers(self) -> Floats:
        """``choices`` of benchmarks/filter_drives.c."""
        return np.array([*chain.from_iterable(map(np.atleast_1d, astuple(self)))], float)


class Drives:
    """Compiled filter package that is run with many simulated drives."""

    def __init__(self, told: Base) -> None:
        """Compile it; CompilerError where that fails."""
        self.told, self._library = told, load_filter(told.scenario(), "filter_drives")

    def run(self, count: int, seed: int, real: Base | None = None, **chosen: Any) -> Found:
        """`RESULTS` (count,) of drives of the base stated to the filter or of another
        (``real``).
        """
        out = np.zeros((count, len(RESULTS)))
        given = self.told.numbers, (real or self.told).numbers, Choices(**chosen).numbers
        pointers = [item.ctypes.data_as(ctypes.c_void_p) for item in given]
        self._library.wmr_filter_drives(
            *pointers, ctypes.c_long(count), ctypes.c_ulonglong(seed),
            out.ctypes.data_as(ctypes.c_void_p),
        )  # fmt: skip
        return dict(zip(RESULTS, out.T, strict=True))


def breaks(found: Found) -> dict[str, NDArray[np.bool_]]:
    """Flags of drives that touch, are too fast, reach a lowered limit too late, or cannot leave."""
    return {
        "touch": found["gap"] < 0,
        "fast": found["over"] > 1,
        "late": found["late"] > 0,
        "stuck": found["waits"] > 1,
    }


MIXED: Sequence[tuple[float, Mapping[str, Any]]] = (
    (0.3, {}),
    (0.2, {"near": True, "seconds": 34.0}),
    (0.15, {"base": GREEDY}),
    (0.15, {"base": GREEDY, "near": True, "seconds": 34.0}),
    (0.1, {"driver": PRESS, "far": (0.0, 0.0)}),
    (0.1, {"driver": PRESS, "base": GREEDY, "limits": CONSTANT}),
)
"""Shares of drives, each with its choices."""


def mixed(filtering: Drives, count: int, seed: int) -> Found:
    """Drives of all kinds behind one filter (`MIXED`)."""
    aged = {"missing": 0.3} if filtering.told.free_age else {}
    return _together(
        filtering.run(round(share * count), seed + 10_000_000 * number, **{**chosen, **aged})
        for number, (share, chosen) in enumerate(MIXED)
    )


def drives(told: Base, count: int, seed: int) -> Found:
    """Drives of all kinds, half of them with ``leave`` 0."""
    kinds = sorted({0, told.leave})
    filters = [Drives(replace(told, leave=leave)) for leave in kinds]
    return _together(mixed(item, count // len(kinds), seed) for item in filters)


def _together(parts: Iterable[Found]) -> Found:
    found = list(parts)
    return {name: np.concatenate([item[name] for item in found]) for name in RESULTS}


FAMILIES: Mapping[str, Base] = {
    "0 to 30 ms late": Base(delay=(0.0, 0.03)),
    "quick, no push, no brake": Base(
        tau=(0.05, 0.08), gain=(0.98, 1.02), push=(0.0, 0.0), rest=NO_BRAKE,
        odometry=(0.005, 0.005), leave=0),
    "slow": Base(tau=(0.5, 1.0)),
    "0.1 to 0.15 s late": Base(delay=(0.1, 0.15), tau=(0.15, 0.3), v=(1.0, 1.0)),
    "no reverse": Base(v=(1.0, 0.05), delay=(0.05, 0.05)),
    "0.5 m/s ahead, 0.2 back": Base(v=(0.5, 0.2), delay=(0.02, 0.04)),
    "0.1 s late": Base(delay=(0.1, 0.1)),
    "0.2 s late": Base(delay=(0.2, 0.2)),
    "0.364 s late": Base(delay=(0.364, 0.364)),
    "0.4 s late": Base(delay=(0.4, 0.4)),
    "0.1 to 0.2 s late": Base(delay=(0.1, 0.2)),
    "0.35 to 0.4 s late, jitter 10 %, a loss": Base(delay=(0.35, 0.4), jitter=0.1, losses=1),
    "0 to 0.2 s late, jitter 30 %, two losses": Base(delay=(0.0, 0.2), jitter=0.3, losses=2),
    "two losses": Base(losses=2, delay=(0.02, 0.02)),
    "a loss, at once": Base(losses=1),
    "jitter 30 %": Base(jitter=0.3, delay=(0.03, 0.03)),
    "no odometry": Base(heard=False, delay=(0.05, 0.05)),
    "odometry 0.1 s old": Base(age=0.1, delay=(0.05, 0.08)),
    "distances 0.2 s old, some missing": Base(free_age=0.2, delay=(0.05, 0.05)),
    "things come nearer at 0.3 m/s": Base(nearing=0.3, leave=0, delay=(0.05, 0.05)),
    "they come at 0.5 m/s, 0.2 s late": Base(
        nearing=0.5, leave=0, delay=(0.2, 0.2), free_age=0.1),
    "control at 50 Hz": Base(period=0.02, delay=(0.1, 0.1)),
    "control at 10 Hz": Base(period=0.1, delay=(0.1, 0.12)),
    "push of 0.2 m/s, brake 0.4 s": Base(
        push=(0.2, 0.2), rest=0.4, delay=(0.05, 0.05), v=(1.0, 0.9)),
    "brake 3 s": Base(rest=3.0, delay=(0.05, 0.05)),
    "gain 0.7 to 1.4": Base(gain=(0.7, 1.4), delay=(0.1, 0.1)),
    "turning": Base(v=(1.5, 1.5), omega=(1.5, 0.5), tau=(0.1, 0.2), delay=(0.05, 0.1)),
    "stops by itself after 0.2 s": Base(hold=0.2, delay=(0.02, 0.05)),
    "brakes at once": Base(rest=0.0, delay=(0.05, 0.05)),
    "no push sideways": Base(push=(0.05, 0.0), delay=(0.05, 0.05)),
    "tau 0.05 to 0.8 s": Base(tau=(0.05, 0.8), delay=(0.05, 0.1)),
    "a hold of 1 s, distances missing": Base(
        period=0.1, free_age=0.1, rest=0.05, tau=(0.05, 1.0), push=(0.1, 0.1), v=(1.0, 1.0)),
}  # fmt: skip
"""Bases within their bounds."""

_SLOWS = Base(tau=(0.0, 0.0), decel=(1.0, 2.0), rest=1.5)
RAMPS: Mapping[str, Base] = {
    "0 to 30 ms late": replace(_SLOWS, delay=(0.0, 0.03)),
    "quick, no push, no brake": replace(
        _SLOWS, decel=(2.5, 5.0), push=(0.0, 0.0), rest=NO_BRAKE, leave=0),
    "slow": replace(_SLOWS, decel=(0.5, 1.0), rest=2.5, delay=(0.05, 0.05)),
    "0.1 to 0.15 s late": replace(_SLOWS, delay=(0.1, 0.15), v=(1.0, 1.0)),
    "a lag of 0.02 to 0.2 s": replace(_SLOWS, tau=(0.02, 0.2), delay=(0.0, 0.03)),
    "0.35 to 0.4 s late, jitter 10 %, a loss": replace(
        _SLOWS, delay=(0.35, 0.4), jitter=0.1, losses=1),
    "a lag, 0 to 0.2 s late, jitter 30 %, two losses": replace(
        _SLOWS, tau=(0.05, 0.1), delay=(0.0, 0.2), jitter=0.3, losses=2),
    "odometry 0.1 s old, distances 0.2 s": replace(
        _SLOWS, delay=(0.05, 0.05), age=0.1, free_age=0.2),
    "things come nearer at 0.3 m/s": replace(_SLOWS, delay=(0.05, 0.05), nearing=0.3, leave=0),
    "push of 0.2 m/s, brake 0.4 s": replace(
        _SLOWS, push=(0.2, 0.2), rest=0.4, delay=(0.05, 0.05)),
    "gain 0.7 to 1.4": replace(_SLOWS, gain=(0.7, 1.4), delay=(0.1, 0.1)),
    "1 m/s back, 0.1 m/s ahead, no push, no brake": replace(
        _SLOWS, decel=(0.5, 5.0), push=(0.0, 0.0), rest=NO_BRAKE, leave=0, v=(0.1, 1.0)),
    "stops by itself after 0.04 s": replace(
        _SLOWS, push=(0.2, 0.05), delay=(0.05, 0.05), hold=0.04),
    "turning": replace(
        _SLOWS, v=(1.5, 1.5), omega=(1.5, 0.5), decel=(1.0, 1.0), delay=(0.05, 0.1)),
}  # fmt: skip
"""Bases that slow down by at least ``decel``, within their bounds."""

PLAIN = Base(delay=(0.1, 0.1), leave=0)
LATE = Base(delay=(0.1, 0.2), jitter=0.1, losses=1, leave=0)
COMING, OLD, AGED = (
    replace(PLAIN, nearing=0.2),
    replace(PLAIN, free_age=0.2),
    replace(PLAIN, age=0.1),
)
TEETH: Mapping[str, tuple[Base, Mapping[str, Any], Mapping[str, Any]]] = {
    "largest time constant": (PLAIN, {"tau": (0.2, 0.33)}, {}),
    "least time constant": (PLAIN, {"tau": (0.18, 0.3)}, {}),
    "largest gain": (PLAIN, {"gain": (0.9, 1.21)}, {}),
    "least gain": (PLAIN, {"gain": (0.81, 1.1)}, {}),
    "push": (PLAIN, {"push": (0.055, 0.055)}, {}),
    "odometry": (PLAIN, {"odometry": (0.022, 0.022)}, {}),
    "distances": (PLAIN, {"error": 0.022}, {}),
    "brake": (PLAIN, {"rest": 1.1}, {}),
    "delay, later": (PLAIN, {"delay": (0.1, 0.11)}, {}),
    "delay, sooner": (PLAIN, {"delay": (0.09, 0.1)}, {}),
    "spread of the delay": (LATE, {"delay": (0.1, 0.21)}, {}),
    "a loss": (PLAIN, {"losses": 1}, {}),
    "jitter of 10 %": (PLAIN, {"jitter": 0.1}, {}),
    "things come nearer": (COMING, {"nearing": 0.22}, {}),
    "distances older by a period": (OLD, {"free_age": 0.25}, {}),
    "odometry older by a period": (AGED, {"age": 0.15}, {}),
    "axes that take over apart": (replace(LATE, losses=0), {}, {"apart": 1.0}),
    "a period less than the time for a lowered limit": (PLAIN, {}, {"less": 1.0}),
}
"""Violations by 10 % or as named: stated bounds, true values, choices of the drive."""
SLOWS = replace(_SLOWS, delay=(0.1, 0.1), leave=0)
RAMP_TEETH: Mapping[str, tuple[Base, Mapping[str, Any], Mapping[str, Any]]] = {
    "deceleration": (SLOWS, {"decel": (0.9, 1.8)}, {}),
    "lag": (replace(SLOWS, tau=(0.02, 0.2)), {"tau": (0.02, 0.22)}, {}),
    "largest gain": (SLOWS, {"gain": (0.9, 1.21)}, {}),
    "push": (SLOWS, {"push": (0.055, 0.055)}, {}),
    "odometry, five times its error": (SLOWS, {"odometry": (0.1, 0.1)}, {}),
    "distances": (SLOWS, {"error": 0.022}, {}),
    "brake": (SLOWS, {"rest": 1.65}, {}),
    "delay, later": (SLOWS, {"delay": (0.1, 0.11)}, {}),
    "spread of the delay": (replace(SLOWS, delay=(0.1, 0.2)), {"delay": (0.1, 0.21)}, {}),
    "a loss": (SLOWS, {"losses": 1}, {}),
    "jitter of 10 %": (SLOWS, {"jitter": 0.1}, {}),
    "things come nearer twice as fast": (replace(SLOWS, nearing=0.2), {"nearing": 0.4}, {}),
    "distances older by a period": (replace(SLOWS, free_age=0.2), {"free_age": 0.25}, {}),
}
"""Violations as in `TEETH`, for bases with a least deceleration."""
HARD: Sequence[Mapping[str, Any]] = (
    {"driver": PRESS, "base": GREEDY, "limits": CONSTANT, "far": (0.5, 4.0)},
    {"driver": PRESS, "base": GREEDY, "limits": KEPT, "far": (0.0, 0.0)},
    *({"driver": kind, "base": GREEDY, "limits": CONSTANT, "near": True, "seconds": 30.0}
      for kind in (TAPS, ONE_STEP, BACK, SLOWLY)),
)  # fmt: skip
"""Demanding drives: towards a wall, with falling limits, and away from a wall."""
HARD_RAMPS: Sequence[Mapping[str, Any]] = (
    *(
        {"driver": kind, "far": (0.3, 3.0), "axis": 0}
        for kind in (PRESS, ON_AND_OFF, TURN_BACK, TO_AND_FRO)
    ),
    *({"driver": kind, "near": True} for kind in (TAPS, BACK)),
)
"""Demanding drives of bases with a least deceleration, also with a stop from full speed."""


def bitten(name: str, count: int, seed: int) -> Found:
    """Drives of a base beyond one bound (`TEETH`), the same number for each of `HARD`."""
    return _bitten(*TEETH[name], HARD, count, seed)


def bitten_ramps(name: str, count: int, seed: int) -> Found:
    """Drives beyond one bound (`RAMP_TEETH`) of bases that a clip with `filter.decel` stops."""
    told, wrong, chosen = RAMP_TEETH[name]
    return _bitten(
        told, wrong, {**chosen, "base": GREEDY, "limits": CONSTANT}, HARD_RAMPS, count, seed
    )


def _bitten(
    told: Base,
    wrong: Mapping[str, Any],
    chosen: Mapping[str, Any],
    kinds: Sequence[Mapping[str, Any]],
    count: int,
    seed: int,
) -> Found:
    filtering, real = Drives(told), replace(told, **wrong)
    return _together(
        filtering.run(count, seed + 1000 * k, real, **{**hard, **chosen})
        for k, hard in enumerate(kinds)
    )


RULES: Sequence[str] = (
    "quick, no push, no brake", "0 to 30 ms late", "0.1 s late", "0.2 s late", "0.364 s late",
    "slow", "push of 0.2 m/s, brake 0.4 s",
)  # fmt: skip
"""Bases for the comparison with other rules."""
HORIZONS = (1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0, 12.0)
TO_THE_WALL: Mapping[str, Any] = {
    "axis": 0, "side": 0, "base": DRAWN, "driver": PRESS, "limits": CONSTANT, "far": (2.0, 5.0),
    "seconds": 25.0,
}  # fmt: skip


@dataclass(frozen=True)
class Compared:
    """Gaps [m] of random bases driven towards a wall: medians, and shares that touch it.

    ``filtered``: this filter, with ``leave`` 0 and 1. ``approach``: nav2's rule with its own
    horizon of 1.2 s: share that touches, and least gap. ``tuned``: least horizon [s] of `HORIZONS`
    with which that rule never touches, its median gap, and the share that touches if the adversary
    chooses the base; None if there is no such horizon. ``root``: share that touches with the rule
    sqrt(2 a d), a = 1 m/s2, with a margin of 0.1 m.
    """

    filtered: tuple[float, float]
    approach: tuple[float, float]
    tuned: tuple[float, float, float] | None
    root: float


def compared(name: str, count: int, seed: int = 5) -> Compared:
    """Compare the filter with our own versions of other rules; nav2 itself is not run."""
    told = FAMILIES[name]
    plain = Drives(replace(told, leave=0))
    one = Drives(replace(told, leave=1)) if math.isfinite(told.rest) else plain
    filtered = tuple(
        np.median(item.run(count, seed, **TO_THE_WALL)["stopped"]) for item in (plain, one)
    )
    speed = {**TO_THE_WALL, "speed": told.v[0]}
    first, tuned = None, None
    for horizon in HORIZONS:
        found = plain.run(count, seed, rule=APPROACH, rate=horizon, **speed)
        first = first or (float(np.mean(found["gap"] < 0)), float(found["stopped"].min()))
        if not (found["gap"] < 0).any():
            hard = {**speed, "base": GREEDY}
            worst = plain.run(count, seed, rule=APPROACH, rate=horizon, **hard)
            tuned = horizon, float(np.median(found["stopped"])), float(np.mean(worst["gap"] < 0))
            break
    root = plain.run(count, seed, rule=ROOT, rate=1.0, kept=0.1, **speed)
    assert first is not None
    return Compared((float(filtered[0]), float(filtered[1])), first, tuned,
                    float(np.mean(root["gap"] < 0)))  # fmt: skip
