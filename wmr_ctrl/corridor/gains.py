"""Peak gains of the sampled loop, enclosed: how far bounded inputs can push any linear output.

The matrix A of a sample has a ball for each entry, and its powers are taken in as many bits as the
growth of |A|^k asks for, so that no coordinates need to be block in which the loop is diagonal.
With q = ||A^K|| < 1 in a weighed norm, which is computed, all that comes after K samples is at most
q/(1-q) of what came before.  Sums are of sizes in doubles, with their rounding added.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from functools import cached_property
from math import ceil, cos, log, log2, pi, sin

import numpy as np
from flint import arb, ctx

from wmr_ctrl.checks.world import COMMAND, ROBOT, Floats
from wmr_ctrl.corridor.loop import UP, SampledLoop
from wmr_ctrl.corridor.sample import (
    FLOOR,
    ROUNDING,
    OutputRows,
    SampleMatrices,
    SlowLoopError,
    balls,
    doubles,
    powers_of,
    powers_until,
    unit_matrix,
)

LEFT, FAINTEST = 1e-6, 0.1
"""Size of A^K at which the sums end, and the largest with which they may end."""
MOST_SAMPLES, MOST_BITS, MOST_STEPS = 12_000, 30_000, 100_000
"""Largest numbers of samples, bits, and plant steps in those samples: some 4 s of CPU."""
SPARE_BITS = 320
DIRECTIONS = 16
PAIRS = [(a, b) for a in range(ROBOT) for b in range(a + 1, ROBOT)]


@dataclass(frozen=True)
class Gains:
    """Largest rows for inputs of size 1 in every sample, whatever their signs.

    ``by``: columns push (2), errors of the law's outputs, errors of the command that acts in each
    plant step of the overlap (2 each), a disc of (e1, e2) as measured, nothing,
    errors of e3, v1 and omega as measured.
    ``steps``: by what a plant step leaves, in every one.  ``start``: largest values at any time
    after a start that is off by shares of the columns that were asked for; ``misled``: after
    one whose estimated position is off by 1 m in any direction, alone; ``before`` (2 columns):
    after one at which an observer remembers a velocity that is off by 1, alone.  ``first``: the
    same within one sample, by the state at its begin and then as ``by`` and ``steps``.  ``left``:
    what is left after ``samples``, by the state's largest deviation in units of ``scale``.
    ``constant``: largest values under what every plant step adds alike, alone.
    """

    by: Floats
    steps: Floats
    start: Floats
    misled: Floats
    before: Floats
    first: tuple[Floats, Floats, Floats]
    left: Floats
    constant: Floats


@dataclass(frozen=True)
class LoopGains:
    """Gains of the fast state at all plant steps, of the state at samples, of the law's outputs.

    Rows of ``fast``: its elements, directions of (e1, e2), then for each of PAIRS the sum and the
    difference of its first with ``ratios`` times its second, and what dead reckoning is off, if
    that was asked for.  ``damping`` is q, over ``samples``,
    ``scale`` the weights of its norm.
    """

    fast: Gains
    state: Gains
    law: Gains
    ratios: Floats
    damping: float
    samples: int
    scale: Floats

    @property
    def starts(self) -> bool:
        """Whether they are those of a start off the reference."""
        return bool(self.state.start.any())

    def nearer(self, share: float) -> LoopGains:
        """The same from a share of the start, whose responses are linear."""
        fast, state, law = (
            replace(item, start=item.start * share * UP)
            for item in (self.fast, self.state, self.law)
        )
        return replace(self, fast=fast, state=state, law=law)


def loop_gains(
    loop: SampledLoop, start: Floats, added: Floats, *, reckons: bool = False
) -> LoopGains:
    """All gains of a loop, from a start off by shares of the columns ``start`` (n, columns).

    ``added``: what every plant step adds to the fast state, always the same.  ``reckons``: also by
    how much (3) dead reckoning over a sample is off.
    SlowLoopError where it is unstable or too slow to be enclosed.
    """
    with ctx.workprec(SPARE_BITS):
        rough = doubles(SampleMatrices(loop).A)
    samples, growth = _samples(rough)
    if samples * loop.steps > MOST_STEPS:
        raise SlowLoopError(f"it takes {samples} samples to come to rest")
    bits = SPARE_BITS + ceil(samples * log2(max(growth, 1.0)))
    if bits > MOST_BITS:
        raise SlowLoopError(f"its matrix would take {bits} bits")
    with ctx.workprec(bits):
        return _summed(SampleMatrices(loop), loop, samples, start, added, reckons)


def _samples(a: Floats) -> tuple[int, float]:
    """Samples until A^K is small, and the growth of |A|^k: estimates, nothing rests on them."""
    damping, growth = (float(np.abs(np.linalg.eigvals(m)).max()) for m in (a, np.abs(a)))
    samples = ceil(log(LEFT) / log(damping)) + 2 * len(a) if 0 < damping < 1 else MOST_SAMPLES + 1
    if samples > MOST_SAMPLES:
        raise SlowLoopError(f"its largest pole is {damping:.4g}")
    return samples, growth


def _summed(
    sample: SampleMatrices,
    loop: SampledLoop,
    samples: int,
    start: Floats,
    added: Floats,
    reckons: bool,
) -> LoopGains:
    n, nz = sample.n, len(loop.names)
    powers, summed, last = powers_until(sample.A, samples)
    measured = sample.outputs @ sample.seen
    inputs = np.hstack([sample.push, sample.outputs, sample.late, measured])
    every = np.hstack([np.eye(n), doubles(inputs)])
    course = powers @ every
    scale = np.abs(course[:, :, n : n + COMMAND]).sum(axis=(0, 2))
    scale = scale + 1e-9 * scale.max()
    left = np.abs(last)
    damping = float((left @ scale / scale).max()) * UP
    if damping > FAINTEST:
        raise SlowLoopError(f"a share of {damping:.2g} is left after {samples} samples")
    ratios = np.array([scale[a] / scale[b] for a, b in PAIRS])
    picked, blank = fast_rows(nz, ratios), np.zeros((n, n))
    powers_within = powers_of(sample.step, loop.steps)
    apart = sum(
        (np.abs(doubles(item - unit_matrix(nz))) for item in powers_within),
        start=np.zeros((nz, nz)),
    )
    sums_within = [balls(nz, 1)]
    for item in powers_within:
        sums_within.append(sums_within[-1] + item @ np.array([[arb(x)] for x in added.tolist()]))
    shares = [doubles(item)[:, 0] for item in sums_within]
    whole_sample = np.concatenate((shares[-1], np.zeros(n - nz)))
    steps = loop.steps * np.eye(n)[:, :nz] + np.vstack([apart, np.zeros((n - nz, nz))])
    whole, steady = summed.sum(axis=0), powers @ whole_sample
    norms = _weighed(course, summed @ np.abs(every), scale)
    off = summed @ np.abs(whole_sample)
    rest = _weighed(steady[..., None], off[..., None], scale).sum()
    estimate = n - sample.acting - loop.filter if loop.filter else None
    old = nz + COMMAND * loop.queue + loop.observed[1] if loop.observed else None
    sums = _Sums(
        course, whole, np.abs(every), norms, scale, damping, n, steps, start, estimate, old,
        steady, off.sum(axis=0), float(rest),
    )  # fmt: skip
    within = [sums.gains(sample.rows_within(s, picked), shares[s]) for s in range(loop.steps)]
    shown = doubles(sample.law)
    count = len(shown)
    late = sample.late.shape[1]
    none = {"push": blank[:, :COMMAND], "measured": np.zeros((n, ROBOT)), "steps": blank[:, :nz],
            "late": np.zeros((n, late))}  # fmt: skip
    state = OutputRows(np.eye(n), np.eye(n), law=np.zeros((n, count)), **none)
    law = OutputRows(
        np.eye(count), shown, np.zeros((count, COMMAND)), np.eye(count), np.zeros((count, late)),
        np.abs(doubles(sample.seen)) * UP, np.zeros((count, nz)),
    )  # fmt: skip
    fast = _largest(within)
    if reckons:
        fast = _stacked(fast, sums.gains(sample.reckoned_rows(loop), shares[-1]))
    three = fast, sums.gains(state), sums.gains(law)
    return LoopGains(*three, ratios, damping, samples, scale)


def _weighed(course: Floats, size: Floats, scale: Floats) -> Floats:
    """Weighed norms (samples, inputs) of what is rounded as sums of a ``size`` are."""
    norms: Floats = ((np.abs(course) + ROUNDING * size) / scale[:, None]).max(axis=1)
    return norms


@dataclass
class _Sums:
    """The loop's course from each input's unit, (samples, n, inputs), and sums over it.

    ``powers``: sizes of what the powers are sums of; ``norms`` (samples, inputs): weighed ones of
    the course, ``steady_norm``: the sum of those of ``steady``.
    """

    course: Floats
    powers: Floats
    inputs: Floats
    norms: Floats
    scale: Floats
    damping: float
    n: int
    steps: Floats
    start: Floats
    estimate: int | None
    old: int | None
    steady: Floats
    steady_size: Floats
    steady_norm: float

    @cached_property
    def _in_rows(self) -> Floats:
        """The course as one matrix (n, samples inputs)."""
        return np.ascontiguousarray(self.course.transpose(1, 0, 2)).reshape(self.n, -1)

    def gains(self, rows: OutputRows, added: Floats | None = None) -> Gains:
        """Gains of some rows: sums of sizes with the shares of rounding and tail, and the direct
        part.

        ``added``: what the present sample has added so far, of what it always adds, to the state
        that ``rows`` picks from; None: nothing.
        """
        size, n = np.abs(rows.picked) @ np.abs(rows.state), self.n
        ways = (rows.picked @ rows.state @ self._in_rows).reshape(len(size), len(self.course), -1)
        seen = np.abs(ways)
        slack = ROUNDING * size @ (self.powers @ self.inputs) + FLOOR
        reach = size @ self.scale
        tail = np.outer(reach, self.norms.sum(axis=0)) * self.damping / (1 - self.damping)
        start = self._started(ways[..., :n], slack, reach)
        misled, before = self._misled(seen, slack, reach), self._before(seen, slack, reach)
        direct = np.hstack([rows.push, rows.law, rows.late, rows.measured])
        disc = [-ROBOT, 1 - ROBOT]
        for part in (seen, direct):
            part[..., disc[0]] = np.hypot(part[..., disc[0]], part[..., disc[1]])
        for part in (slack, tail):
            part[..., disc[0]] += part[..., disc[1]]
        for part in (seen, slack, tail, direct):
            part[..., disc[1]] = 0.0
        every = (seen.sum(axis=1) + slack + tail) * UP
        steps = (every[:, :n] @ self.steps + rows.steps) * UP
        held = (np.abs(rows.picked @ rows.state) + ROUNDING * size + FLOOR) * UP
        first = held, direct, rows.steps
        left = reach * self.damping * UP
        constant = self._constant(rows, size, reach, added)
        by = (every[:, n:] + direct) * UP
        return Gains(by, steps, start, misled, before, first, left, constant)

    def _started(self, ways: Floats, slack: Floats, reach: Floats) -> Floats:
        """Largest values after a start at any sum of shares of the columns ``start``."""
        size = np.abs(self.start).sum(axis=1)
        if not size.any():
            return np.zeros(len(reach))
        rest = (
            slack[:, : self.n] + np.outer(reach, self.norms[:, : self.n].max(axis=0)) * self.damping
        )
        off = (np.abs(ways) @ size).max(axis=1) * ROUNDING
        most = np.abs(ways @ self.start).sum(axis=2).max(axis=1)
        return np.asarray((most + off + rest @ size) * UP)

    def _constant(
        self, rows: OutputRows, size: Floats, reach: Floats, added: Floats | None
    ) -> Floats:
        """Largest values of the sums, with their signs, of what every sample adds alike."""
        now = np.zeros(rows.picked.shape[1]) if added is None else added
        each = rows.picked @ rows.state @ self.steady.T
        course = np.cumsum(np.hstack([(rows.picked @ now)[:, None], each]), axis=1)
        picked = np.abs(rows.picked) @ np.abs(now)
        slack = (UP - 1) * (np.abs(each).sum(axis=1) + picked) + FLOOR
        slack += ROUNDING * size @ self.steady_size
        rest = reach * self.steady_norm * self.damping / (1 - self.damping)
        return np.asarray((np.abs(course).max(axis=1) + slack + rest) * UP)

    def _misled(self, seen: Floats, slack: Floats, reach: Floats) -> Floats:
        """Largest values after a start whose estimated position alone is off."""
        if self.estimate is None:
            return np.zeros(len(reach))
        e = slice(self.estimate, self.estimate + 2)
        rest = slack[:, e] + np.outer(reach, self.norms[:, e].max(axis=0)) * self.damping
        size = np.hypot(seen[..., self.estimate], seen[..., self.estimate + 1]).max(axis=1)
        return np.asarray((size + rest.sum(axis=1)) * UP)

    def _before(self, seen: Floats, slack: Floats, reach: Floats) -> Floats:
        """Largest values after a start at which one remembered velocity is off (2 columns)."""
        if self.old is None:
            return np.zeros((len(reach), COMMAND))
        v = slice(self.old, self.old + COMMAND)
        rest = slack[:, v] + np.outer(reach, self.norms[:, v].max(axis=0)) * self.damping
        return np.asarray((seen[..., v].max(axis=1) + rest) * UP)


def fast_rows(nz: int, ratios: Floats) -> Floats:
    """Elements of the fast state, directions of (e1, e2), sums and differences of pairs."""
    turns = [k * pi / DIRECTIONS for k in range(DIRECTIONS)]
    rows = [*np.eye(nz), *(_row(nz, (0, cos(t)), (1, sin(t))) for t in turns)]
    for (a, b), ratio in zip(PAIRS, ratios, strict=True):
        rows += [_row(nz, (a, 1.0), (b, sign * ratio)) for sign in (1, -1)]
    return np.array(rows)


def _row(size: int, *entries: tuple[int, float]) -> Floats:
    row = np.zeros(size)
    for place, value in entries:
        row[place] = value
    return row


def _stacked(first: Gains, second: Gains) -> Gains:
    """Rows of the first, then those of the second."""
    own, more = (
        {item.name: getattr(gains, item.name) for item in fields(Gains) if item.name != "first"}
        for gains in (first, second)
    )
    held, direct, steps = (
        np.concatenate(both) for both in zip(first.first, second.first, strict=True)
    )
    rows = {name: np.concatenate((value, more[name])) for name, value in own.items()}
    return Gains(first=(held, direct, steps), **rows)


def _largest(each: list[Gains]) -> Gains:
    """Entry by entry."""
    by, steps, start, misled, before, left, constant = (
        np.max([getattr(item, name) for item in each], axis=0)
        for name in ("by", "steps", "start", "misled", "before", "left", "constant")
    )
    held, direct, own = (
        np.max(parts, axis=0) for parts in zip(*(item.first for item in each), strict=True)
    )
    return Gains(by, steps, start, misled, before, (held, direct, own), left, constant)
