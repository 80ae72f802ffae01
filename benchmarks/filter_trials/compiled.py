"""A scenario's compiled filter, stepped for many bases at once, and the form of a statement."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.native import load_filter
from wmr_ctrl.control.filter import filter_system
from wmr_ctrl.control.filter.channels import LIMITED
from wmr_ctrl.world.scenario import Scenario, load_scenario

from .adversary import Sender

BATCH = 2_000
SAMPLES, T = 120, 0.05
Floats = NDArray[np.float64]


class Compiled:
    """Compiled filter of a scenario, for many bases at once."""

    def __init__(self, scenario: Scenario, *, float32: bool = False) -> None:
        """Compile it; CompilerError where that fails."""
        self._library = load_filter(scenario, "filter_trials", float32=float32)
        self.scenario, self.system = scenario, filter_system(scenario)
        self.real = np.float32 if float32 else np.float64
        own, rounds = scenario.filter, float32 and scenario.filter.kind == "band"
        self.along = own.scale == "curvature" and not (own.slew or rounds or own.least)
        l, base = scenario.robot.l, scenario.base
        rims = np.array([(1, l), (1, -l)])
        bands = [(np.eye(2), base.deadband), (rims, (base.wheel_deadband,) * 2)]
        self.bands = bands if own.least else []

    def sender(self, trials: int) -> Sender:
        """Sender with fresh memory for ``trials`` bases."""
        y = np.zeros((trials, self.system.y.numel()), self.real)
        x = np.zeros((trials, self._library.wmr_filter_begin(ctypes.c_long(0), None)), self.real)
        self._library.wmr_filter_begin(ctypes.c_long(trials), x.ctypes.data_as(ctypes.c_void_p))
        sizes = trials, self.system.u.numel(), y.shape[1]

        def send(u: Floats) -> Floats:
            given = np.ascontiguousarray(u.T, dtype=self.real)
            pointers = (item.ctypes.data_as(ctypes.c_void_p) for item in (x, given, y))
            self._library.wmr_filter_many(*map(ctypes.c_long, sizes), *pointers)
            sent = y[:, :2].T.astype(float)
            off = self.along & turned(u, sent, float(np.finfo(self.real).eps))
            for rows, band in self.bands:  # what is not limited acts or is 0
                parts = np.abs(rows @ sent)
                idle = (parts > 1e-9) & (parts < np.reshape(band, (-1, 1)))
                off |= idle.any(axis=0) & (y[:, 2] % (2 * LIMITED) < LIMITED)
            return np.where(off, OFF, sent)

        return send


OFF = 1e9
"""Command [m/s] that replaces one that changes the curvature, or does not act."""


def turned(asked: Floats, sent: Floats, eps: float) -> NDArray[np.bool_]:
    """True where a command is not a multiple of the demand, roundings aside."""
    parts = sent[0] * asked[1], sent[1] * asked[0]
    off = np.abs(parts[0] - parts[1]) > 8 * eps * np.abs(parts).sum(axis=0)
    return (off & (np.abs(parts).max(axis=0) > 1e-25)) | (np.sum(asked[:2] * sent, axis=0) < 0)


@dataclass(frozen=True)
class Statement:
    """Statement with its trials: a function of number of trials and seed to largest |v|/V of each.

    ``broken``: the same with one broken hypothesis, by its name.
    """

    title: str
    inside: Callable[[int, int], Floats]
    broken: Mapping[str, Callable[[int, int], Floats]] = field(default_factory=dict)


STATED: Mapping[str, Any] = {
    "filter.tau": (0.2, 0.3), "filter.gain": (0.9, 1.1), "filter.d": (0.05, 0.05),
    "filter.odometry": (0.02, 0.02), "limits.v_u1": (1.0, 1.0), "limits.v_u2": (0.7, 0.7),
    "clock.control": T,
}  # fmt: skip
WIDE_TURNS: Mapping[str, Any] = {
    "limits.v_u1": (1.0, 4.0), "limits.v_u2": (0.7, 2.8), "filter.d": (0.05, 0.2),
    "filter.odometry": (0.02, 0.08),
}  # fmt: skip
"""Limits of v and omega that allow the same speed of a wheel."""


def scenario(kind: str, changes: Mapping[str, Any] = {}, **stated: Any) -> Scenario:
    """Scenario with this kind of filter."""
    keys = {f"filter.{name}": value for name, value in {"kind": kind, **stated}.items()}
    return load_scenario("paper-simulation", {**STATED, **changes, **keys})
