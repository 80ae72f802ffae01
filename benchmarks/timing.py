"""Ratios by interleaved rounds: what two pieces of code cost relative to each other.

A shared machine's speed drifts by up to a factor of two, so times of different moments cannot be
compared.  Each round therefore runs every candidate once, in an order that rotates, and only
ratios within one round are taken; the median over rounds (and processes) is what is reported.
The clock is the process's own processor time, which stands still while others are at work.
A candidate that raises is left out where the caller passes ``failed``, a dictionary that takes its
reason by its name.
"""

from __future__ import annotations

import multiprocessing
import os
import time
from collections.abc import Callable, Mapping
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial
from statistics import median, quantiles

from wmr_ctrl.core.errors import WmrError

ROUNDS = 9
"""Fewest rounds whose median is reported."""

clock = time.perf_counter_ns if os.name == "nt" else time.process_time_ns
"""Nanoseconds.  Windows counts a process's time in ticks of 16 ms, too coarse for a round."""

Progress = Callable[[int, int], None]
Factory = Callable[[], Mapping[str, "Candidate"]]


@dataclass(frozen=True)
class Candidate:
    """Something to time: ``run()`` performs ``steps`` steps inside compiled or Python code."""

    run: Callable[[], object]
    steps: int


@dataclass(frozen=True)
class Timing:
    """Cost of one step: ``ns`` (median, nanoseconds, for the record) and its ratio to the floor.

    ``low`` and ``high`` are the quartiles of the per-round ratios in ``ratios``.
    """

    name: str
    ns: float
    ratio: float
    low: float
    high: float
    ratios: tuple[float, ...]


Builders = Mapping[str, Callable[[], Candidate]]
"""Functions that build candidates, by their names."""


def built(builders: Builders) -> dict[str, Candidate]:
    """Build all candidates; one that cannot be built raises its error when it is run."""
    candidates = {}
    for name, build in builders.items():
        try:
            candidates[name] = build()
        except Exception as error:  # of a package, a compiler or what is measured
            candidates[name] = Candidate(partial(_raise, error), 1)
    return candidates


def _raise(error: Exception) -> None:
    raise error


def reason(error: Exception) -> str:
    """The first sentence of an error, in one line."""
    said = " ".join(str(error).split()).partition(". ")[0].rstrip(".")[:200]
    return said if isinstance(error, WmrError) else f"{type(error).__name__}: {said}"


def measure(
    candidates: Mapping[str, Candidate],
    floor: str,
    *,
    rounds: int = ROUNDS,
    progress: Progress | None = None,
    failed: dict[str, str] | None = None,
) -> dict[str, Timing]:
    """Time all candidates in this process, one round of warming up first.

    Parameters
    ----------
    candidates
        By name; each should take some 10 ms, so that the clock and the call do not count.
    floor
        Name of the candidate that the others are divided by; the first one left if it failed.
    rounds
        At least `ROUNDS`.
    progress
        Called with (rounds done, rounds in all).

    Raises
    ------
    ValueError
        If there are too few rounds or no candidate is named ``floor``.
    """
    _check(candidates, floor, rounds)
    return summarize(sample(candidates, rounds, progress, failed), floor)


def measure_in_processes(
    factory: Factory,
    floor: str,
    *,
    processes: int = 3,
    rounds: int = ROUNDS,
    progress: Progress | None = None,
    failed: dict[str, str] | None = None,
) -> dict[str, Timing]:
    """Measure candidates in fresh processes, one after the other, and pool the rounds.

    Memory layout differs from process to process and can cost more than the rounds' spread
    shows.  ``factory`` is a module-level function that builds the candidates in each process.
    """
    pooled: dict[str, list[float]] = {}
    context = multiprocessing.get_context("spawn")
    for done in range(processes):
        with ProcessPoolExecutor(1, context) as pool:
            times, reasons = pool.submit(
                _sample_of, factory, floor, rounds, failed is not None
            ).result()
        if failed is not None:
            failed |= reasons
        for name, values in times.items():
            pooled.setdefault(name, []).extend(values)
        if progress:
            progress(rounds * (done + 1), rounds * processes)
    left = {name: values for name, values in pooled.items() if name not in (failed or ())}
    return summarize(left, floor)


def sample(
    candidates: Mapping[str, Candidate],
    rounds: int,
    progress: Progress | None = None,
    failed: dict[str, str] | None = None,
) -> dict[str, list[float]]:
    """Return nanoseconds per step of every candidate in every round."""
    times: dict[str, list[float]] = {}
    for name, item in candidates.items():
        try:
            item.run()
        except Exception as error:
            if failed is None:
                raise
            failed[name] = reason(error)
        else:
            times[name] = []
    names = list(times)
    for number in range(rounds if names else 0):
        first = number % len(names)
        for name in names[first:] + names[:first]:
            times[name].append(_nanoseconds(candidates[name]))
        if progress:
            progress(number + 1, rounds)
    return times


def summarize(times: Mapping[str, list[float]], floor: str) -> dict[str, Timing]:
    """Divide round by round by the floor, then take medians and quartiles."""
    base = floor if floor in times else next(iter(times), floor)
    return {name: _timing(name, values, times[base]) for name, values in times.items()}


def _timing(name: str, values: list[float], base: list[float]) -> Timing:
    ratios = tuple(value / unit for value, unit in zip(values, base, strict=True))
    low, _, high = quantiles(ratios, n=4, method="inclusive") if len(ratios) > 1 else ratios * 3
    return Timing(name, median(values), median(ratios), low, high, ratios)


def _nanoseconds(candidate: Candidate) -> float:
    start = clock()
    candidate.run()
    return (clock() - start) / candidate.steps


def _sample_of(
    factory: Factory, floor: str, rounds: int, tolerant: bool
) -> tuple[dict[str, list[float]], dict[str, str]]:
    candidates, failed = factory(), dict[str, str]()
    _check(candidates, floor, rounds)
    return sample(candidates, rounds, None, failed if tolerant else None), failed


def _check(candidates: Mapping[str, Candidate], floor: str, rounds: int) -> None:
    if rounds < ROUNDS:
        raise ValueError(f"{rounds} rounds are too few for a median; take at least {ROUNDS}.")
    if floor not in candidates:
        raise ValueError(f"no candidate is named {floor!r}; there are {', '.join(candidates)}.")
