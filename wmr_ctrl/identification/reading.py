"""A log read through the compiled filter: events in order, one pass, what it tells."""

from __future__ import annotations

import ctypes as ct
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from wmr_ctrl.codegen.dialect import LANES
from wmr_ctrl.codegen.emit import Kernel
from wmr_ctrl.codegen.resources import runtime_dir
from wmr_ctrl.codegen.source import sources
from wmr_ctrl.codegen.toolchain import build_library, find_toolchain
from wmr_ctrl.errors import CompilerError
from wmr_ctrl.identification.graph import PIECE, FilterGraph
from wmr_ctrl.identification.log import TORQUES, Log
from wmr_ctrl.scenario import Scenario
from wmr_ctrl.world.encoder import COUNTS

Floats = NDArray[np.float64]
START, PIECE_KIND, SKIPPED, COUNTED, WATCHED = range(5)
LONGEST = 0.01
"""Longest piece that is stepped over at once [s]."""
SHORTEST = 1e-9
BLOCKS = 15
GAP = 5.0
"""Steps without a row from which on a log is in two stretches."""


@dataclass(frozen=True)
class Samples:
    """What was seen and what was commanded, on the clocks of the log.

    ``t`` (N,) [s] and ``seen`` (N, 2): way [m] and turn [rad], or both speeds (``of_speed``), with
    variances (2,) that are known of each; ``command_t`` (M,) [s] and ``command`` (M, 2): torques
    [N m] or speeds, each held until the next; ``first``: indices of t at which a stretch without
    gap begins.
    """

    t: Floats
    seen: Floats
    variance: Floats
    command_t: Floats
    command: Floats
    first: NDArray[np.int64]
    of_speed: bool = False

    @property
    def period(self) -> float:
        """Median time between commands [s]."""
        return float(np.median(np.diff(self.command_t)))

    def until(self, end: float, begin: float = -np.inf) -> Samples:
        """The same between two times [s]; commands before are kept."""
        inside = np.flatnonzero((self.t >= begin) & (self.t < end))
        low, high = (int(inside[0]), int(inside[-1]) + 1) if inside.size else (0, 0)
        first = self.first[(self.first > low) & (self.first < high)] - low
        return Samples(
            self.t[low:high],
            self.seen[low:high],
            self.variance,
            self.command_t,
            self.command,
            np.concatenate(([0], first)).astype(np.int64),
            self.of_speed,
        )


def motion_of(
    raw: Log, scenario: Scenario, source: str, commands: tuple[str, ...] = TORQUES
) -> Samples:
    """Samples of a log whose motion is read from ``source``."""
    r, half_track = scenario.robot.r, scenario.robot.l
    sent, command = raw.pair(commands)
    variance, of_speed = np.zeros(2), source != COUNTS.name
    if source in (COUNTS.name, "wheel_speed"):
        names = COUNTS.elements if source == COUNTS.name else ("wheel_speed[1]", "wheel_speed[2]")
        t, wheel = raw.pair(names)
        if not of_speed:
            count = 2 * math.pi / float(scenario.value("encoder.counts")[0])
            wheel = wheel * count
            one = (count * r) ** 2 / 12
            variance = np.array([one / 2, one / (2 * half_track**2)])
        seen = (
            np.column_stack((wheel.sum(axis=1), (wheel[:, 0] - wheel[:, 1]) / half_track)) * r / 2
        )
    else:
        t, seen = raw.pair((source, source.replace("v1", "omega")))
    step = np.diff(t)
    first = np.concatenate(([0], np.flatnonzero(step > GAP * np.median(step)) + 1))
    return Samples(t, seen, variance, sent, command, first.astype(np.int64), of_speed)


@dataclass(frozen=True)
class Events:
    """Rows for the filter, their kinds, and the block that each counts in."""

    rows: Floats
    kinds: NDArray[np.int32]
    blocks: NDArray[np.int32]
    measured: int


def events_of(
    log: Samples,
    delay: float,
    start: Floats,
    wide: int,
    boost: Floats | None = None,
    kinds: NDArray[np.int32] | None = None,
    blocks: NDArray[np.int32] | None = None,
) -> Events:
    """Pieces between all times at which something is seen or a command begins to act, in order.

    ``start`` (F, state): means at the beginning of each stretch.  ``boost`` (N,): factor of the
    noise up to each sample; ``kinds`` (N,) and ``blocks`` (N,) of the measurements.
    """
    count, sent = len(log.t), len(log.command_t)
    base = np.concatenate((log.t, log.command_t))
    late = np.concatenate((np.zeros(count), np.ones(sent)))
    # Commands that begin to act as something is seen come after it.
    order = np.lexsort((late, base + late * delay))
    command = np.concatenate((np.full(count, -1), np.arange(sent)))[order]
    acting = np.maximum(np.maximum.accumulate(command), 0)
    seen = np.where(order < count, order, -1)
    before = np.maximum.accumulate(seen)
    inside = (before[:-1] >= 0) & (before[:-1] < count - 1)
    begins = np.zeros(count + 1, bool)
    begins[log.first] = True
    inside &= ~begins[np.minimum(before[:-1] + 1, count)]
    h0, h1 = np.diff(base[order]), np.diff(late[order])
    length = h0 + h1 * delay
    parts = np.where(inside & (length > SHORTEST), np.ceil(length / LONGEST), 0).astype(np.int64)
    # After each event: its pieces. Before them, if it is a measurement: that, and a start.
    starts = (seen >= 0) & begins[np.maximum(seen, 0)]
    own = np.where(seen >= 0, 1, 0) + starts
    size = own.copy()
    size[:-1] += parts
    place = np.concatenate(([0], np.cumsum(size)))
    rows = np.zeros((place[-1], wide))
    kind = np.full(place[-1], PIECE_KIND, np.int32)
    block = np.full(place[-1], -1, np.int32)
    piece = np.repeat(np.arange(len(parts)), parts)
    inner = np.concatenate([np.arange(0)] if not len(parts) else [_ranks(parts)])
    at = place[piece] + own[piece] + inner
    following = np.minimum(before[piece] + 1, count - 1)
    factor = np.ones(len(piece)) if boost is None else boost[following]
    rows[at, : len(PIECE)] = np.column_stack(
        (log.command[acting[piece]], h0[piece] / parts[piece], h1[piece] / parts[piece], factor)
    )
    spot = place[:-1][seen >= 0] + starts[seen >= 0]
    which = seen[seen >= 0]
    rows[spot, :5] = np.column_stack(
        (log.seen[which], np.tile(log.variance, (len(which), 1)), np.full(len(which), log.of_speed))
    )
    kind[spot] = COUNTED if kinds is None else kinds[which]
    block[spot] = 0 if blocks is None else blocks[which]
    where = place[:-1][starts]
    rows[where, : start.shape[1]] = start
    kind[where] = START
    return Events(rows, kind, block, count)


def _ranks(parts: NDArray[np.int64]) -> NDArray[np.int64]:
    """0 to n - 1 for each n of ``parts``, one after the other."""
    ends = np.cumsum(parts)
    return np.arange(ends[-1] if len(ends) else 0) - np.repeat(ends - parts, parts)


@dataclass(frozen=True)
class PassResult:
    """Result of a pass: by block minus the log of the likelihood (B,), its gradient (B, n), Fisher
    information (B, n, n); by measurement residuals, those in standard deviations, and means.
    """

    nll: Floats
    gradient: Floats
    fisher: Floats
    residual: Floats
    sizes: Floats
    mean: Floats


class CompiledFilter:
    """A model's filter as compiled C."""

    def __init__(self, graph: FilterGraph) -> None:
        """Build the library, or take it from the cache.  Raises CompilerError."""
        self.graph = graph
        self.wide = max(graph.state, len(PIECE))
        self._library = ct.CDLL(_library(graph))
        self._call = self._library.wmr_read_log

    def __call__(
        self, events: Events, parameters: Floats, covariance: Floats, slopes: bool = True
    ) -> PassResult:
        """One pass with ``parameters`` (searched, then known); ``covariance`` packed."""
        n, g = len(self.graph.names), self.graph
        nll, gradient = np.zeros(BLOCKS), np.zeros((BLOCKS, n))
        fisher = np.zeros((BLOCKS, n, n))
        residuals = np.zeros((events.measured, 2 * g.outputs + g.state))
        arrays = (events.rows, events.kinds, events.blocks, np.ascontiguousarray(parameters))
        pointers = [ct.c_void_p(item.ctypes.data) for item in (*arrays, covariance)]
        results = [ct.c_void_p(item.ctypes.data) for item in (nll, gradient, fisher, residuals)]
        self._call(ct.c_int64(len(events.kinds)), *pointers, ct.c_int32(bool(slopes)), *results)
        parts = np.split(residuals, [g.outputs, 2 * g.outputs], axis=1)
        return PassResult(nll, gradient, fisher, *parts)


@cache
def _library(graph: FilterGraph) -> str:
    """Path of the compiled filter."""
    sizes = {
        "NAMES": len(graph.names),
        "KNOWN": len(graph.known),
        "STATE": graph.state,
        "PRIMAL": graph.primal,
        "OUTPUTS": graph.outputs,
        "WIDE": max(graph.state, len(PIECE)),
    }
    return lanes_library("read_log.c", sizes, graph.kernels)


def lanes_library(driver: str, sizes: Mapping[str, int], kernels: Sequence[Kernel]) -> str:
    """Path of kernels compiled in lanes with the runtime's ``driver``, for this processor where
    the compiler can do that.  Raises CompilerError.
    """
    generated = sources(sizes, kernels, LANES)
    generated.pop("exports.h")
    names = ("arithmetic.h", "export.h", "lanes.h", driver)
    runtime = {name: (runtime_dir() / name).read_text("utf-8") for name in names}
    files = {name.replace(".c", ".inc"): text for name, text in generated.items()} | runtime
    toolchain = find_toolchain()
    try:
        return str(build_library(files, find_toolchain(native=not toolchain.misaligns_vectors)))
    except CompilerError:
        return str(build_library(files, toolchain))
