"""Windows of time and of samples in which runs are judged, and whether a run lasted through them.

A path that stops is judged in two windows: its drive, without the first half, in which the start
decays; and the time after its arrival.  An endless motion is judged at the end of the run.  So a
longer rest hides no error of the drive.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from .settings import Settings

if TYPE_CHECKING:
    from .run import Run

Span = tuple[int, int]
WINDOWS: tuple[Span, ...] = ((30, 40), (40, 45), (70, 80))
"""Before, just after and long after the paper's change of parameters [s]."""
BEFORE, LATE = WINDOWS[0], WINDOWS[-1]


def named(span: Span) -> str:
    """Suffix of the name of a figure over a window."""
    return f"{span[0]}_{span[1]}"


def seconds(start: float, end: float) -> str:
    """A window of time as text."""
    return f"{start:g}–{end:g} s"


def window(run: Run, start: float, end: float | None = None) -> slice | None:
    """Rows k with ``start`` <= t_k < ``end`` [s], or None if the run does not cover them all.

    Samples are counted, not compared as floats, so adjacent windows share no sample.  Without
    ``end``, all later rows, never None, also if the run ended early.
    """
    first = run.settings.index(start)
    if end is None:
        return slice(min(max(0, first), run.rows), run.rows)
    last = run.settings.index(end)
    return slice(first, last) if 0 <= first <= last <= covered(run) else None


def covered(run: Run) -> int:
    """Number of complete sample periods of the run.

    A run that ends between two samples has logged the sample before, but not completed its period.
    """
    if run.monitor.stopped is None:
        return run.rows
    time, _ = run.monitor.stopped
    return min(run.rows, math.floor(time / run.settings.control + 1e-6))


def last_quarter(settings: Settings) -> Span:
    """Samples [first, end) of the last quarter of a whole run."""
    return 3 * settings.samples // 4, settings.samples


def drive(settings: Settings) -> Span:
    """Samples [first, end) in which driving is judged: the last quarter of an endless motion.

    For a path that stops, all samples after half of the time of its arrival.
    """
    if settings.arrival is None:
        return last_quarter(settings)
    goal = settings.index(settings.arrival)
    return goal // 2, min(goal, settings.samples)


def robots_over(settings: Settings, start: float = 0.0, end: float = math.inf) -> str:
    """The robots that drive in [start, end) [s], as "50 kg, from 40 s on 65 kg".

    Empty if the robot never changes.
    """
    grid, robots = 1e-6 * settings.control, settings.robots
    ends = [*(time for time, _ in robots[1:]), math.inf]
    there = [item for item, last in zip(robots, ends, strict=False)
             if item[0] < end - grid and last > start + grid]  # fmt: skip
    words = [text if place == 0 else f"from {time:g} s on {text}"
             for place, (time, text) in enumerate(there)]  # fmt: skip
    return ", ".join(words)


def driving(run: Run) -> str:
    """Text on the window of the drive, with its robot if that changes."""
    name = "drive" if run.settings.arrival is not None else "last quarter"
    return _told(name, run.settings, drive(run.settings))


def _told(name: str, settings: Settings, samples: Span) -> str:
    """A window's name, with its times if the path stops or the robot changes."""
    first, end = (sample * settings.control for sample in samples)
    robots = robots_over(settings, first, end)
    if settings.arrival is None and not robots:
        return name
    return f"{name} ({first:.4g} to {end:.4g} s{': ' * bool(robots)}{robots})"


def at_rest(settings: Settings) -> Span:
    """Samples [first, end) after the arrival of a path that stops; empty without one."""
    goal = settings.samples if settings.arrival is None else settings.index(settings.arrival)
    return min(goal, settings.samples), settings.samples


def working(settings: Settings) -> Span:
    """Samples [first, end) in which torques are judged, without the very first sample.

    The last half of an endless motion, or the drive of a path that stops.
    """
    first, end = drive(settings)
    return max(settings.samples // 2 if settings.arrival is None else first, 1), end


def labouring(run: Run) -> str:
    """Text on the window in which torques are judged."""
    if run.settings.arrival is not None:
        return driving(run)
    return _told("last half", run.settings, working(run.settings))


def rows_of(run: Run, samples: Span) -> slice | None:
    """The rows of a window of samples; None if the run does not cover it or it is empty."""
    first, end = samples
    return slice(first, end) if first < end <= covered(run) else None


def windows_of(settings: Settings) -> dict[str, Span]:
    """Windows of samples over which a loop without a log accumulates sums, by name."""
    end, split = settings.samples, settings.index(settings.split)
    return {
        "all": (0, end),
        "before": (0, split),
        "after": (split, end),
        "torque": (settings.index(settings.rms_from), end),
        "last_quarter": last_quarter(settings),
        "working": working(settings),
        "drive": drive(settings),
        "end": at_rest(settings),
        **{named(span): (settings.index(span[0]), settings.index(span[1])) for span in WINDOWS},
    }
