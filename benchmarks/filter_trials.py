"""The filter's statements against adversaries, a hundred thousand trials each.

``python -m benchmarks.filter_trials [--quick] [--out docs/filter.md]``.  The filter is the C of its
package; bases and adversaries are the tests' own, integrated exactly between all instants at which
something changes.  Then each hypothesis is broken by 5 % (or by the least that can be: one loss, a
lag), and the runs that leave the limit are counted: a statement whose hypotheses may be broken
unnoticed would say nothing.
"""

from __future__ import annotations

import ctypes
import itertools
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.native import load_filter
from benchmarks.parts import page_parser, renew
from tests.filter.adversary import Base, Sender, fastest
from tests.filter.linear_base import driven, impulses, pi_base, second_order_base
from wmr_ctrl.filter import filter_system
from wmr_ctrl.scenario import Scenario, load_scenario

NAME = "trials"
TRIALS, BROKEN_TRIALS, BATCH = 100_000, 2_000, 2_000
SAMPLES, T, PARTS = 120, 0.05, 4
Floats = NDArray[np.float64]


class Compiled:
    """The C of a scenario's filter, for many bases at once."""

    def __init__(self, scenario: Scenario) -> None:
        """Compile it; CompilerError where that fails."""
        self._library = load_filter(scenario, "filter_trials")
        self.system = filter_system(scenario)

    def sender(self, trials: int) -> Sender:
        """A fresh memory for so many bases."""
        p = np.array(self.system.p0)
        y = np.zeros((trials, self.system.y.numel()))
        x = np.zeros((trials, self._library.wmr_filter_begin(ctypes.c_long(0), None)))
        self._library.wmr_filter_begin(ctypes.c_long(trials), x.ctypes.data_as(ctypes.c_void_p))
        sizes = trials, self.system.u.numel(), y.shape[1]

        def send(u: Floats) -> Floats:
            given = np.ascontiguousarray(u.T, dtype=float)
            pointers = (item.ctypes.data_as(ctypes.c_void_p) for item in (p, x, given, y))
            self._library.wmr_filter_many(*map(ctypes.c_long, sizes), *pointers)
            return y[:, :2].T

        return send


@dataclass(frozen=True)
class Statement:
    """A statement with its trials: largest |v|/V of each, for so many trials and a seed.

    ``broken``: the same with one hypothesis broken, by what is broken.
    """

    title: str
    inside: Callable[[int, int], Floats]
    broken: Mapping[str, Callable[[int, int], Floats]] = field(default_factory=dict)


STATED: Mapping[str, Any] = {
    "filter.tau": (0.2, 0.3), "filter.gain": (0.9, 1.1), "filter.d": (0.05, 0.05),
    "filter.odometry": (0.02, 0.02), "limits.v_u1": (1.0, 1.0), "limits.v_u2": (0.7, 0.7),
    "clock.control": T,
}  # fmt: skip
WORLDS: Sequence[Mapping[str, Any]] = (
    {}, {"delay": (0.03, 0.03)}, {"delay": (0.13, 0.13)}, {"delay": (0.02, 0.06)}, {"losses": 2},
    {"jitter": 0.01}, {"age": 0.08},
    {"age": 0.12, "delay": (0.02, 0.06), "losses": 1, "jitter": 0.004},
)  # fmt: skip


def scenario(kind: str, changes: Mapping[str, Any] = {}, **stated: Any) -> Scenario:
    """A scenario with this filter."""
    keys = {f"filter.{name}": value for name, value in {"kind": kind, **stated}.items()}
    return load_scenario("paper-simulation", {**STATED, **keys, **changes})


def first_order(kind: str, worlds: Sequence[Mapping[str, Any]]) -> Callable[[int, int], Floats]:
    """Trials of a first-order base, all worlds in turn, with odometry and without."""

    def run(trials: int, seed: int) -> Floats:
        each = -(-trials // (2 * len(worlds)))
        found = []
        for number, (world, heard) in enumerate(itertools.product(worlds, (True, False))):
            stated = {k: v for k, v in world.items() if k != "second_lag" and kind == "governor"}
            found.append(_chain(scenario(kind, **stated), Base(**world, heard=heard), each,
                                seed + number))  # fmt: skip
        return np.concatenate(found)[:trials]

    return run


def _chain(stated: Scenario, base: Base, trials: int, seed: int) -> Floats:
    filtering = Compiled(stated)
    batches = [min(BATCH, trials - start) for start in range(0, trials, BATCH)]
    return np.concatenate([
        fastest(stated, base, count, SAMPLES, 1000 * seed + k, lambda _, n: filtering.sender(n))
        for k, count in enumerate(batches)
    ])  # fmt: skip


def wrong(kind: str, **changes: Any) -> Callable[[int, int], Floats]:
    """Trials of a first-order base beyond what the filter is told."""
    return lambda trials, seed: _chain(scenario(kind), Base().wrong(**changes), trials, seed)


@dataclass(frozen=True)
class Family:
    """Linear loops: intervals of their numbers, their push, and what the filter is told of them.

    ``corners``: the share of its members that lie at corners; ``force``: what its motors give [N].
    """

    numbers: Mapping[str, tuple[float, float]]
    push: float
    told: Mapping[str, Any]
    second_order: bool
    corners: float = 0.5
    force: float = np.inf

    def bases(self, rng: np.random.Generator, count: int) -> tuple[Floats, Floats, Floats]:
        """Members as stacks of A, b, e."""
        low, high = np.array(list(self.numbers.values())).T
        share = rng.random((count, len(low)))
        share = np.where(rng.random((count, 1)) < self.corners, np.round(share), share)
        build = second_order_base if self.second_order else pi_base
        made = [build(*row) for row in low + share * (high - low)]
        A, b, e = (np.array([getattr(one, name) for one in made]) for name in ("A", "b", "e"))
        return A, b, e


WIDE = {"M": (50.0, 65.0), "kp": (135.0, 165.0), "ki": (270.0, 330.0), "c": (0.0, 20.0)}
PI = Family(WIDE, 10.0, {
    "loop": "pi", "mass": WIDE["M"], "inertia": (50 / 16, 65 / 16), "kp": WIDE["kp"],
    "ki": WIDE["ki"], "friction": WIDE["c"], "push": (10.0, 0.0), "gain": (1.0, 1.0),
    "d": (0.0, 0.0), "tau": None, "odometry": None,
}, second_order=False)  # fmt: skip
SWUNG_NUMBERS = {"w0": (3.0, 5.0), "z": (0.4, 1.4), "K": (0.8, 1.1)}
SWUNG = Family(SWUNG_NUMBERS, 0.05, {
    "loop": "second-order", "frequency": SWUNG_NUMBERS["w0"], "damping": SWUNG_NUMBERS["z"],
    "gain": SWUNG_NUMBERS["K"], "d": (0.05, 0.0), "tau": None, "odometry": None,
}, second_order=True)  # fmt: skip


def linear(
    kind: str, told: Family, true: Family, *, timely: bool = True, telling: bool = True
) -> Callable[[int, int], Floats]:
    """Trials of linear loops: drawn demands for most, hill climbing from the worst for the rest.

    Unless ``timely`` at any times, of which the filter is told if one is ``telling``.
    """

    def run(trials: int, seed: int) -> Floats:
        filtering, rng = Compiled(scenario(kind, **told.told)), np.random.default_rng(seed)
        found, left = [], trials
        while left > 0:
            count = min(BATCH, left)
            for worst in _climbed(filtering, true, rng, count, timely=timely, telling=telling):
                found.append(worst)
                left -= len(worst)
        return np.concatenate(found)[:trials]

    return run


CLIMBS, CLIMBERS = 10, 10
"""Steps of a climb; every how many of the drawn trials, the worst, climb."""
UNTIMELY = (0.0, 0.02, 0.3, 0.9, 1.0, 1.2, 1.7, 3.0)
"""Periods from one step to the next where steps come at any time."""


def _climbed(
    filtering: Compiled,
    true: Family,
    rng: np.random.Generator,
    count: int,
    *,
    timely: bool,
    telling: bool,
) -> Iterator[Floats]:
    """Largest |v| of drawn trials, then of those that climb from the worst of them."""
    bases = true.bases(rng, count)
    asked, pushes = _demands(rng, bases, true.push)
    times = None if timely else _times(rng, count)

    def run(asked: Floats, pushes: Floats, times: Floats | None) -> Floats:
        sender = filtering.sender(len(asked))
        return driven(bases, sender, asked, pushes, T, true.force, times, telling=telling)

    worst = run(asked, pushes, times)
    yield worst
    best = np.argsort(worst)[-max(1, count // CLIMBERS) :]
    bases = bases[0][best], bases[1][best], bases[2][best]
    asked, pushes, worst = asked[best], pushes[best], worst[best]
    times = None if times is None else times[best]
    for _ in range(CLIMBS):
        other, pushed, when = asked.copy(), pushes.copy(), None if times is None else times.copy()
        for i in range(len(best)):
            start, size = rng.integers(0, SAMPLES), rng.integers(1, 12)
            other[i, start : start + size] = rng.choice([-9.0, 0.0, 9.0, rng.uniform(-1, 1)])
            start = rng.integers(0, SAMPLES)
            pushed[i, start : start + size] *= -1
            if when is not None:
                start, size = rng.integers(0, SAMPLES), rng.integers(1, 12)
                when[i, start : start + size] = T * rng.choice(UNTIMELY)
        again = run(other, pushed, when)
        yield again
        better = again > worst
        asked[better], pushes[better], worst[better] = other[better], pushed[better], again[better]
        if times is not None and when is not None:
            times[better] = when[better]


def _times(rng: np.random.Generator, count: int) -> Floats:
    """Times [s] from each sample to the next: in time but for some, or all; or none for long."""
    share = np.repeat(rng.choice([0.0, 0.05, 0.3, 1.0], (count, SAMPLES // 20)), 20, axis=1)
    late = rng.random((count, SAMPLES)) < share
    some = np.where(late, rng.choice(UNTIMELY, (count, SAMPLES)), 1.0)
    still = np.arange(SAMPLES) % 40 < rng.integers(20, 40, (count, 1))
    stands = (np.arange(count) % 5 == 0)[:, None]
    return T * np.where(stands, np.where(still, 0.0, 1.0), some)


def _demands(
    rng: np.random.Generator, bases: tuple[Floats, Floats, Floats], push: float
) -> tuple[Floats, Floats]:
    """What is asked for and how the base is pushed, sample by sample.

    By turns: the worst for the base itself seen back from the end, the same after pressing on,
    swings, chance.
    """
    A, b, e = bases
    count = len(A)
    ends = 9 * np.sign(impulses(A, b, T, SAMPLES))[:, ::-1]
    back = np.sign(impulses(A, e, T / PARTS, SAMPLES * PARTS))[:, ::-1]
    style = np.arange(count) % 4
    pressed = np.where(np.arange(SAMPLES) < rng.integers(10, 80, (count, 1)), 9.0, ends)
    turns = rng.random((count, SAMPLES)) < rng.uniform(0.02, 0.4, (count, 1))
    swings = 9.0 * (-1.0) ** np.cumsum(turns, axis=1)
    chance = rng.uniform(-3, 3, (count, SAMPLES))
    asked = np.choose(style[:, None], [ends, pressed, swings, chance])
    own = np.repeat(np.sign(asked), PARTS, axis=1)
    pushes = push * np.where(style[:, None] < 2, back, own)
    return asked, pushes.reshape(count, SAMPLES, PARTS)


def beyond(
    kind: str, family: Family, *ends: tuple[str, int], timely: bool = True
) -> Callable[[int, int], Floats]:
    """Trials of loops whose numbers ``ends`` are 5 % below their intervals (-1) or above (1)."""
    numbers = dict(family.numbers)
    for name, way in ends:
        end = 0.95 * numbers[name][0] if way < 0 else 1.05 * numbers[name][1]
        numbers[name] = (end, end)
    true = Family(numbers, family.push, {}, family.second_order, 1.0, family.force)
    return linear(kind, family, true, timely=timely)


def pushed(kind: str, family: Family) -> Callable[[int, int], Floats]:
    """Trials of loops that are pushed 5 % more than is stated."""
    other = Family(family.numbers, 1.05 * family.push, {}, family.second_order, 1.0)
    return linear(kind, family, other)


def unlike_wheels(kind: str, most: float = 1.1) -> Callable[[int, int], Floats]:
    """Trials of two wheels with time constants and gains of their own, each within what is told."""

    def run(trials: int, seed: int) -> Floats:
        stated = scenario(kind, {"limits.v_u1": (1.0, 2.0), "limits.v_u2": (0.7, 1.4)},
                          channels="wheels", d=(0.0, 0.0), odometry=None)  # fmt: skip
        filtering, rng, l = Compiled(stated), np.random.default_rng(seed), stated.robot.l
        found = []
        for start in range(0, trials, BATCH):
            count = min(BATCH, trials - start)
            send, v = filtering.sender(count), np.zeros((2, count))
            kept, worst = rng.integers(5, 60, count), np.zeros(count)
            u = np.zeros((filtering.system.u.numel(), count))
            if kind == "governor":
                u[4] = -1.0
            tau, gain = rng.choice([0.2, 0.3], (2, count)), rng.choice([0.9, most], (2, count))
            for k in range(2 * SAMPLES):
                new = k % kept == 0
                u[:2] = np.where(new, rng.choice([-9.0, 0.0, 9.0], (2, count)), u[:2])
                sent = send(u)
                wheels = np.array([sent[0] + l * sent[1], sent[0] - l * sent[1]])
                for _ in range(PARTS):
                    v = gain * wheels + (v - gain * wheels) * np.exp(-T / PARTS / tau)
                    body = np.abs(v[0] + v[1]) / 2, np.abs(v[0] - v[1]) / (2 * l) / 2.0
                    worst = np.maximum(worst, np.maximum(*body))
            found.append(worst)
        return np.concatenate(found)

    return run


FREE_PI = replace(PI, push=0.0, told={**PI.told, "push": (0.0, 0.0)})
FREE_SWUNG = replace(SWUNG, push=0.0, told={**SWUNG.told, "d": (0.0, 0.0)})
"""The same without a push."""
WEAK_PI = replace(FREE_PI, force=120.0, told={**FREE_PI.told, "force": (120.0, 30.0)})
"""The same with motors that give 120 N: the force that is asked for counts, too."""
SLOW_SWUNG = replace(FREE_SWUNG, told={**FREE_SWUNG.told, "slew": (0.25, 0.25)})
"""Second-order loops behind commands that change by at most 0.25 m/s2."""
ONE = {"M": (65.0, 65.0), "kp": (135.0, 135.0), "ki": (330.0, 330.0), "c": (0.0, 0.0)}
ONE_PI = Family(ONE, 30.0, {
    **PI.told, "mass": ONE["M"], "inertia": (65 / 16, 65 / 16), "kp": ONE["kp"], "ki": ONE["ki"],
    "friction": ONE["c"], "push": (30.0, 0.0),
}, second_order=False)  # fmt: skip
ONE_NUMBERS = {"w0": (4.0, 4.0), "z": (0.3, 0.3), "K": (1.0, 1.0)}
ONE_SWUNG = Family(ONE_NUMBERS, 0.0, {
    **FREE_SWUNG.told, "frequency": ONE_NUMBERS["w0"], "damping": ONE_NUMBERS["z"],
    "gain": ONE_NUMBERS["K"],
}, second_order=True)  # fmt: skip
"""Loops whose numbers are known, so that the tables cover no more than them."""
HARD_SWUNG = replace(SWUNG, push=0.3, told={**SWUNG.told, "d": (0.3, 0.0)})
"""Second-order loops whose pushes take nearly a third of the limit."""
CHAINS: Sequence[Mapping[str, Any]] = tuple(
    {"second_lag": lag, "delay": (0.0, 0.2), "losses": 3, "jitter": 0.02}
    for lag in (0.0, 0.005, 0.05, 0.3)
)
STATEMENTS = (
    Statement("clip, bases that never overshoot", first_order("clip", CHAINS), {
        "push": wrong("clip", d=0.0525), "gain": wrong("clip", gain=(0.9, 1.155)),
    }),
    Statement("clip, PI loops", linear("clip", PI, PI), {
        "mass": beyond("clip", PI, ("M", 1)), "kp": beyond("clip", PI, ("kp", -1)),
        "ki": beyond("clip", PI, ("ki", 1)), "push": pushed("clip", PI),
    }),
    Statement("clip, second-order loops", linear("clip", SWUNG, SWUNG), {
        "damping": beyond("clip", SWUNG, ("z", -1)), "gain": beyond("clip", SWUNG, ("K", 1)),
        "push": pushed("clip", SWUNG),
    }),
    Statement("clip of slow commands, second-order loops", linear("clip", SLOW_SWUNG, SLOW_SWUNG), {
        "gain": beyond("clip", SLOW_SWUNG, ("K", 1)),
        "damping": beyond("clip", SLOW_SWUNG, ("z", -1)),
        "all three": beyond("clip", SLOW_SWUNG, ("K", 1), ("z", -1), ("w0", -1)),
    }),
    Statement("clip, wheels that are not alike", unlike_wheels("clip"), {
        "gain": unlike_wheels("clip", 1.155),
    }),
    Statement("governor, first-order bases", first_order("governor", WORLDS), {
        "push": wrong("governor", d=0.0525), "time constant": wrong("governor", tau=(0.19, 0.3)),
        "gain": wrong("governor", gain=(0.9, 1.155)), "odometry": wrong("governor", error=0.021),
        "delay, by 5 % of a period": wrong("governor", delay=(0.0, 0.0025)),
        "one loss": wrong("governor", losses=1), "jitter, of 5 %": wrong("governor", jitter=0.0025),
        "a second lag of 5 ms": wrong("governor", second_lag=0.005),
    }),
    Statement("governor, wheels that are not alike", unlike_wheels("governor"), {
        "gain": unlike_wheels("governor", 1.155),
    }),
    Statement("band, PI loops", linear("band", FREE_PI, FREE_PI), {
        "mass": beyond("band", FREE_PI, ("M", 1)), "kp": beyond("band", FREE_PI, ("kp", -1)),
        "ki": beyond("band", FREE_PI, ("ki", 1)),
        "all three": beyond("band", FREE_PI, ("M", 1), ("kp", -1), ("ki", 1)),
    }),
    Statement("band, PI loops, steps at any time", linear("band", FREE_PI, FREE_PI, timely=False), {
        "times not told": linear("band", FREE_PI, FREE_PI, timely=False, telling=False),
        "all three": beyond("band", FREE_PI, ("M", 1), ("kp", -1), ("ki", 1), timely=False),
    }),
    Statement("band, PI loops with weak motors", linear("band", WEAK_PI, WEAK_PI), {
        "force": linear("band", WEAK_PI, replace(WEAK_PI, force=0.95 * WEAK_PI.force)),
        "kp": beyond("band", WEAK_PI, ("kp", 1)),
        "all": beyond("band", WEAK_PI, ("M", 1), ("kp", -1), ("ki", 1)),
    }),
    Statement("band, PI loops that are pushed", linear("band", PI, PI), {
        "push": pushed("band", PI),
        "all": beyond("band", PI, ("M", 1), ("kp", -1), ("ki", 1)),
    }),
    Statement("band, a PI loop that is known and pushed", linear("band", ONE_PI, ONE_PI), {
        "push": pushed("band", ONE_PI),
    }),
    Statement("band, second-order loops", linear("band", FREE_SWUNG, FREE_SWUNG), {
        "damping": beyond("band", FREE_SWUNG, ("z", -1)),
        "gain": beyond("band", FREE_SWUNG, ("K", 1)),
        "frequency": beyond("band", FREE_SWUNG, ("w0", -1)),
        "all three": beyond("band", FREE_SWUNG, ("z", -1), ("K", 1), ("w0", -1)),
    }),
    Statement("band, second-order loops that are pushed", linear("band", SWUNG, SWUNG), {
        "push": pushed("band", SWUNG),
        "all": beyond("band", SWUNG, ("z", -1), ("K", 1), ("w0", -1)),
    }),
    Statement("band, second-order loops that are pushed hard", linear(
        "band", HARD_SWUNG, HARD_SWUNG), {"push": pushed("band", HARD_SWUNG)},
    ),
    Statement("band, a second-order loop that is known", linear("band", ONE_SWUNG, ONE_SWUNG), {
        "frequency too low": beyond("band", ONE_SWUNG, ("w0", -1)),
        "frequency too high": beyond("band", ONE_SWUNG, ("w0", 1)),
    }),
)  # fmt: skip


def row(statement: Statement, trials: int, broken: int) -> str:
    """A Markdown row: breaks and the largest |v|/V inside, then those of each broken hypothesis."""
    found = statement.inside(trials, 1)
    teeth = []
    for number, (name, run) in enumerate(statement.broken.items()):
        worst = run(broken, 100 + number)
        teeth.append(f"{name} {np.mean(worst > 1):.0%} ({worst.max():.4f})")
    return (
        f"| {statement.title} | {len(found):,} | {np.sum(found > 1)} | {found.max():.9f} | "
        f"{', '.join(teeth)} |"
    )


def main(arguments: Sequence[str] | None = None) -> None:
    """Run all trials, print the table, and with ``--out`` renew its part of the page."""
    given = page_parser(__doc__, "a hundredth of the trials").parse_args(arguments)
    share = 100 if given.quick else 1
    lines = [
        "| statement | trials | breaks | largest \\|v\\|/V | broken by 5 %: share of "
        f"{BROKEN_TRIALS // share:,} trials beyond the limit (largest \\|v\\|/V) |",
        "|---|---|---|---|---|",
    ]
    for statement in STATEMENTS:
        begin = time.monotonic()
        lines.append(row(statement, TRIALS // share, BROKEN_TRIALS // share))
        print(f"{lines[-1]}  {time.monotonic() - begin:.0f} s", flush=True)
    if given.out:
        renew(given.out, NAME, "\n".join(lines))


if __name__ == "__main__":
    main()
