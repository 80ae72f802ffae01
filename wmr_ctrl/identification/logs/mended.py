"""Corrections of a log before all else: repeated stamps, and counters that wrap."""

import math
from dataclasses import replace

import numpy as np
from scipy.ndimage import median_filter

from wmr_ctrl.world.encoder import COUNTS

from .log import WHEEL_ANGLE, Floats, Log, Note

MOST_REPEATED, ALWAYS = 0.02, 2
"""Share of rows, and their number, that may have the time of the row before."""
NEIGHBOURS = 7
"""Steps of a counter whose median is the usual one there."""
LEAST_JUMP, JUMP = 25.0, 0.5
"""Jumps of a counter in counts, and in its span."""
LEAST_EVEN, MOST_OFF, LEAST_SCATTER, ALIKE = 50, 0.45, 5e-3, 0.3
"""Rows; largest and least scatter of stamps over the period; correlation of one with the next."""
SMOOTHER = 0.9
"""Share to which an even clock lowers the roughness of the wheels' turn where it is taken."""
SURE = 2
"""Wraps that tell any modulus; one alone tells a power of two or a multiple of 1000."""


def mended(log: Log) -> Log:
    """The log with one row per time, unwrapped counters, and even stamps."""
    return evened(unwrapped(_once(log)))


def evened(log: Log) -> Log:
    """The log on an even clock, if stamps scatter about one and wheels move more smoothly on it."""
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
    if len(t) < LEAST_EVEN or not np.median(np.diff(t)) > 0:
        return None
    place = np.cumsum(np.maximum(np.rint(np.diff(t, prepend=t[0]) / np.median(np.diff(t))), 0))
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


def _once(log: Log) -> Log:
    """The log without rows that repeat the time of the row before, if they are few."""
    times, columns, most = {}, {}, 0
    for name, t in log.times.items():
        new = np.diff(t, prepend=-np.inf) != 0
        repeated = int((~new).sum())
        if repeated > max(ALWAYS, MOST_REPEATED * len(t)):
            return log
        times[name], columns[name], most = t[new], log.columns[name][new], max(most, repeated)
    if not most:
        return log
    note = Note("clocks", "", f"{most} rows with the time of the row before are left out.")
    return replace(log, times=times, columns=columns, notes=(*log.notes, note))


def unwrapped(log: Log) -> Log:
    """The log with unwrapped counters, for any modulus."""
    if not log.has(COUNTS.elements):
        return log
    columns, notes = dict(log.columns), list(log.notes)
    for name in COUNTS.elements:
        counts = log.columns[name]
        step = np.diff(counts)
        if len(step) < NEIGHBOURS or not np.isfinite(step).all():
            continue
        near = median_filter(step, NEIGHBOURS, mode="mirror")
        modulus = _modulus(counts, step, near)
        if modulus:
            whole = step - modulus * np.round((step - near) / modulus)
            columns[name] = np.concatenate((counts[:1], counts[0] + np.cumsum(whole)))
            notes.append(Note("readings", "", f"{name} wraps at {modulus:g} counts, and goes on."))
    return replace(log, columns=columns, notes=tuple(notes))


def _modulus(counts: Floats, step: Floats, near: Floats) -> float:
    """Modulus of a counter: counts after which it restarts; 0 if it does not."""
    span = float(np.ptp(counts))
    off = np.abs(step - near)
    jumps = off > max(JUMP * span, LEAST_JUMP)
    if not jumps.any():
        return 0.0
    usual = float(np.quantile(np.abs(step[~jumps]), 0.99)) if (~jumps).any() else 0.0
    rim, sizes = max(6 * usual, 2.0), off[jumps]
    ends = np.concatenate((counts[:-1][jumps], counts[1:][jumps]))
    from_rim = np.minimum(np.abs(ends - counts.min()), np.abs(ends - counts.max()))
    found = float(np.median(sizes))
    if np.ptp(sizes) > 2 * rim or from_rim.max() > rim or found > span + 2 * rim:
        return 0.0
    close = max(2 * usual, 2.0)
    binary = 2.0 ** round(math.log2(found))
    if abs(binary - found) <= close and binary > span:
        return binary
    for size in (1000.0, 100.0, 10.0, 1.0):
        rounded = max(size * round(found / size), span + 1 if size == 1 else 0.0)
        if abs(rounded - found) <= close and rounded > span:
            return rounded if size == 1000 or jumps.sum() >= SURE else 0.0
    return 0.0
