"""Whether a fit of one axis explains its log, and by how much its intervals are widened if not.

The questions are: do commands predict more of the residual; is the gain the same for all speeds,
directions and times; is each number constant, and each delay; how large is the rest, and is the fit
better than a constant?  All effects are shares of the speed, so no distribution is assumed.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from wmr_ctrl.core.data import data

from .fit import Fitted, changes
from .kalman import BLOCKS, blocks_of
from .logs.log import AXES, UNITS, Floats, Pair, quick, unit_of, usual_step
from .logs.samples import AxisLog
from .speed_loop import LINEAR, NEUTRAL, LoopFit, foretold, whitener

LEVELS = EXPLAINED, IN_PART, NOT_EXPLAINED = "explained", "in part", "not explained"
MORE_TOLD = 0.04
"""Share of the speed's rms, foretold beyond the model, above which it explains only a part."""
MOST_TOLD = 0.12
"""Share of the speed's rms, predicted beyond the model, above which it explains nothing."""
BY_OTHER = 2.0
"""Factor by which the other axis must add to what commands tell to be named."""
APART = 2.0
"""Difference of a group's gain from the others, in half-widths, that counts as different."""
LEAST_APART = 0.03
"""Share of the gain by which a group's gain differs from the others."""
FEWEST = 40
"""Least number of rows of a group."""
SLOWEST = 0.1
"""Least speed that counts, over the quick ones'."""
PER_DOUBLE = 1.7
"""Growth of the gain from a speed to its double over that from slow rows to fast ones."""
MOST_STAYS, LEAST_VARIANCE = 0.4, 0.5
"""Largest deviation over the largest speed, and least share of the variance, of what explains."""
BETWEEN = 0.25
"""Least time between changes of a command that are examined [s]."""
WINDOW = 0.35
"""Time after a change that is examined [s]."""
FEWEST_CHANGES = 8
"""Least number of such changes."""
LEAST_SCATTER, LATER, BY_NOISE = 0.003, 2e-4, 2.0
RARE = 1.5
"""Rows of motion per command beyond which commands are rare."""
ALIKE = 0.3
"""Largest range of single delays, in periods of the commands, by which they came when logged."""
MOST_HELD = 4
"""Rows that are held by a slower recorder."""
SMOOTH = 0.5
"""Correlation of a command's steps from which on it changes between rows, too."""
GAINS, ANY_GAIN = (1 / 3, 3.0), 0.4
"""Gains that units can be right for, and how far a base's own gain may be from 1 else."""
GROUP_KEYS = {
    "slow": "curve", "middling": "curve", "fast": "curve", "forward": "sides", "backward": "sides",
}  # fmt: skip
"""Groups of rows, and the key of what a gain that differs there would be."""
LIKE_PI = 0.01
"""Distance of its gain from 1 within which a second-order loop may be a PI loop behind a lag."""
KNOTS = (0.0, 0.1, 0.25, 0.4, 0.5, 0.6, 0.75, 0.9, 1.0)
LAGS = (0.0, 0.1, 0.25, 0.5)
"""Further delays of commands, compared with the model [s]."""
PARTS = 10
RIDGE = 3e-3
Reach = Mapping[str, Pair]


class Structure(NamedTuple):
    """Meaning of a parameter beside the loop: key of the diagnosis, text, index in `LEVELS`."""

    key: str
    text: str
    level: int = 0


STRUCTURES = {name: Structure(**row) for name, row in data(__package__, "judgement.toml").items()}


@dataclass(frozen=True)
class Finding:
    """Finding on a fit: index in `LEVELS`, a sentence, its key in the diagnosis if any, and ranges.

    The ranges (least, most) are those of parameters that are not constant.
    """

    text: str
    key: str = ""
    level: int = 0
    reach: Reach = field(default_factory=dict)


@dataclass(frozen=True)
class Judgement:
    """How well the fit of an axis (0, 1) explains its log.

    ``share``: rms of the residual that commands predict, relative to the speed's rms; ``r2``: share
    of the variance that it explains.
    """

    place: int
    fit: LoopFit = field(repr=False)
    share: float
    r2: float
    findings: tuple[Finding, ...]

    @property
    def axis(self) -> str:
        """Name of the axis."""
        return AXES[self.place]

    @property
    def unit(self) -> str:
        """Unit of the axis' speed."""
        return UNITS[self.place]

    @property
    def explained(self) -> str:
        """One of `LEVELS`."""
        told = (self.share > MORE_TOLD) + (self.share > MOST_TOLD)
        least = 2 if self.r2 < LEAST_VARIANCE else 0
        return LEVELS[max([told, least, *(item.level for item in self.findings)])]

    @property
    def sentence(self) -> str:
        """One line of text for the table."""
        more = f"{100 * self.share:.1f} % of its rms more" if self.share > 0.005 else "nothing more"
        told = f"{100 * self.r2:.1f} % of the variance; commands tell {more}"
        return "; ".join((
            f"{self.axis}: {self.explained} ({told})",
            *(item.text for item in self.findings if not item.key),
        ))  # fmt: skip

    @property
    def plain(self) -> bool:
        """True if a loop without further structures explains the log."""
        return self.explained == EXPLAINED and not any(item.key for item in self.findings)

    def reached(self, name: str, value: float) -> Pair:
        """Range of a parameter over its estimate and all findings on it."""
        ends = [item.reach[name] for item in self.findings if name in item.reach]
        return min([value, *(low for low, _ in ends)]), max([value, *(high for _, high in ends)])

    def diagnosis(self) -> list[dict[str, str]]:
        """Findings that have a key, as plain data."""
        return [{"key": item.key, "axis": self.axis, "text": item.text}
                for item in self.findings if item.key]  # fmt: skip


Judgements = Sequence[Judgement]


def judged(fit: LoopFit, other: LoopFit | None, axis: int) -> Judgement:
    """Judge the fit of an axis (0, 1) by its residual; ``other`` is the fit of the other axis."""
    inside, name = fit.log.in_fit, AXES[axis]
    variance = max(float(np.var(fit.log.speed[inside])), 1e-300)
    r2 = 1 - float(np.mean(fit.left[inside] ** 2)) / variance
    findings = [*_structures(fit, axis)]
    share, most = told(fit, other), float(np.abs(fit.deviation()).max())
    if not GAINS[0] < fit.gain < GAINS[1]:
        sense = unit_of(fit.gain, ANY_GAIN)
        hint = f"perhaps {sense}" if sense else "check both units"
        text = f"{name}: the speed is {fit.gain:.3g} times the command: {hint}"
        return Judgement(axis, fit, share, r2, (*findings, Finding(text, "unit", 2)))
    if share > max(MORE_TOLD, BY_OTHER * told(fit)):
        more = f"{100 * share:.1f} % of its rms beyond the model"
        findings.append(Finding(f"{AXES[1 - axis]} changes {name} by {more}", "coupling"))
    findings += [*_by_groups(fit, name), *_over_time(fit, axis), *_late(fit, name)]
    if most > MOST_STAYS * fit.fastest:
        text = f"deviations up to {most:.2g} of {fit.fastest:.2g} {UNITS[axis]} stay"
        findings.append(Finding(text, level=1))
    return Judgement(axis, fit, share, r2, tuple(findings))


def _structures(fit: LoopFit, axis: int) -> Iterator[Finding]:
    """Findings on the structures beside the loop that the fit contains."""
    values, gain, top = fit.values, fit.gain, float(np.abs(fit.log.sent).max())
    said = NEUTRAL | values | {"gain": gain, "top": top}
    said |= {
        "most": gain * said["sat"],
        "backward": gain * said["back"],
        "fast": gain * (1 + said["curve"] * top),
    }
    for member, (key, words, level) in STRUCTURES.items():
        if member in values:
            shares = 1.0, *_shares(fit, member, top)
            reach = {"gain": (gain * max(min(shares), 0.05), gain * max(shares))}
            if member == "lag":
                reach = {"delay": (said["delay"], said["delay"] + said["lag"])}
            text = words.format(name=AXES[axis], unit=UNITS[axis], **said)
            yield Finding(text, key, level, reach)
    if fit.loop == "second-order" and abs(gain - 1) < LIKE_PI:
        yield Finding(
            f"a PI loop whose readings lag by {2 * values['zeta'] / values['wn']:.2g} s looks "
            "alike, and overshoots more"
        )


def _shares(fit: LoopFit, member: str, top: float) -> list[float]:
    """Factors on the gain that are also possible if the base has a structure."""
    value, half = fit.values[member], fit.half_widths().get(member, 0.0)
    wide = math.exp(min(half, 3.0))
    shares = {
        "offset": [max(1 - value / top, 0.2)], "sat": [min(value / top, 1.0)],
        "curve": [1 + (value - half) * top, 1 + (value + half) * top],
        "back": [value / wide, value * wide], "then": [value / wide, value * wide],
    }  # fmt: skip
    return shares.get(member, [])


def _by_groups(fit: LoopFit, name: str) -> Iterator[Finding]:
    """Findings on groups of rows whose gain differs."""
    for group, off, half in _group_gains(fit):
        if abs(off) > max(APART * half, LEAST_APART):
            reach = {"gain": (fit.gain * max(1 + off - half, 0.05), fit.gain * (1 + off + half))}
            text = f"{name}: the gain is {100 * off:+.1f} % off where the log is {group}"
            yield Finding(text, GROUP_KEYS[group], 1, reach)


def _group_gains(fit: LoopFit) -> Iterator[tuple[str, float, float]]:
    """Relative errors of the gain in groups of rows, with half-widths of their intervals."""
    log, y, size = fit.log, fit.forecast, np.abs(fit.forecast)
    moves, block = log.in_fit & (size > SLOWEST * quick(y[log.in_fit])), blocks_of(log.t)
    if moves.sum() < FEWEST:
        return
    third = np.searchsorted(np.quantile(size[moves], (1 / 3, 2 / 3)), size)
    groups = (third == 0, third == 1, third == 2, y > 0, y < 0)
    for name, group in zip(GROUP_KEYS, groups, strict=True):
        rows = group & moves
        if rows.sum() < FEWEST:
            continue
        noise = max(float(np.mean(fit.left[rows] ** 2)), 1e-18)
        pull, weight = (np.bincount(block[rows], y[rows] * x[rows], BLOCKS) for x in (fit.left, y))
        if np.sum(weight > 1e-3 * weight.sum()) > 2:
            shares = weight[:, None, None] / noise
            one = Fitted(np.zeros(1), np.ones(1, bool), -pull[:, None] / noise, shares)
            (off,), (half,) = one.of(slice(None))
            yield name, float(off), float(half)


def bent(fit: LoopFit) -> float:
    """Upper 95 % bound of the gain's relative growth from the fastest motion to its double."""
    gains = {name: pair for name, *pair in _group_gains(fit)}
    if not {"slow", "fast"} <= {*gains}:
        return 1.0
    (slow, narrow), (fast, wide) = gains["slow"], gains["fast"]
    return PER_DOUBLE * (abs(fast - slow) + math.hypot(narrow, wide))


def _over_time(fit: LoopFit, axis: int) -> Iterator[Finding]:
    """Findings on parameters that changed during the log: when, and over which range."""
    shown = np.diag(fit.fisher.sum(axis=0)) > 0
    whole = Fitted(fit.theta, shown, fit.gradient, fit.fisher)
    for name, change in changes(whole, fit.names, fit.log).items():
        if name in ("bias", "curve"):
            continue
        middle, (values, halves) = fit.theta[fit.names.index(name)], change[1:]
        ends = np.subtract(values, halves).min(), np.add(values, halves).max()
        low, high = np.clip(ends, middle - 3, middle + 3).tolist()
        reach = (low, high) if name in LINEAR else (math.exp(low), math.exp(high))
        text = f"{name}{axis + 1} was not the same before about {change.time:.3g} s as after it"
        advice = "take a log of each state, or state bounds for both"
        yield Finding(f"{text}: {advice}", "change", 1, {name: reach})


def _late(fit: LoopFit, name: str) -> Iterator[Finding]:
    """Findings on delays: those that differ from one command change to the next by more than noise,
    and those of commands that may have changed between the rows that show them.
    """
    log, late = fit.log, fit.values["delay"]
    period = _held(log)
    rare = period > RARE * usual_step(log.t)
    delays, variances = _single_delays(fit)
    if len(delays) >= FEWEST_CHANGES:
        low, high = np.quantile(delays, (0.1, 0.9))
        variance, chance = ((high - low) / 2.56) ** 2, BY_NOISE * float(np.median(variances))
        by_chance = variance < chance * (1 + 5 * math.sqrt(2 / len(delays)))
        most = max(0.1 * period, LEAST_SCATTER)
        ends = np.quantile(delays, (0.05, 0.95))
        if not by_chance and variance - chance > most**2:
            least, most = np.maximum(late + ends, 0.0).tolist()
            text = (
                f"{name}: the delay differs from change to change, {1e3 * least:.0f} to "
                f"{1e3 * most:.0f} ms: commands logged by a timer, or lost. Log them when they are "
                "sent"
            )
            reach = least, most + (1.0 if rare else 0.15) * period
            yield Finding(text, "delay", 1, {"delay": reach})
            return
        rare &= bool(np.ptp(ends) > ALIKE * period)
    steps = np.diff(log.sent)
    if rare or steps[1:] @ steps[:-1] > SMOOTH * (steps @ steps):
        more = period if rare else period / 2
        text = (
            f"{name}: commands are logged every {1e3 * period:.3g} ms, and may change in between: "
            f"each may have acted {1e3 * more:.3g} ms sooner. Log all of them when they are sent"
        )
        yield Finding(text, "delay", reach={"delay": (late, late + more)})


def _held(log: AxisLog) -> float:
    """Time [s] for which each command of the log is held."""
    changes = np.flatnonzero(np.diff(log.sent))
    rows = int(np.gcd.reduce(np.diff(changes))) if len(changes) > FEWEST_CHANGES else 1
    return log.period * (rows if rows <= MOST_HELD else 1)


def _single_delays(fit: LoopFit) -> tuple[list[float], list[float]]:
    """Deviations of the delays of single changes of the command from the fitted delay, with noise
    variances; none if commands are ramped or change all the time.
    """
    log, late = fit.log, fit.values["delay"]
    steps = np.diff(log.sent)
    times = log.sent_t[1:][steps != 0]
    times = times[np.diff(times, prepend=-np.inf) > BETWEEN]
    times = times[np.diff(times, append=np.inf) > BETWEEN]
    if "accel" in fit.names or len(times) < FEWEST_CHANGES or np.mean(steps != 0) > 0.2:
        return [], []
    whiten, whole = whitener(fit.left, log.in_fit)
    later = foretold(log, fit.loop, [fit.values | {"delay": late + LATER}])[:, 0]
    along, left = whiten((later - fit.forecast) / LATER), whiten(fit.left)
    first, last = (np.searchsorted(log.t, times + more) for more in (0.0, late + WINDOW))
    least = max(0.2 * log.period, LEAST_SCATTER)
    noise = max(2.2 * float(np.median(np.abs(left[whole]))) ** 2, 1e-12)
    delays, variances = [], []
    for low, high in zip(first.tolist(), last.tolist(), strict=True):
        weight = float(np.sum(along[low:high] ** 2))
        if high - low > 2 and whole[low:high].all() and noise < weight * least**2:
            delays.append(float(along[low:high] @ left[low:high]) / weight)
            variances.append(noise / weight)
    return delays, variances


def told(fit: LoopFit, other: LoopFit | None = None) -> float:
    """Cross-validated rms of the residual that commands predict, relative to the speed's rms.

    ``other``: the fit of the other axis, whose speed counts, too.
    """
    inside = fit.log.in_fit
    x = _columns(fit, other)
    x = x - x[inside].mean(axis=0)
    x = (x / np.maximum(x[inside].std(axis=0), 1e-12))[inside]
    left, count = fit.left[inside], int(inside.sum())
    part = np.arange(count) * PARTS // count
    whole, pull, guess = x.T @ x, x.T @ left, np.empty(count)
    for k in range(PARTS):
        own = part == k
        kept = whole - x[own].T @ x[own] + RIDGE * count * np.eye(x.shape[1])
        guess[own] = x[own] @ np.linalg.solve(kept, pull - x[own].T @ left[own])
    gained = float(left @ left - np.sum((left - guess) ** 2))
    return math.sqrt(max(gained, 0.0) / count) / max(float(np.std(fit.forecast[inside])), 1e-9)


def _columns(fit: LoopFit, other: LoopFit | None) -> Floats:
    """Functions (N, K) of command, speed, acceleration, and the other axis' speed."""
    log, y = fit.log, fit.forecast
    end = log.t[:, None] - fit.values["delay"] - np.array(LAGS)
    w = log.mean_command(end - log.period, end)
    rate = np.gradient(y, fit.log.t)
    knots = np.unique(np.quantile(w[fit.log.in_fit, 0], KNOTS))
    hats = [np.interp(w[:, 0], knots, row) for row in np.eye(len(knots))]
    columns = [*hats, *w.T[1:], y, np.abs(y), y * np.abs(y)]
    columns += [rate, np.abs(rate), rate * np.sign(y), np.abs(rate) * np.sign(y)]
    if other is not None:
        size = np.abs(other.forecast)
        columns += [other.forecast, size, y * size, np.sign(y) * size]
    return np.column_stack(columns)
