"""Rows and commands of a log that a fit may use, without odd readings and switched-off drives.

Each row is compared with a quick first-order fit; excluded readings are replaced by a straight line
between their neighbours, so that no later step sees them.
"""

import math
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
from scipy.ndimage import median_filter, percentile_filter

from ..speed_loop import LOOPS, LoopFit, fitted
from .log import AXES, Floats, LeftOut, Mask, Note, Pair, quick, usual_step
from .samples import AxisLog, Samples, axis_log

LOOP, PASSES = "first-order", 8
MOST_ODD = 0.15
"""Share of readings beyond which they are the log and no faults of it."""
FAR = 8.0
"""Least distance of an odd reading from its neighbours, over their usual deviation."""
LEAST_FAR = 0.12
"""Least distance of an odd reading, over the log's quick speeds."""
STEPS_FAR = 2.5
"""Least distance of an odd reading, in steps of its resolution."""
ZERO_DEVIATIONS = 5.0
"""Least deviation of an odd reading of exactly 0; see FAR."""
ZERO_FAR = 0.05
"""Least distance of an odd reading of exactly 0; see LEAST_FAR."""
BACK = 0.6
"""Share of the distance by which the reading itself must go out and come back."""
NEIGHBOURS = 7
"""Rows of the running median."""
ODD_ROWS = 2
"""Longest run of odd readings, in rows."""
ZERO_ROWS = 5
"""Longest run of readings of 0 among them, in rows."""
REST = 2.0
"""Time at rest from which on the drivers are off [s]."""
LEAST_EXPECTED = 0.25
"""Least mean speed expected in that time, over the quick ones'."""
LEAST_CHANGES = 2
"""Least number of changes of the command in that time."""
LEVELS = 8
"""Groups of commands of similar size."""
USUAL = 70
"""Percentile of a group's speeds that is its usual speed."""
BEFORE_OFF = 0.3
"""Time before such a stretch that is left out, too [s]."""
BEHIND_OFF = 1.0
"""Time after such a stretch that is left out, too [s]."""
LEAST_SILENCE = 0.3
"""Shortest silence of commands beyond their period [s]."""
PERIODS_SILENT = 6.0
"""Shortest silence of commands, in their periods."""
LIKELIER = 20.0
"""Gain of twice the log-likelihood from which on a time-out is taken."""
COARSE, FINE, LONGEST_TIMEOUT = 0.1, 0.02, 4.0
"""Steps of the search for a time-out, and its longest [s]."""


@dataclass(frozen=True)
class Rows:
    """Usable samples, the stretches that were left out, and remarks.

    ``samples.use`` (N, 2) marks the readings to use, and ``samples.command`` has the zeros that a
    base inserts ``timeout`` [s] after its last command, None if commands never cease.
    """

    samples: Samples
    timeout: float | None = None
    left_out: tuple[LeftOut, ...] = ()
    notes: tuple[Note, ...] = ()


def usable(samples: Samples, timeout: float | None = None, base: str = "velocity") -> Rows:
    """Usable rows and commands of a base; of one that takes torques only readings are judged.

    ``timeout``: the base's own [s], if it is known.
    """
    notes: list[Note] = []
    driven = [axis for axis in (0, 1) if np.std(samples.command[:, axis]) > 1e-3]
    t, seen, use = samples.t, samples.seen.copy(), np.ones(samples.seen.shape, bool)
    for axis in driven if samples.of_speed else ():
        log = axis_log(samples, axis)
        if log.in_fit.sum() < 5 * NEIGHBOURS:
            continue
        odd = odd_readings(log.speed, quick_fit(log).left if base == "velocity" else log.speed)
        share, kept = float(odd.mean()), ~odd
        if 0 < share <= MOST_ODD:
            use[:, axis] = kept
            seen[odd, axis] = np.interp(t[odd], t[kept], seen[kept, axis])
            text = (
                f"{odd.sum()} readings of {AXES[axis]} are single rows far off ({100 * share:.2g} "
                f"%, the first at {t[np.argmax(odd)]:.4g} s) and left out."
            )
            notes.append(Note("readings", AXES[axis], text))
    left_out = [
        LeftOut(float(t[low]), float(t[high - 1]), f"readings of {name} far off")
        for name, kept in zip(AXES, use.T, strict=True)
        for low, high in _runs(~kept)
    ]
    rows = replace(samples, seen=seen, use=use)
    if base == "velocity":
        rows, timeout = _with_silences(rows, driven, timeout, notes)
        for begin, end in off_stretches(rows):
            use[(t >= begin) & (t <= end)] = False
            left_out.append(LeftOut(begin, end, "commanded but at rest"))
            off = f"{begin + BEFORE_OFF:.3g} to {end - BEHIND_OFF:.3g} s: drivers off?"
            notes.append(Note("drivers-off", "", f"commanded but at rest from {off} Left out."))
    return Rows(rows, timeout, tuple(left_out), tuple(notes))


def quick_fit(log: AxisLog) -> LoopFit:
    """Fit of a first-order loop by least squares."""
    gain, shift, _ = log.follows
    start = math.log(max(abs(gain), 1e-3)), math.log(0.1), min(max(shift - 0.05, 0.005), 0.3)
    return fitted(log, LOOP, LOOPS[LOOP], np.array(start), PASSES, PASSES)


def odd_readings(speed: Floats, left: Floats) -> Mask:
    """Mask (N,) of readings that leave their neighbours for a moment.

    ``left`` (N,) is the residual of a fit: motion that the fit explains is not odd.
    """
    fast, steps = quick(speed), np.abs(np.diff(speed))
    steps = steps[steps > 1e-9 * fast]
    quantum = STEPS_FAR * float(np.median(steps)) if len(steps) > 10 else 0.0
    zero = (speed == 0) & (np.abs(speed - left) > max(ZERO_FAR * fast, quantum))
    off, odd = left - median_filter(left, NEIGHBOURS, mode="nearest"), np.zeros(len(speed), bool)
    spread = 1.4826 * float(np.median(np.abs(off - np.median(off))))
    far = np.abs(off) > max(FAR * spread, LEAST_FAR * fast, quantum)
    far |= zero & (np.abs(off) > max(ZERO_DEVIATIONS * spread, ZERO_FAR * fast, quantum))
    for low, high in _runs(far):
        if low == 0 or high == len(speed):
            continue
        own, beside, run = slice(low, high), [low - 1, high], high - low
        # A 0 between readings of both signs is on the way from one to the other.
        one_way = abs(float(np.sign(speed[beside]).sum())) == len(beside)
        lost = zero[own] & one_way & (np.abs(speed[beside]).min() > 0.8 * ZERO_FAR * fast)
        # From both neighbours, of the reading itself and of what the fit leaves.
        apart = np.array([x[own] - x[beside][:, None] for x in (speed, left)])
        back = np.abs(apart).min(axis=(0, 1)) >= BACK * np.abs(off[own])
        back &= (apart.prod(axis=1) > 0).all(axis=0)
        odd[own] = (lost & (run <= ZERO_ROWS)) | (back & (run <= ODD_ROWS))
    return odd


def off_stretches(rows: Samples) -> list[Pair]:
    """Begin and end [s] of stretches at rest although commands would move the base."""
    t, resting = rows.t, np.ones(len(rows.t), bool)
    at = np.searchsorted(rows.command_t, t - 0.2, "right") - 1
    sent = np.abs(np.where((at >= 0)[:, None], rows.command[np.maximum(at, 0)], 0.0))
    expected = np.zeros(len(t))
    for axis in (0, 1):
        speed, command = np.abs(axis_log(rows, axis).speed), sent[:, axis]
        fast, moves = quick(speed), np.flatnonzero(command)
        if not (fast > 0 and moves.size):
            continue
        # The speed at commands of about this size, of which some may be those of an off base.
        moves = moves[np.argsort(command[moves])]
        usual = percentile_filter(speed[moves], USUAL, 1 + moves.size // LEVELS, mode="nearest")
        expected[moves] = np.maximum(expected[moves], usual / fast)
        still = speed[command == 0]
        noise = 2 * quick(still, 0.9) if still.size > 20 else 0.0
        resting &= speed <= np.clip(noise, 0.01 * fast, 0.04 * fast)
    found = []
    changed = np.any(np.diff(sent, axis=0, prepend=sent[:1]) != 0, axis=1)
    for low, high in _runs(resting, max(round(0.2 / usual_step(t)), 1)):
        enough = changed[low:high].sum() >= LEAST_CHANGES
        if enough and t[high - 1] - t[low] > REST and expected[low:high].mean() > LEAST_EXPECTED:
            found.append((float(t[low]) - BEFORE_OFF, float(t[high - 1]) + BEHIND_OFF))
    return found


def _with_silences(
    rows: Samples, driven: list[int], known: float | None, notes: list[Note]
) -> tuple[Samples, float | None]:
    """The samples with zero commands after the base's time-out, and that time-out [s]."""
    sent = rows.command_t
    usual = usual_step(sent)
    silent = np.diff(sent, append=max(rows.t[-1], sent[-1]))
    silent = np.where(silent > max(PERIODS_SILENT * usual, LEAST_SILENCE), silent, 0.0)
    silent[~rows.command.any(axis=1)] = 0.0
    if not silent.any():
        return rows, None
    times = int(np.sum(silent > 0))
    count = f"commands cease {f'{times} times' if times > 1 else 'once'}"
    if known is not None and math.isfinite(known):
        return _stopped(rows, silent, known), known

    @cache
    def score(timeout: float) -> float:
        return _misfit(_stopped(rows, silent, timeout), driven)

    longest = min(LONGEST_TIMEOUT, float(np.median(silent[silent > 0])))
    best = min((*np.arange(COARSE, longest, COARSE).tolist(), math.inf), key=score)
    if not score(best) < score(math.inf) - LIKELIER:
        notes.append(Note("timeout", "", f"{count}, and the base goes on with the last one."))
        return rows, None
    near = np.arange(max(best - COARSE, FINE), best + COARSE + FINE / 2, FINE)
    best = min(near.tolist(), key=score)
    stop = f"the base stops {best:.2f} s after the last one: base.timeout."
    notes.append(Note("timeout", "", f"{count}; {stop}"))
    return _stopped(rows, silent, best), best


def _misfit(rows: Samples, driven: list[int]) -> float:
    """Twice the negative log-likelihood of a quick fit."""
    total = 0.0
    for axis in driven:
        log = axis_log(rows, axis)
        if log.in_fit.any():
            left = quick_fit(log).left[log.in_fit]
            total += len(left) * math.log(max(float(np.mean(left**2)), 1e-300))
    return total


def _stopped(rows: Samples, silent: Floats, timeout: float) -> Samples:
    """The samples with a zero command ``timeout`` [s] into each longer silence (M,) [s]."""
    long = np.flatnonzero(silent > timeout)
    times = np.insert(rows.command_t, long + 1, rows.command_t[long] + timeout)
    return replace(rows, command_t=times, command=np.insert(rows.command, long + 1, 0.0, axis=0))


def _runs(mask: Mask, bridge: int = 0) -> list[list[int]]:
    """Begin and end indices of runs of True; gaps of at most ``bridge`` rows are closed."""
    ends = np.flatnonzero(np.diff(mask, prepend=False, append=False))
    begin, end = ends[::2], ends[1::2]
    bridged = np.flatnonzero(begin[1:] - end[:-1] < bridge)
    return np.column_stack((np.delete(begin, bridged + 1), np.delete(end, bridged))).tolist()
