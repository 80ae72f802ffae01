"""Corrections of a log before all else: its rows, stamps, and counters that wrap.

A fault that cannot be corrected raises LogError with one paragraph: what was seen, where, what to
do.
"""

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter

from wmr_ctrl.world.encoder import COUNTS

from .log import TOGETHER, WHEEL_ANGLE, Floats, Log, LogError, Mask, Note, quick, usual_step

FEWEST_ROWS = 50
"""Least number of rows of a log."""
MOST_EMPTY = 1000
"""Longest gap, over the usual step times the number of rows."""
STEPS = (5e-4, 0.5)
"""Plausible median time between rows [s]."""
MOST_SIZE = 1e6
"""Largest number of a log in our units."""
MOST_COUNTS = 1e15
"""Largest number of counts."""
MOST_LEFT_OUT = 0.02
"""Share of rows that may be left out."""
ALWAYS = 2
"""Number of rows that may always be left out."""
ODD_ROWS = 3
"""Rows for which a counter may be far off."""
NEIGHBOURS = 7
"""Steps of a counter whose median is the usual one there."""
LEAST_JUMP, JUMP = 25.0, 0.5
"""Jumps of a counter in counts, and in its span."""
MOST_OFF = 0.45
"""Largest distance of a stamp from an even clock, over the period."""
LEAST_SCATTER = 5e-3
"""Least scatter of stamps, over the period."""
ALIKE = 0.3
"""Largest correlation of a stamp's distance with the next one's."""
SMOOTHER = 0.9
"""Share to which an even clock lowers the roughness of the wheels' turn where it is taken."""
SURE = 2
"""Wraps that tell any modulus; one alone tells a power of two or a multiple of 1000."""


def mended(log: Log) -> Log:
    """The log with one row per time, unwrapped counters, and even stamps; raises LogError."""
    log = _whole(log)
    _check_times(log)
    log = without_odd(unwrapped(log))
    _check_counters(log)
    return evened(log)


def _check_times(log: Log) -> None:
    """Check that numbers are finite, and that times increase in plausible steps."""
    for name, values in log.columns.items():
        bad = np.flatnonzero(~(np.isfinite(values) & np.isfinite(log.times[name])))
        if bad.size:
            raise LogError(
                f"{log.name}: {name} has {bad.size} values that are not numbers, the first in row "
                f"{bad[0] + 1}. Leave such cells empty, or remove the rows."
            )
        most = MOST_COUNTS if name in COUNTS.elements else MOST_SIZE
        if values.size and np.abs(values).max() > most:
            at = int(np.argmax(np.abs(values)))
            raise LogError(
                f"{log.name}: {name} is {values[at]:.3g} in row {at + 1}, beyond what a robot can "
                "do. Check its unit, or remove the row."
            )
    for name, t in log.times.items():
        _forward(log.name, name, t)


def _forward(where: str, name: str, t: Floats) -> None:
    if len(t) < FEWEST_ROWS:
        raise LogError(f"{where}: {name} has {len(t)} rows; at least {FEWEST_ROWS} are needed.")
    step = np.diff(t)
    middle = usual_step(t)
    back = np.flatnonzero(step < 0)
    if back.size:
        raise LogError(
            f"{where}: time goes back {back.size} times, first after row {back[0] + 1}, from "
            f"{t[back[0]]:.6g} to {t[back[0] + 1]:.6g} s. Perhaps two logs are in one file, or the "
            "clock was reset: cut the log there, or sort its rows if they were written out of "
            "order."
        )
    twice = np.flatnonzero(step == 0)
    if twice.size:
        raise LogError(
            f"{where}: {twice.size} rows have the time of the row before, first row {twice[0] + 2} "
            f"at {t[twice[0]]:.6g} s. Remove one of each, or write times with more digits."
        )
    if step.max() > MOST_EMPTY * middle * len(t):
        at = int(np.argmax(step))
        raise LogError(
            f"{where}: time jumps by {step[at]:.3g} s after row {at + 1}. Perhaps the clock was "
            "set: cut the log there."
        )
    if not STEPS[0] <= middle <= STEPS[1]:
        units = {1e-3: "milliseconds", 1e-6: "microseconds", 1e-9: "nanoseconds"}
        meant = [word for unit, word in units.items() if STEPS[0] <= middle * unit <= STEPS[1]]
        hint = f"it looks like {meant[0]}" if meant else "no usual unit makes sense of it"
        raise LogError(
            f"{where}: the median step of t is {middle:.4g} s; {hint}. Name the unit in the "
            "header, as in t [ms], or write seconds."
        )


def _check_counters(log: Log) -> None:
    """Check that counters neither wrap nor are reset."""
    for name in COUNTS.elements if log.has(COUNTS.elements) else ():
        t, counts = log.times[name], log.columns[name]
        step, near, _, jumps = jumps_of(t, counts)
        if not jumps.size:
            continue
        at = int(jumps[0])
        raise LogError(
            f"{log.name}: {name} jumps by {step[at]:g} from row {at + 1} to the next, at "
            f"{t[at]:.6g} s, while the steps beside it are {near[at]:g} ({jumps.size} such jumps). "
            "The counter was set back, or counts are lost: cut the log there, or mend the counter."
        )


def evened(log: Log) -> Log:
    """The log on an even clock, if its stamps scatter about one and the wheels then move more
    smoothly.
    """
    seen = next((pair for pair in (COUNTS.elements, WHEEL_ANGLE) if log.has(pair)), None)
    if seen is None:
        return log
    t, turned = log.pair(seen)
    clock = _even(t)
    if clock is None or not _rough(clock, turned) < SMOOTHER * _rough(t, turned):
        return log
    times = dict(log.times)
    for name, stamps in log.times.items():
        even = clock if np.array_equal(stamps, t) else _even(stamps)
        times[name] = stamps if even is None else even
    scatter, period = 1e3 * float(np.std(t - clock)), 1e3 * (clock[-1] - clock[0]) / (len(t) - 1)
    note = Note("clocks", "", f"stamps scatter by {scatter:.2g} ms about an even clock of "
                f"{period:.4g} ms, which is used: wheels turn more smoothly on it.")  # fmt: skip
    return replace(log, times=times, notes=(*log.notes, note))


def _even(t: Floats) -> Floats | None:
    """Times (N,) of the even clock about which the stamps scatter; None if there is none."""
    place = np.cumsum(np.rint(np.diff(t, prepend=t[0]) / usual_step(t)))
    for _ in range(2):
        period, start = np.polyfit(place, t, 1)
        place = np.rint((t - start) / period)
    off = t - np.polyval((period, start), place)
    spread = float(np.mean(off**2))
    if (np.diff(place) < 1).any() or np.abs(off).max() > MOST_OFF * period:
        return None
    if not spread > (LEAST_SCATTER * period) ** 2 or off[1:] @ off[:-1] > ALIKE * off @ off:
        return None
    return np.asarray(np.polyval((period, start), place))


def _rough(t: Floats, turned: Floats) -> float:
    """Mean square difference between readings (N, 2) and the line through their neighbours."""
    share = ((t[1:-1] - t[:-2]) / np.maximum(t[2:] - t[:-2], 1e-300))[:, None]
    return float(np.mean((turned[1:-1] - (1 - share) * turned[:-2] - share * turned[2:]) ** 2))


def _whole(log: Log) -> Log:
    """The log without the few rows that have no number or repeat the time of the row before."""
    keep = {}
    for name, t in log.times.items():
        group = next((item for item in TOGETHER if name in item), (name,))
        read = [log.columns[item] for item in group if item in log.columns]
        keep[name] = (np.diff(t, prepend=-np.inf) != 0) & ~np.isnan([t, *read]).any(axis=0)
    return _of_rows(log, keep, "rows with no number, or the time of the row before,", "clocks")


def _of_rows(log: Log, keep: Mapping[str, Mask], what: str, key: str) -> Log:
    """The log with only the given rows of each column, if few are removed."""
    most = max((int((~rows).sum()) for rows in keep.values()), default=0)
    few = all((~rows).sum() <= max(ALWAYS, MOST_LEFT_OUT * len(rows)) for rows in keep.values())
    if not (most and few):
        return log
    times, columns = (
        {name: x[keep[name]] if name in keep else x for name, x in of.items()}
        for of in (log.times, log.columns)
    )
    note = Note(key, "", f"{most} {what} are left out.")
    return replace(log, times=times, columns=columns, notes=(*log.notes, note))


class Jumps(NamedTuple):
    """Steps (N - 1,) of a counter, in counts per even row, and the rows before its jumps.

    A jump is a step farther than ``limit`` from the ``usual`` one.
    """

    steps: Floats
    usual: Floats
    limit: float
    rows: NDArray[np.int64]


def jumps_of(t: Floats, counts: Floats) -> Jumps:
    """Jumps of a counter, between rows that lie as close as usual."""
    gap, period = np.diff(t), usual_step(t)
    step, even = np.diff(counts) * period / gap, gap < 1.5 * period
    near = median_filter(step, 5, mode="nearest")
    off = np.abs(step - near)
    limit = max(12 * quick(off[even], 0.98), 25.0, 0.5 * quick(step[even], 0.99))
    return Jumps(step, near, limit, np.flatnonzero(even & (off > limit)))


def without_odd(log: Log) -> Log:
    """The log without counts that go out and come back within some rows."""
    if not log.has(COUNTS.elements):
        return log
    keep = np.ones(len(log.times[COUNTS.elements[0]]), bool)
    for name in COUNTS.elements:
        counts = log.columns[name]
        _, usual, limit, rows = jumps_of(log.times[name], counts)
        for before, last in zip(rows[:-1].tolist(), rows[1:].tolist(), strict=True):
            moved = counts[last + 1] - counts[before] - usual[before : last + 1].sum()
            if last - before <= ODD_ROWS and abs(moved) <= limit:
                keep[before + 1 : last + 1] = False
    kept = dict.fromkeys(COUNTS.elements, keep)
    return _of_rows(log, kept, "counts are single rows far off, and", "readings")


def unwrapped(log: Log) -> Log:
    """The log with unwrapped counters, for any modulus."""
    if not log.has(COUNTS.elements):
        return log
    columns, notes = dict(log.columns), list(log.notes)
    for name in COUNTS.elements:
        counts = log.columns[name]
        step = np.diff(counts)
        near = median_filter(step, NEIGHBOURS, mode="mirror")
        modulus = _modulus(counts, step, near)
        if modulus:
            columns[name] = np.unwrap(counts, period=modulus)
            notes.append(Note("readings", "", f"{name} wraps at {modulus:g} counts, and goes on."))
    return replace(log, columns=columns, notes=tuple(notes))


def _modulus(counts: Floats, step: Floats, near: Floats) -> float:
    """Modulus of a counter: counts after which it restarts; 0 if it does not."""
    span = float(np.ptp(counts))
    off = np.abs(step - near)
    jumps = off > max(JUMP * span, LEAST_JUMP)
    if not jumps.any():
        return 0.0
    usual = quick(step[~jumps], 0.99) if (~jumps).any() else 0.0
    rim, sizes = max(6 * usual, 2.0), off[jumps]
    ends = np.concatenate((counts[:-1][jumps], counts[1:][jumps]))
    from_rim = np.minimum(np.abs(ends - counts.min()), np.abs(ends - counts.max()))
    found = float(np.median(sizes))
    if np.ptp(sizes) > 2 * rim or from_rim.max() > rim:
        return 0.0
    close = max(2 * usual, 2.0)
    tried = [2.0 ** round(math.log2(found)), 1e3 * round(found / 1e3)]
    tried += [max(round(found), span + 1)] if jumps.sum() >= SURE else []
    return next((x for x in tried if abs(x - found) <= close and x > span), 0.0)
