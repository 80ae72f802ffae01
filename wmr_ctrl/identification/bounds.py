"""Results of a log, and what a guard or a filter may count on."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from typing import ClassVar

import numpy as np
import tomlkit
from scipy.stats import t as student

from wmr_ctrl.control.setup import settle
from wmr_ctrl.errors import ScenarioError
from wmr_ctrl.guard.bounds import pair_of
from wmr_ctrl.guard.price import speed_price
from wmr_ctrl.identification.estimate import UNITS, WORDS, Estimate, Score
from wmr_ctrl.identification.fit import LAG_LEAST, Fit
from wmr_ctrl.identification.reading import BLOCKS, COUNTED, Floats
from wmr_ctrl.scenario import Scenario, to_toml
from wmr_ctrl.world.encoder import rounded_by

CREEP = 0.01
"""By how much the tread's creep may hide a command's delay [s]: m/(2 C), for 30 kg on tyres of
1500 N s/m.  No log of wheels alone tells it, so it is added."""
SIGMAS = 3.0
NEWTON = 1.0
WILKS_BLOCKS = 59
"""Blocks of which the largest bounds 95 % of all, with 95 % confidence."""
BLOCK_TIMES = 5.0
"""Length of a block, in time constants of a coloured push: shorter ones are not independent."""

GRID_POINTS, SPREAD = 13, 3.5
"""Of the likelihood's picture: points either way, and half its width in standard errors."""
LEAST_LATE = {"delay": 0.0, "lag": LAG_LEAST}


@dataclass(frozen=True)
class Traces:
    """What is drawn of a fit, over t (N,) [s]: speeds (N, 2) as they were read and as a fit of what
    lies before ``held_out_from`` [s] foretells them; residuals (N, 2), as forces q z [N, N m] of
    which dbar is made, or as speeds [m/s, rad/s] of which filter.d is.  NaN where nothing counts.
    """

    t: Floats
    measured: Floats
    foretold: Floats
    residual: Floats
    held_out_from: float


@dataclass(frozen=True)
class Surface:
    """Log-likelihood (X, Y) less that of the fit, over values of two parameters, x (X,), y (Y,)."""

    names: tuple[str, str]
    x: Floats
    y: Floats
    values: Floats


def grid_about(value: float, error: float, least: float) -> Floats:
    """Values about an estimate, ``SPREAD`` standard errors either way."""
    return np.linspace(max(value - SPREAD * error, least), value + SPREAD * error, GRID_POINTS)


@dataclass(frozen=True)
class GuardBounds:
    """Numbers for [guard] in SI units, per axis or from least to most, and where they come from.

    ``q``: rms force noise a control period; the sentence is what may be said of dbar; ``wide``:
    delay or masses are known too badly for a guard; ``refuted``: what the held-out third has
    against bounds that the rest of the log gives.
    """

    M_min: tuple[float, float]
    M_max: tuple[float, float]
    dbar: tuple[float, float]
    nbar: tuple[float, float]
    delay: tuple[float, float]
    lag: tuple[float, float]
    q: tuple[float, float]
    sentence: str
    wide: bool = False
    refuted: tuple[str, ...] = ()

    section: ClassVar[str] = "guard"

    def pairs(self) -> dict[str, tuple[tuple[float, float], str]]:
        """Numbers by key of [guard], with their unit."""
        axes, masses = "N, N m", "kg, kg m²"
        return {
            "M_min": (self.M_min, masses), "M_max": (self.M_max, masses),
            "dbar": (self.dbar, axes), "nbar": (self.nbar, "m/s, rad/s"),
            "delay": (self.delay, "s"), "lag": (self.lag, "s"),
        }  # fmt: skip

    def to_json(self) -> dict[str, object]:
        """Plain data."""
        numbers = {name: list(pair) for name, (pair, _) in self.pairs().items()}
        return {**numbers, "refuted": list(self.refuted), "sentence": self.sentence}


@dataclass(frozen=True)
class FilterBounds:
    """Numbers for [filter]: kind of loop, and per axis [m/s, rad/s] or from least to most [s].

    ``peak_gain``: largest speed over commanded speed of the whole family, infinite where an axis
    was not driven; ``d``: the largest deviation of the speed that no command explains, of which
    the sentence says what it is worth.
    """

    loop: str
    peak_gain: tuple[float, float]
    d: tuple[float, float]
    delay: tuple[float, float]
    sentence: str

    section: ClassVar[str] = "filter"

    def pairs(self) -> dict[str, tuple[tuple[float, float], str]]:
        """Numbers by key of [filter], and the peak gain, with their unit."""
        return {"peak_gain": (self.peak_gain, "1"), "d": (self.d, "m/s, rad/s"),
                "delay": (self.delay, "s")}  # fmt: skip

    def to_json(self) -> dict[str, object]:
        """Plain data."""
        numbers = {name: list(pair) for name, (pair, _) in self.pairs().items()}
        return {"loop": self.loop, **numbers, "sentence": self.sentence}


@dataclass(frozen=True)
class BaseIdentification(ABC):
    """What a log told of a robot.

    ``parameters`` maps a name to (value, low, high, told, seconds), SI units; ``bounds`` are the
    guard's or the filter's numbers; ``score`` says how the held-out third was foretold;
    ``scenario`` runs as it is.
    """

    name: str
    parameters: Mapping[str, Estimate]
    bounds: GuardBounds | FilterBounds
    remarks: tuple[str, ...]
    score: Score
    scenario: Scenario
    places: ClassVar[Mapping[str, tuple[str, ...]]] = {}
    """Keys of the scenario, and the parameters whose intervals stand beside them."""

    def to_json(self) -> dict[str, object]:
        """Plain data."""
        return {
            "log": self.name,
            "parameters": {name: item.to_json() for name, item in self.parameters.items()},
            "bounds": self.bounds.to_json(),
            "remarks": list(self.remarks),
            "score": asdict(self.score),
        }

    @abstractmethod
    def traces(self) -> Traces:
        """Measured and foretold speeds, and residuals."""

    @abstractmethod
    def surfaces(self) -> tuple[Surface, ...]:
        """Likelihood over pairs of parameters that may stand for each other."""

    def described(self) -> dict[str, tuple[str, str]]:
        """Words and unit of each parameter."""
        return {name: (WORDS[name], UNITS[name]) for name in self.parameters}

    def to_toml(self) -> str:
        """The scenario, with the interval and verdict of each number beside it."""
        document = tomlkit.parse(to_toml(self.scenario))
        for key, names in self.places.items():
            table, field = key.split(".")
            said = "; ".join(
                f"{name} {item.low:.6g} to {item.high:.6g} {UNITS[name]}, {item.verdict}"
                for name in names
                if (item := self.parameters.get(name))
            )
            if not said or field not in document.get(table, {}):
                continue
            entry = document[table][field]
            entry.comment(f"{entry.trivia.comment.lstrip('# ')}: {said}")
        limit = {"guard": "guard.dbar", "filter": "filter.d"}[self.bounds.section]
        head = [
            f"from the log {self.name} by wmr-ctrl identify; 95 % intervals stand beside values",
            f"{limit}: {self.bounds.sentence}",
            *self.remarks,
        ]
        return "".join(f"# {line}\n" for line in head) + "\n" + tomlkit.dumps(document)


def guard_bounds(
    white: Fit,
    intervals: Mapping[str, tuple[float, float, float]],
    scenario: Scenario,
    colour: float | None,
) -> GuardBounds:
    """Numbers of a guard from the intervals (value, low, high) and the white fit's residuals.

    dbar is q max(3, max |z|) per axis: q the rms force noise of the white fit, z the residuals in
    standard deviations.  ``colour``: time constant of the coloured push [s], where there is one.
    """
    names, log = white.problem.filter.graph.names, white.problem.log
    q = np.exp(white.theta[[names.index("q1"), names.index("q2")]])
    counted = white.problem.counting()[0] == COUNTED
    z = np.abs(white.last.sizes[counted])
    dbar = q * np.maximum(SIGMAS, z.max(axis=0))
    wider = student.ppf(1 - 0.05 / 4, BLOCKS - 1) / student.ppf(0.975, BLOCKS - 1)
    low, high = [], []
    for name in ("m", "I"):
        value, least, most = intervals[name]
        low.append(value * (least / value) ** wider)
        high.append(value * (most / value) ** wider)
    period, robot = scenario.clock.control, scenario.robot
    if log.of_speed:
        noise = np.exp(white.theta[[names.index("n1"), names.index("n2")]])
        nbar = noise * np.maximum(SIGMAS, z.max(axis=0))
    else:
        counts = float(scenario.value("encoder.counts")[0])
        nbar = np.array(rounded_by((robot.r, robot.l), counts, period))
    early, latest = max(intervals["delay"][1], 0.0), intervals["delay"][2]
    # The guard lets a delay vary by one control period at most.
    wide = latest - early > period
    late = (early, latest) if wide else (early, min(latest + CREEP, early + period))
    return GuardBounds(
        (float(low[0]), float(low[1])),
        (float(high[0]), float(high[1])),
        (float(dbar[0]), float(dbar[1])),
        (float(nbar[0]), float(nbar[1])),
        late,
        (max(intervals["lag"][1], 0.0), intervals["lag"][2]),
        (float(q[0]), float(q[1])),
        tolerance_sentence(white, colour),
        wide,
    )


def tolerance_sentence(white: Fit, colour: float | None) -> str:
    """What may be said of dbar: a share of blocks of time, or only that it was the largest seen."""
    log = white.problem.log
    length = max(1.0, BLOCK_TIMES * (colour or 0.0))
    count = int((log.t[-1] - log.t[0]) / length)
    v, w = np.abs(white.last.mean[:, 2:4]).max(axis=0)
    visited = f"at speeds up to {v:.2g} m/s and {w:.2g} rad/s, on this floor, with this load"
    if count < WILKS_BLOCKS:
        return (
            f"largest seen in {count} blocks of {length:.2g} s, {visited}; {WILKS_BLOCKS} blocks "
            "would say more"
        )
    share = 0.05 ** (1 / count)
    return (
        f"with 95 % confidence at most {100 * (1 - share):.2g} % of later blocks of {length:.2g} s "
        f"exceed it, if such blocks are independent, {visited}"
    )


def usable_speeds(scenario: Scenario) -> tuple[float, float] | None:
    """Usable speed of v1 with the guard's numbers, and what one more newton of dbar costs [m/s].

    None where the guard refuses them.
    """
    try:
        numbers = settle(scenario, None).guard
    except ScenarioError:
        return None
    more = replace(numbers, dbar=(pair_of(numbers.dbar)[0] + NEWTON, pair_of(numbers.dbar)[1]))
    now, then = (speed_price(scenario, item).usable[0] for item in (numbers, more))
    return now, now - then
