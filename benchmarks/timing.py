"""Ratios by interleaved rounds: what two pieces of code cost relative to each other.

A shared machine's speed drifts by up to a factor of two, so times of different moments cannot be
compared.  Each round therefore runs every candidate once, in an order that rotates, and only
ratios within one round are taken; the median over rounds (and processes) is what is reported.
The clock is the process's own processor time, which stands still while others are at work.
"""

from __future__ import annotations

import multiprocessing
import os
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from statistics import median, quantiles

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


def measure(
    candidates: Mapping[str, Candidate],
    floor: str,
    *,
    rounds: int = ROUNDS,
    progress: Progress | None = None,
) -> dict[str, Timing]:
    """Time all candidates in this process, one round of warming up first.

    Parameters
    ----------
    candidates
        By name; each should take some 10 ms, so that the clock and the call do not count.
    floor
        Name of the candidate that the others are divided by.
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
    return summarize(sample(candidates, rounds, progress), floor)


def measure_in_processes(
    factory: Factory,
    floor: str,
    *,
    processes: int = 3,
    rounds: int = ROUNDS,
    progress: Progress | None = None,
) -> dict[str, Timing]:
    """Do the same in fresh processes, one after the other, and pool the rounds.

    Memory layout differs from process to process and can cost more than the rounds' spread
    shows.  ``factory`` is a module-level function that builds the candidates in each process.
    """
    pooled: dict[str, list[float]] = {}
    context = multiprocessing.get_context("spawn")
    for done in range(processes):
        with context.Pool(1) as pool:
            times = pool.apply(_sample_of, (factory, floor, rounds))
            pool.close()  # let it end by itself and take its temporary folder with it
            pool.join()
        for name, values in times.items():
            pooled.setdefault(name, []).extend(values)
        if progress:
            progress(rounds * (done + 1), rounds * processes)
    return summarize(pooled, floor)


def sample(
    candidates: Mapping[str, Candidate], rounds: int, progress: Progress | None = None
) -> dict[str, list[float]]:
    """Return nanoseconds per step of every candidate in every round."""
    names = list(candidates)
    times: dict[str, list[float]] = {name: [] for name in names}
    for item in candidates.values():
        item.run()
    for number in range(rounds):
        first = number % len(names)
        for name in names[first:] + names[:first]:
            times[name].append(_nanoseconds(candidates[name]))
        if progress:
            progress(number + 1, rounds)
    return times


def summarize(times: Mapping[str, list[float]], floor: str) -> dict[str, Timing]:
    """Divide round by round by the floor, then take medians and quartiles."""
    return {name: _timing(name, values, times[floor]) for name, values in times.items()}


def _timing(name: str, values: list[float], base: list[float]) -> Timing:
    ratios = tuple(value / unit for value, unit in zip(values, base, strict=True))
    low, _, high = quantiles(ratios, n=4, method="inclusive") if len(ratios) > 1 else ratios * 3
    return Timing(name, median(values), median(ratios), low, high, ratios)


def _nanoseconds(candidate: Candidate) -> float:
    start = clock()
    candidate.run()
    return (clock() - start) / candidate.steps


def _sample_of(factory: Factory, floor: str, rounds: int) -> dict[str, list[float]]:
    candidates = factory()
    _check(candidates, floor, rounds)
    return sample(candidates, rounds)


def _check(candidates: Mapping[str, Candidate], floor: str, rounds: int) -> None:
    if rounds < ROUNDS:
        raise ValueError(f"{rounds} rounds are too few for a median; take at least {ROUNDS}.")
    if floor not in candidates:
        raise ValueError(f"no candidate is named {floor!r}; there are {', '.join(candidates)}.")
