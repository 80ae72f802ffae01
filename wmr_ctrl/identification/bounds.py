"""Results of an identification: verdicts on parameters, and bounds that a guard may rely on.

Each parameter gets a verdict; parameters that cannot be separated are named, as are the most
informative seconds.
"""

from abc import ABC
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import ClassVar, NamedTuple

import numpy as np

from wmr_ctrl.core.data import data
from wmr_ctrl.world.scenario import Scenario

from .judgement import Judgement, Judgements
from .kalman import BLOCKS
from .logs.log import COMMAND, Floats, LeftOut, Names, Note, Pair, Texts
from .written import toml_of

DETERMINED, ROUGHLY, UNDETERMINED = "determined", "roughly", "undetermined"
SHARES = (0.1, 0.3)
"""Half-width over size up to which a parameter is determined, or roughly so."""
_DATA = data(__package__, "bounds.toml")
WORDS: Mapping[str, str] = _DATA["words"]
UNITS: Mapping[str, str] = _DATA["units"]
BECAUSE: Mapping[str, list[list[str]]] = _DATA["because"]
"""Pairs that cannot be separated, by what the log lacks then."""
LEFT_OUT = ("from", "to", "reason")
SMALL, PART = 0.03, 0.35


class Origin(NamedTuple):
    """The preset or file that a scenario extends, and the values that it states, by key."""

    source: str = ""
    values: Mapping[str, object] = {}


class Estimate(NamedTuple):
    """A value with its 95 % interval; whether the log determines it; the shortest time with half of
    the information; and the half-width relative to the size that the verdict compares it with.
    """

    value: float
    low: float
    high: float
    verdict: str
    seconds: Pair = (0.0, 0.0)
    share: float = 0.0

    def to_json(self) -> dict[str, object]:
        """Plain data."""
        return {key: value for key, value in self._asdict().items() if key != "share"}


Estimates = Mapping[str, Estimate]


@dataclass(frozen=True)
class Score:
    """Prediction of the held-out third, beside a forecast of constant velocities.

    The shares of both speeds' variance that the fit and that forecast explain, and the time [s] at
    which that third begins.  ``usable_speed`` of a guard with the bounds, and what one newton more
    of dbar costs [m/s]; None if the guard refuses them.
    """

    foretold: Pair
    constant_velocity: Pair
    held_out_from: float
    usable_speed: float | None = None
    one_newton_more: float | None = None


@dataclass(frozen=True)
class Traces:
    """Curves of a fit over t (N,) [s]: speeds (N, 2) as measured, and as predicted by a fit of the
    data before ``held_out_from`` [s]; residuals (N, 2), as forces q z [N, N m] (for dbar) or as
    speeds [m/s, rad/s] (for filter.d); NaN at samples that are not used.
    """

    t: Floats
    measured: Floats
    foretold: Floats
    residual: Floats
    held_out_from: float


class Bounds(ABC):
    """Numbers for one table of the scenario, per axis or as (least, most)."""

    section: ClassVar[str]
    sentence: str

    def pairs(self) -> dict[str, tuple[Pair, str]]:
        """Numbers by key of the table, each with its unit."""
        units: Mapping[str, str] = _DATA["pairs"][self.section]
        return {name: (vars(self)[name], unit) for name, unit in units.items()}

    def to_json(self) -> dict[str, object]:
        """Plain data."""
        numbers = {name: list(pair) for name, (pair, _) in self.pairs().items()}
        return {**numbers, "sentence": self.sentence}


@dataclass(frozen=True)
class GuardBounds(Bounds):
    """Numbers for [guard] in SI units, per axis or as (least, most), with their sources.

    ``q``: rms force noise per control period; the sentence states what dbar is worth; ``wide``:
    delay or masses are known too badly for a guard; ``refuted``: contradictions between one part of
    the log and the rest.
    """

    M_min: Pair
    M_max: Pair
    dbar: Pair
    nbar: Pair
    delay: Pair
    lag: Pair
    q: Pair
    sentence: str
    wide: bool = False
    refuted: Texts = ()

    section: ClassVar[str] = "guard"

    @property
    def masses(self) -> tuple[Pair, Pair]:
        """Least and largest mass [kg], and moment of inertia [kg m2]."""
        first, second = zip(self.M_min, self.M_max, strict=True)
        return first, second

    def to_json(self) -> dict[str, object]:
        """Plain data."""
        return {**super().to_json(), "refuted": list(self.refuted)}


@dataclass(frozen=True)
class FilterBounds(Bounds):
    """Numbers for [filter]: kind of loop, and per axis [m/s, rad/s] or (least, most) [s].

    ``peak_gain``: largest speed over commanded speed of the whole family, infinite for an axis that
    was not driven; ``d``: the largest deviation of the speed that no command explains; ``sentence``
    says how far it can be trusted.
    """

    loop: str
    peak_gain: Pair
    d: Pair
    delay: Pair
    sentence: str

    section: ClassVar[str] = "filter"

    def to_json(self) -> dict[str, object]:
        """Plain data."""
        return {"loop": self.loop, **super().to_json()}


@dataclass(frozen=True)
class BaseIdentification(ABC):
    """Results of an identification.

    ``parameters`` maps a name to (value, low, high, verdict, seconds), SI units; ``bounds`` are the
    numbers for the guard or the filter; ``score`` says how well the held-out third was predicted,
    and ``curves`` are the predicted and measured speeds.  ``scenario`` can be run as it is.  It has
    stand-ins for ``missing``, the required keys that neither the log nor a user gives; the file is
    written without them.
    """

    name: str
    parameters: Estimates
    bounds: GuardBounds | FilterBounds
    remarks: Texts
    score: Score
    scenario: Scenario
    curves: Traces = field(repr=False)
    missing: Names = field(default=(), kw_only=True)
    words: Mapping[str, str] = field(default_factory=dict, kw_only=True)
    """Keys that the written scenario has though they are as by default, with words on some."""
    judgements: tuple[Judgement, ...] = field(default=(), kw_only=True)
    """How well each axis is explained, if it was driven."""
    notes: tuple[Note, ...] = field(default=(), kw_only=True)
    """Observations about the log from before the fit."""
    left_out: tuple[LeftOut, ...] = field(default=(), kw_only=True)
    """Stretches that no fit counts."""
    origin: Origin = field(default_factory=Origin, kw_only=True)
    """File that the written scenario extends."""
    seconds: float = field(default=0.0, kw_only=True)
    """Length of the log [s]."""
    range: Mapping[str, Pair] = field(default_factory=dict, kw_only=True)
    """Least and largest speed of each axis that the log holds for a while."""

    @property
    def places(self) -> Mapping[str, Sequence[str]]:
        """Parameters whose intervals are written beside each key of the scenario."""
        places: Mapping[str, Sequence[str]] = _DATA["places"][self.bounds.section]
        return places

    def to_json(self) -> dict[str, object]:
        """Plain data."""
        return {
            "log": self.name,
            "parameters": {name: item.to_json() for name, item in self.parameters.items()},
            "bounds": self.bounds.to_json(),
            "remarks": list(self.remarks),
            "score": asdict(self.score),
            "explained": {item.axis: item.explained for item in self.judgements},
            "diagnosis": [
                *(note._asdict() for note in self.notes),
                *(row for item in self.judgements for row in item.diagnosis()),
            ],
            "left_out": [dict(zip(LEFT_OUT, item, strict=True)) for item in self.left_out],
            "range": {axis: list(ends) for axis, ends in self.range.items()},
        }

    def traces(self) -> Traces:
        """Measured and predicted speeds, and residuals."""
        return self.curves

    def to_toml(self, folder: Path | None = None) -> str:
        """TOML text of the scenario for a file in ``folder``: its base scenario and the results."""
        return toml_of(self, folder)

    def described(self) -> dict[str, tuple[str, str]]:
        """Words and unit of each parameter."""
        return {name: (WORDS[name], UNITS[name]) for name in self.parameters}


def verdict(share: float) -> str:
    """Whether the log determines a value, from its half-width as a share of its size."""
    return DETERMINED if share <= SHARES[0] else ROUGHLY if share <= SHARES[1] else UNDETERMINED


def sizes(values: Mapping[str, float], speed: Floats, period: float) -> dict[str, float]:
    """Sizes that half-widths are compared with: the value itself, with a minimum for some kinds.

    ``speed`` (2,): rms speeds.  Friction is compared with a quarter of all friction at these
    speeds at least, a time with a control period.
    """
    v, w = np.maximum(speed, 1e-3)
    ahead = abs(values["Fc"]) + 2 * abs(values["c"]) + abs(values["Fv"]) * v
    turning = abs(values["Mv"]) * w + 2 * abs(values["c"]) * 0.2
    least = {"Fc": ahead / 4, "c": ahead / 8, "Fv": ahead / 4 / v, "Mv": turning / 4 / w,
             "delay": period, "lag": period}  # fmt: skip
    return {name: max(abs(value), least.get(name, 0.0)) for name, value in values.items()}


def informative_seconds(t: Floats, share: Floats) -> Pair:
    """Shortest stretch [s] that has half of the information ``share`` (B,) on one parameter."""
    total, edges = share.sum(), np.linspace(t[0], t[-1], BLOCKS + 1)
    for length in range(1, BLOCKS + 1):
        sums = np.convolve(share, np.ones(length), "valid")
        if sums.max() >= 0.5 * total:
            first = int(np.argmax(sums))
            return float(edges[first]), float(edges[first + length])
    return float(t[0]), float(t[-1])


def mixtures(names: Sequence[str], information: Floats, vague: set[str]) -> Iterator[str]:
    """Sentences on parameters in ``vague`` that the log cannot separate from others.

    From the small eigenvalues of the Fisher information (n, n) with unit diagonal.
    """
    scale = np.sqrt(np.maximum(np.diag(information), 1e-300))
    values, vectors = np.linalg.eigh(information / np.outer(scale, scale))
    for value, vector in zip(values, vectors.T, strict=True):
        mixed = [names[k] for k in np.argsort(-np.abs(vector)) if abs(vector[k]) > PART]
        if value > SMALL or len(mixed) < 2 or not set(mixed) & vague:
            continue
        known = set(mixed)
        lacking = (text for text, pairs in BECAUSE.items() for pair in pairs if known >= set(pair))
        why = next(lacking, "")
        listed = " and ".join((", ".join(WORDS[n] for n in mixed[:-1]), WORDS[mixed[-1]]))
        yield f"{listed} cannot be separated" + (f": {why}." if why else " by this log.")


def loop_remarks(judgements: Judgements, estimates: Estimates) -> list[str]:
    """Remarks on which parameters of a speed loop the log determines, and which it does not."""
    remarks = [
        "gains are against the log's own measured speeds: an error in a wheel's radius or "
        "track affects both, and no log of wheels shows it. Add it to filter.gain."
    ]
    driven = {item.place: item for item in judgements}
    for place, column in enumerate(COMMAND):
        if place not in driven:
            remarks.append(f"{column} is constant, so the log says nothing about that axis.")
            continue
        item = driven[place]
        remarks += [finding.text for finding in item.findings if finding.key]
        if "accel" not in item.fit.names and item.plain:
            least = estimates[f"accel{place + 1}"].low
            remarks.append(
                f"no acceleration limit shows in {column}: if there is one, and every command came "
                f"after the same delay, it is above {least:.3g} {item.unit}2."
            )
    for item in judgements:
        names = [f"{name}{item.place + 1}" for name in item.fit.names]
        unsure = {name for name in names if estimates[name].verdict != DETERMINED}
        remarks += mixtures(names, item.fit.fisher.sum(axis=0), unsure)
    vague = [name for name, item in estimates.items() if item.verdict == UNDETERMINED and
             not name.startswith("accel")]  # fmt: skip
    if vague:
        remarks.append(
            f"undetermined: {', '.join(vague)}. Steps of the command show them, each held until "
            "the speed has settled."
        )
    if driven and any(name.startswith("delay") for name in vague):
        remarks.append(
            "where commands were lost or came late by turns, delays are undetermined too, and "
            "other numbers may lie outside their intervals: log when commands arrived, and state "
            "filter.losses and filter.delay."
        )
    return remarks
