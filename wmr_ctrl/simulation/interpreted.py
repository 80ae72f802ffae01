"""The closed loop without a compiler: its graphs in CasADi's virtual machine, run by NumPy.

It does the same as fmu/runtime/loop.c, in the same order: draws, commands in transit, changes of
parameters, monitor, log.  Elementary functions and random numbers are CasADi's and NumPy's, so it
agrees with the compiled loop up to their rounding.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from wmr_ctrl.core.signals import PLANT_STATE, VELOCITY
from wmr_ctrl.results import Floats, Monitor, Settings, split_columns
from wmr_ctrl.results.outcomes import DIVERGENCE, STOP_REASONS
from wmr_ctrl.results.settings import Event

from .memory import noise_key

if TYPE_CHECKING:
    from wmr_ctrl.codegen.functions import LoopFunctions, StreamNumbers

_ATTEMPTS = 64
_BLOCK = 1024  # samples or steps for which random numbers are drawn at a time
_ROWS_PER_REPORT = 100
_VELOCITY = PLANT_STATE.index(VELOCITY[0])
_, _DIVERGED, _NON_FINITE = STOP_REASONS


def run_interpreted(
    loop: "LoopFunctions",
    seed: int,
    settings: Settings,
    progress: Callable[[float], None] | None = None,
) -> tuple[dict[str, Floats], Monitor]:
    """One run: columns by signal name, (N,) or (N, size), and the monitor.

    ``progress`` is called with the share of the samples that is done.
    """
    run = _Run(loop, seed, settings)
    rows: list[Floats] = []
    while len(rows) < settings.samples and run.watch.stopped is None:
        rows.append(run.sample(len(rows)))
        if progress is not None and len(rows) % _ROWS_PER_REPORT == 0:
            progress(len(rows) / settings.samples)
    columns = loop.numbers.layout.columns
    log = np.array(rows).reshape(-1, sum(item.size for item in columns))
    return split_columns(columns, log), run.watch.monitor()


class _Run:
    """The state of a run, and its commands in transit."""

    def __init__(self, loop: "LoopFunctions", seed: int, settings: Settings) -> None:
        self.numbers, self.substeps = loop.numbers, round(settings.control / settings.plant)
        self.sampled, self.stepped = loop.sample, loop.step
        self.fast = len(self.stepped.outputs[0])
        self.x, self.phase = np.array(loop.numbers.start), -1
        self.queue = np.zeros((loop.numbers.delay_steps, 2))
        key = noise_key(seed)
        self.draws = [_Draws(item, key) for item in loop.sampled]
        self.step_draws = [_Draws(item, key) for item in loop.stepped]
        self.watch = _Watch(loop.limits, settings.plant)
        self.watch.see(0, self.x)

    def sample(self, k: int) -> Floats:
        """Sample ``k`` and the plant's steps until the next; returns the row of the log."""
        self._change(k * self.substeps)
        number, x, _, draws = self.sampled.inputs
        following, held, row = self.sampled.outputs
        number[:], x[:], draws[:] = k, self.x, _joined(self.draws, k)
        self.sampled()
        self.x[self.fast :] = following
        for step in range(k * self.substeps, (k + 1) * self.substeps):
            if self.watch.stopped is None:
                self._step(step, k, held)
        return row.copy()

    def _step(self, step: int, sample: int, held: Floats) -> None:
        self._change(step)
        number, u, x, _, draws = self.stepped.inputs
        number[:], u[:], x[:] = step, held, self.x[: self.fast]
        if len(self.queue):
            slot = self.queue[step % len(self.queue)]
            u[:2], slot[:] = slot.copy(), held[:2]
        draws[:] = _joined(self.step_draws, step, sample)
        self.stepped()
        self.x[: self.fast] = self.stepped.outputs[0]
        self.watch.see(step + 1, self.x)

    def _change(self, step: int) -> None:
        """Set the parameters of the last phase that has begun at this plant step."""
        starts = self.numbers.phase_start
        while self.phase + 1 < len(starts) and step >= starts[self.phase + 1]:
            self.phase += 1
            for graph, place in ((self.sampled, 2), (self.stepped, 3)):
                graph.inputs[place][:] = self.numbers.parameters[self.phase]


class _Draws:
    """Random numbers of one stream, in the blocks of NumPy's generator."""

    def __init__(self, stream: "StreamNumbers", key: tuple[int, int]) -> None:
        self.stream, self.key = stream, np.array(key, np.uint64)
        self.first, self.block = -_BLOCK, np.zeros((_BLOCK, stream.size))

    def at(self, index: int) -> Floats:
        """The numbers (size,) of a sample or step."""
        if not self.first <= index < self.first + _BLOCK and self.stream.wanted:
            self.first = index - index % _BLOCK
            pairs = [self._pairs(pair) for pair in range(self.stream.size // 2)]
            self.block = np.hstack(pairs)
        return self.block[index % _BLOCK]

    def _pairs(self, pair: int) -> Floats:
        """Pairs (_BLOCK, 2) from ``first`` on: uniform in [-1, 1), or normal (Box-Muller)."""
        if not self.stream.normal:
            return 2.0 * self._uniforms(pair, 0) - 1.0
        bound, drawn = self.stream.bound, np.full((_BLOCK, 2), np.inf)
        for attempt in range(_ATTEMPTS):
            outside = (np.abs(drawn) > bound).any(axis=1) if attempt else np.full(_BLOCK, True)
            if not outside.any():
                break
            first, second = self._uniforms(pair, attempt)[outside].T
            radius, angle = np.sqrt(-2.0 * np.log(1.0 - first)), 2.0 * np.pi * second
            drawn[outside] = np.column_stack((radius * np.cos(angle), radius * np.sin(angle)))
        return np.clip(drawn, -bound, bound)

    def _uniforms(self, pair: int, attempt: int) -> Floats:
        """Numbers (_BLOCK, 2) in [0, 1) with 53 bits, from consecutive Philox blocks."""
        counter = self.first + (self.stream.number << 64) + (attempt << 128) + (pair << 192)
        before = (counter - 1) % 2**256  # the generator counts up before it draws
        words = np.random.Philox(key=self.key, counter=before).random_raw(4 * _BLOCK)
        return (words.reshape(-1, 4)[:, :2] >> np.uint64(11)).astype(np.float64) * 2.0**-53


def _joined(draws: list[_Draws], index: int, sample: int = 0) -> Floats:
    """Numbers of all streams of a rate; held ones of plant steps are those of their sample."""
    if not draws:
        return np.zeros(0)
    return np.concatenate([item.at(sample if item.stream.held else index) for item in draws])


@dataclass
class _Watch:
    """Extremes and events of a run; values beyond ``limits`` are counted as violations.

    They are as in CLOCK: the largest and least v1 and omega, a wheel's speed, half the track.
    """

    limits: tuple[float, ...]
    period: float
    most: list[float] = field(default_factory=lambda: [0.0, 0.0])
    margin: list[float] = field(default_factory=lambda: [np.inf, np.inf])
    violations: int = 0
    first: Event | None = None
    stopped: Event | None = None
    reason: str = ""

    def see(self, step: int, state: Floats) -> None:
        """Take note of the state after ``step`` plant steps."""
        v = state[_VELOCITY], state[_VELOCITY + 1]
        high, low, (wheel, half_track) = self.limits[:2], self.limits[2:4], self.limits[4:]
        speeds, room = (abs(v[0]), abs(v[1])), list[float]()
        for axis, speed in enumerate(speeds):
            if not np.isfinite(speed):
                return self._stop(step, axis, _NON_FINITE)
            room.append(float(min(high[axis] - v[axis], v[axis] - low[axis])))
            self.most[axis] = max(self.most[axis], float(speed))
            self.margin[axis] = min(self.margin[axis], room[axis])
        room.append(wheel - (speeds[0] + half_track * speeds[1]))
        beyond = [axis for axis, left in enumerate(room) if left < 0]
        if beyond:
            self.violations += 1
            self.first = self.first or (step * self.period, beyond[0] + 1)
        for axis in (0, 1):
            if self.stopped is None and speeds[axis] >= DIVERGENCE:
                self._stop(step, axis, _DIVERGED)
        return None

    def _stop(self, step: int, axis: int, reason: str) -> None:
        self.stopped, self.reason = (step * self.period, axis + 1), reason

    def monitor(self) -> Monitor:
        """Monitor of the steps so far."""
        most, margin = (self.most[0], self.most[1]), (self.margin[0], self.margin[1])
        seen = self.violations, self.first, self.stopped, self.reason
        return Monitor(most, *seen, least_margin=margin)
