"""Enclosed peak gains of the sampled loop: largest linear outputs under bounded inputs.

The matrix A of a sample has a ball for each entry.  Its powers are computed with as many bits as
the growth of |A|^k requires, so no diagonalising coordinates are needed.  With q = ||A^K|| < 1 in a
weighted norm, which is computed, all terms after K samples are at most q/(1-q) times those before.
Sums are of absolute values in doubles, with their rounding added.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import ceil, cos, log, log2, pi, sin

import numpy as np
from flint import arb, ctx

from wmr_ctrl.theory.checks.error_coordinates import COMMAND, ROBOT, Floats

from .loop import UP, SampledLoop
from .reckoning import Reckoning
from .responses import Gains, Responses, largest, stacked
from .sample import (
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

LEFT = 1e-6
"""Size of A^K at which the sums end."""
FAINTEST = 0.1
"""Largest size of A^K with which they may end."""
MOST_SAMPLES = 12_000
"""Largest number of samples; all three limits together take some 4 s of CPU."""
MOST_BITS = 30_000
"""Largest number of bits."""
MOST_STEPS = 100_000
"""Largest number of plant steps in those samples."""
SPARE_BITS = 320
DIRECTIONS = 16
PAIRS = [(a, b) for a in range(ROBOT) for b in range(a + 1, ROBOT)]


@dataclass(frozen=True)
class LoopGains:
    """Gains of the fast state at all plant steps, of the state at samples, and of the law's
    outputs.

    Rows of ``fast``: its elements; directions of (e1, e2); for each of PAIRS the sum and the
    difference of its first element and ``ratios`` times its second; and, if requested, the error of
    dead reckoning over one, two and more samples (3 each).  ``damping`` is q, over ``samples``;
    ``scale``: the weights of its norm.
    """

    fast: Gains
    state: Gains
    law: Gains
    ratios: Floats
    damping: float
    samples: int
    scale: Floats

    def nearer(self, share: float) -> LoopGains:
        """Gains for a share of the initial deviation, on which the responses depend linearly."""
        fast, state, law = (
            replace(item, start=item.start * share * UP)
            for item in (self.fast, self.state, self.law)
        )
        return replace(self, fast=fast, state=state, law=law)


def loop_gains(
    loop: SampledLoop, start: Floats, added: Floats, reckoning: Reckoning | None = None
) -> LoopGains:
    """All gains of a loop, for initial deviations by shares of the columns ``start`` (n, columns).

    ``added``: constant increment of the fast state in every plant step.  With a ``reckoning`` also
    its error (3) over one sample and more.  Raises SlowLoopError if the loop is unstable or too
    slow to be enclosed.
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
        return _summed(SampleMatrices(loop), loop, samples, start, added, reckoning)


def _samples(a: Floats) -> tuple[int, float]:
    """Estimated number of samples until A^K is small, and growth of |A|^k; no bound depends on
    them.
    """
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
    reckoning: Reckoning | None,
) -> LoopGains:
    n, nz = sample.n, len(loop.names)
    powers, summed, last = powers_until(sample.A, samples)
    measured = sample.outputs @ sample.seen
    inputs = np.hstack([sample.push, sample.outputs, sample.late, measured])
    every = np.hstack([np.eye(n), doubles(inputs)])
    columns, which = np.unique(every, axis=1, return_inverse=True)
    course, which = powers @ columns, which.ravel()
    scale = np.abs(course[:, :, which[n : n + COMMAND]]).sum(axis=(0, 2))
    scale = scale + 1e-9 * scale.max()
    left = np.abs(last)
    damping = float((left @ scale / scale).max()) * UP
    if damping > FAINTEST:
        raise SlowLoopError(f"a share of {damping:.2g} is left after {samples} samples")
    ratios = np.array([scale[a] / scale[b] for a, b in PAIRS])
    picked, blank = fast_rows(nz, DIRECTIONS, PAIRS, ratios), np.zeros((n, n))
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
    norms = _weighed(course, summed @ np.abs(columns), scale)[:, which]
    off = summed @ np.abs(whole_sample)
    rest = _weighed(steady[..., None], off[..., None], scale).sum()
    estimate = n - loop.acting - loop.filter if loop.filter else None
    old = nz + COMMAND * loop.queue + loop.observed[1] if loop.observed else None
    sums = Responses(
        course, whole, np.abs(every), norms, scale, damping, n, steps, start, estimate, old,
        steady, off.sum(axis=0), float(rest), which,
    )  # fmt: skip
    within = [sums.gains(sample.rows_within(s, picked), shares[s]) for s in range(loop.steps)]
    shown, late = doubles(sample.law), sample.late.shape[1]
    count = len(shown)
    none = {"push": blank[:, :COMMAND], "measured": np.zeros((n, ROBOT)), "steps": blank[:, :nz],
            "late": np.zeros((n, late))}  # fmt: skip
    state = OutputRows(np.eye(n), np.eye(n), law=np.zeros((n, count)), **none)
    law = OutputRows(
        np.eye(count), shown, np.zeros((count, COMMAND)), np.eye(count), np.zeros((count, late)),
        np.abs(doubles(sample.seen)) * UP, np.zeros((count, nz)),
    )  # fmt: skip
    fast = largest(within)
    if reckoning and reckoning.row_samples:
        reckoned = sample.reckoned_rows(loop), reckoning.turning
        fast = stacked([fast, *sums.carried(*reckoned, shares[-1], reckoning.row_samples)])
    three = fast, sums.gains(state), sums.gains(law)
    return LoopGains(*three, ratios, damping, samples, scale)


def _weighed(course: Floats, size: Floats, scale: Floats) -> Floats:
    """Weighted norms (samples, inputs) of sums of a given ``size``, with their rounding."""
    norms: Floats = ((np.abs(course) + ROUNDING * size) / scale[:, None]).max(axis=1)
    return norms


def fast_rows(nz: int, directions: int, pairs: list[tuple[int, int]], ratios: Floats) -> Floats:
    """Elements of the fast state, directions of (e1, e2), sums and differences of pairs."""
    turns = [k * pi / directions for k in range(directions)]
    rows = [*np.eye(nz), *(_row(nz, (0, cos(t)), (1, sin(t))) for t in turns)]
    for (a, b), ratio in zip(pairs, ratios, strict=True):
        rows += [_row(nz, (a, 1.0), (b, sign * ratio)) for sign in (1, -1)]
    return np.array(rows)


def _row(size: int, *entries: tuple[int, float]) -> Floats:
    row = np.zeros(size)
    for place, value in entries:
        row[place] = value
    return row
