"""Bases behind a governor that is told limits and free ways: they stop in time, and can leave."""

from __future__ import annotations

import ctypes
import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.native import load_filter
from wmr_ctrl.world.scenario import Scenario, load_scenario

Floats = NDArray[np.float64]
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
    """Numbers of a base, of its wires and of what is told: bounds for a filter, or what is true.

    ``v`` and ``omega``: largest speed forwards and backwards, or to the left and to the right.
    ``rest`` may be `NO_BRAKE`.
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

    def scenario(self) -> Scenario:
        """A scenario whose filter is told these bounds."""
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
        return load_scenario("paper-simulation", keys | {f"filter.{k}": v for k, v in own.items()})

    @property
    def numbers(self) -> Floats:
        """``numbers`` of benchmarks/filter_drives.c."""
        whole = (self.period, self.jitter, *self.delay, self.losses, self.age, self.rest,
                 self.nearing, self.error, self.free_age, self.leave, self.heard, self.hold)  # fmt: skip
        sides = zip(self.push, self.odometry, (self.v, self.omega), strict=True)
        axes = [(*self.tau, *self.gain, push, n, *limits) for push, n, limits in sides]
        return np.array([*whole, *axes[0], *axes[1]], float)


@dataclass(frozen=True)
class Choices:
    """What is not drawn; -1: by chance.  Fields of ``choices`` in benchmarks/filter_drives.c."""

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

    @property
    def numbers(self) -> Floats:
        names = (
            "seconds",
            "axis",
            "side",
            "base",
            "driver",
            "limits",
            "near",
            "less",
            "missing",
            "rule",
            "speed",
            "rate",
            "kept",
        )
        own = [getattr(self, name) for name in names]
        return np.array([*own, *self.far, self.apart, self.pauses], float)


class Drives:
    """The C of a filter's package behind drives of bases."""

    def __init__(self, told: Base) -> None:
        """Compile it; CompilerError where that fails."""
        self.told, self._library = told, load_filter(told.scenario(), "filter_drives")

    def run(
        self, count: int, seed: int, real: Base | None = None, **chosen: Any
    ) -> dict[str, Floats]:
        """`RESULTS` of so many drives, of a base as it is told or of another."""
        out = np.zeros((count, len(RESULTS)))
        drawn = Choices(**chosen).numbers
        given = (self.told.numbers, (real or self.told).numbers, drawn)
        pointers = [item.ctypes.data_as(ctypes.c_void_p) for item in given]
        self._library.wmr_filter_drives(
            *pointers,
            ctypes.c_long(count),
            ctypes.c_ulonglong(seed),
            out.ctypes.data_as(ctypes.c_void_p),
        )
        return dict(zip(RESULTS, out.T, strict=True))
