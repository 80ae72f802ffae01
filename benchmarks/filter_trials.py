"""The filter's statements against adversaries, a hundred thousand trials each.

``python -m benchmarks.filter_trials [--quick] [--only WORDS] [--out docs/explanation/filter.md]``;
with words only the statements whose titles have them, and the page keeps its other rows.  The
filter is the C of its package; bases and adversaries are the tests' own, integrated exactly between
all instants at which something changes.  Where both axes are scaled by one factor, a command that
does not keep the curvature counts as a break.  Then each hypothesis is broken by 5 % (or by the
least that can be: one loss, a lag), and the runs that leave the limit are counted: a statement
whose hypotheses may be broken unnoticed would say nothing.
"""

from __future__ import annotations

import ctypes
import itertools
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.linear_loops import driven, impulses
from benchmarks.native import load_filter
from benchmarks.parts import page_parser, renew
from tests.control.filter.adversary import Base, Sender, fastest
from tests.control.filter.linear_base import pi_base, second_order_base
from wmr_ctrl.control.filter import filter_system
from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.world.scenario import Scenario, load_scenario

NAME = "trials"
TRIALS, BROKEN_TRIALS, BATCH = 100_000, 2_000, 2_000
SAMPLES, T, PARTS = 120, 0.05, 4
Floats = NDArray[np.float64]


class Compiled:
    """The C of a scenario's filter, for many bases at once."""

    def __init__(self, scenario: Scenario, *, float32: bool = False) -> None:
        """Compile it; CompilerError where that fails."""
        self._library = load_filter(scenario, "filter_trials", float32=float32)
        self.scenario, self.system = scenario, filter_system(scenario)
        self.real = np.float32 if float32 else np.float64
        own, rounds = scenario.filter, float32 and scenario.filter.kind == "band"
        self.along = own.scale == "curvature" and not (own.slew or rounds)

    def sender(self, trials: int) -> Sender:
        """A fresh memory for so many bases."""
        y = np.zeros((trials, self.system.y.numel()), self.real)
        x = np.zeros((trials, self._library.wmr_filter_begin(ctypes.c_long(0), None)), self.real)
        self._library.wmr_filter_begin(ctypes.c_long(trials), x.ctypes.data_as(ctypes.c_void_p))
        sizes = trials, self.system.u.numel(), y.shape[1]

        def send(u: Floats) -> Floats:
            given = np.ascontiguousarray(u.T, dtype=self.real)
            pointers = (item.ctypes.data_as(ctypes.c_void_p) for item in (x, given, y))
            self._library.wmr_filter_many(*map(ctypes.c_long, sizes), *pointers)
            sent = y[:, :2].T.astype(float)
            off = self.along & _turned(u, sent, float(np.finfo(self.real).eps))
            return np.where(off, OFF, sent)

        return send


OFF = 1e9
"""A command [m/s] in the place of one that does not keep the curvature."""


def _turned(asked: Floats, sent: Floats, eps: float) -> NDArray[np.bool_]:
    """Where a command is no share of what is asked for, but for roundings."""
    parts = sent[0] * asked[1], sent[1] * asked[0]
    off = np.abs(parts[0] - parts[1]) > 8 * eps * np.abs(parts).sum(axis=0)
    return (off & (np.abs(parts).max(axis=0) > 1e-25)) | (np.sum(asked[:2] * sent, axis=0) < 0)


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
WIDE_TURNS: Mapping[str, Any] = {
    "limits.v_u1": (1.0, 4.0), "limits.v_u2": (0.7, 2.8), "filter.d": (0.05, 0.2),
    "filter.odometry": (0.02, 0.08),
}  # fmt: skip
"""Limits of which that of omega counts for as much at a wheel as that of v."""
RIMS = {**WIDE_TURNS, "filter.wheel_speed": 1.2}
WHEELS = {**WIDE_TURNS, "filter.channels": "wheels"}
BY_SIDE: Mapping[str, Any] = {"limits.v_min": (-0.05, -0.4), "limits.v_max": (0.8, 1.0)}
"""A limit of each direction; backwards no command is admitted, as a push alone leads there."""
WHEEL_SIDES: Mapping[str, Any] = {
    **WIDE_TURNS, "filter.channels": "wheels", "limits.v_min": (-0.3, -4.0),
    "limits.v_max": (0.8, 3.0),
}  # fmt: skip
WORLDS: Sequence[Mapping[str, Any]] = (
    {}, {"delay": (0.03, 0.03)}, {"delay": (0.13, 0.13)}, {"delay": (0.02, 0.06)}, {"losses": 2},
    {"jitter": 0.01}, {"age": 0.08}, {"hold": 0.12, "losses": 1}, {"quantum": 0.03},
    {"age": 0.12, "delay": (0.02, 0.06), "losses": 1, "jitter": 0.004},
)  # fmt: skip


def scenario(kind: str, changes: Mapping[str, Any] = {}, **stated: Any) -> Scenario:
    """A scenario with this filter."""
    keys = {f"filter.{name}": value for name, value in {"kind": kind, **stated}.items()}
    return load_scenario("paper-simulation", {**STATED, **changes, **keys})


def told_of(
    kind: str, base: Base, changes: Mapping[str, Any], scale: str = "curvature"
) -> Scenario:
    """A scenario whose filter is told of this base."""
    V = changes.get("limits.v_u1", (1.0, 1.0))
    stated: dict[str, Any] = {
        "gain": base.gain, "scale": scale,
        "d": tuple(base.d * most + float(np.max(base.gain)) * base.quantum / 2 for most in V),
    }  # fmt: skip
    if kind == "governor":
        stated |= {
            name: getattr(base, name) for name in ("tau", "delay", "losses", "jitter", "age")
        }
        stated |= {"hold": base.hold} if base.hold < np.inf else {}
    return scenario(kind, changes, **stated)


def first_order(
    kind: str,
    worlds: Sequence[Mapping[str, Any]],
    changes: Mapping[str, Any] = {},
    scales: Sequence[str] = ("curvature",),
    **options: Any,
) -> Callable[[int, int], Floats]:
    """Trials of first-order bases, all worlds and scales in turn, with odometry and without.

    ``changes`` of the scenario; further ``options`` are those of the compiled filter.
    """

    def run(trials: int, seed: int) -> Floats:
        cases = [*itertools.product(worlds, (True, False))]
        each, found = -(-trials // len(cases)), []
        for number, (world, heard) in enumerate(cases):
            base = Base(**{"heard": heard, **world})
            stated = told_of(kind, base, changes, scales[number % len(scales)])
            found.append(_chain(stated, base, each, seed + number, **options))
        return np.concatenate(found)[:trials]

    return run


def _chain(stated: Scenario, base: Base, trials: int, seed: int, **options: Any) -> Floats:
    filtering = Compiled(stated, **options)
    batches = [min(BATCH, trials - start) for start in range(0, trials, BATCH)]
    return np.concatenate([
        fastest(stated, base, count, SAMPLES, 1000 * seed + k, lambda _, n: filtering.sender(n))
        for k, count in enumerate(batches)
    ])  # fmt: skip


def wrong(
    kind: str,
    told: Mapping[str, Any] = {},
    changes: Mapping[str, Any] = {},
    scale: str = "curvature",
    **wrongly: Any,
) -> Callable[[int, int], Floats]:
    """Trials of a first-order base beyond what the filter is told."""
    base = Base(**told)
    stated = told_of(kind, base, changes, scale)
    return lambda trials, seed: _chain(stated, base.wrong(**wrongly), trials, seed)


@dataclass(frozen=True)
class Family:
    """Linear loops: intervals of their numbers, their push, and what the filter is told of them.

    ``corners``: the share of its members that lie at corners; ``error`` of the command that acts
    [m/s].
    """

    numbers: Mapping[str, tuple[float, float]]
    push: float
    told: Mapping[str, Any]
    second_order: bool
    corners: float = 0.5
    error: float = 0.0

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


AXES, WHEELS_OF = np.array([(1, 0), (0, 1)]), np.array([(1, 1), (1, -1)])
ALL_FOUR = np.concatenate([AXES, WHEELS_OF])
SPEEDS: Mapping[str, tuple[Floats, Floats]] = {
    "v": (AXES[:1], AXES[:1]), "body": (AXES, AXES), "wheels": (WHEELS_OF, ALL_FOUR),
    "rims": (AXES, ALL_FOUR), "unlike rims": (AXES, ALL_FOUR),
}  # fmt: skip
"""What has a loop, and what is limited, as parts of v and l omega; "rims": of loops alike."""
HEADINGS = np.array([(1, 0), (0, 1), (1, 1), (1, -1), (2, 1), (1, -3)])
"""Where commands may head, in v and l omega."""


@dataclass(frozen=True)
class Calls:
    """When a filter is called, what it is told, and what lies between it and its base.

    ``when``: "in time", "at any time", within ``jitter`` [s] of its "beat", a period "apart" but
    for so much, or each so much too "early".  At most ``losses`` commands in a row are lost, all
    come ``late`` samples late, and where that is worse ``parts`` quarters of a period more.
    """

    when: str = "in time"
    telling: bool = True
    jitter: float = 0.0
    losses: int = 0
    late: int = 0
    parts: int = 0
    samples: int = SAMPLES

    def times(self, rng: np.random.Generator, count: int) -> Floats | None:
        """Times [s] from each sample to the next; None where all are periods."""
        if self.when == "at any time":
            return _times(rng, count)
        if self.when == "in time":
            return None
        ways = [-1.0] if self.when == "early" else [-1.0, 0.0, 1.0]
        off = self.jitter * rng.choice(ways, (count, self.samples + 1))
        return T + (np.diff(off, axis=1) if self.when == "beat" else off[:, 1:])


TIMELY = Calls()


def linear(
    kind: str,
    told: Family,
    true: Family,
    calls: Calls = TIMELY,
    of: str = "v",
    changes: Mapping[str, Any] = {},
    scales: Sequence[str] = ("curvature",),
    **options: Any,
) -> Callable[[int, int], Floats]:
    """Trials of linear loops: drawn demands for most, hill climbing from the worst for the rest.

    ``of``: which speeds are limited; ``options`` are those of the compiled filter.
    """

    def run(trials: int, seed: int) -> Floats:
        rng, found, left = np.random.default_rng(seed), list[Floats](), trials
        stated = [scenario(kind, changes, **told.told, scale=scale) for scale in scales]
        filters = [Compiled(item, **options) for item in stated]
        for item in filters:
            item.along &= calls.when != "at any time"
        for filtering in itertools.cycle(filters):
            if left <= 0:
                break
            batch = _Batch(filtering, true, calls, of, rng, min(BATCH, left))
            for worst in batch.climbed(rng):
                found.append(worst)
                left -= len(worst)
        return np.concatenate(found)[:trials]

    return run


CLIMBS, CLIMBERS = 10, 10
"""Steps of a climb; every how many of the drawn trials, the worst, climb."""
UNTIMELY = (0.0, 0.02, 0.3, 0.9, 1.0, 1.2, 1.7, 3.0)
"""Periods from one step to the next where steps come at any time."""


class _Batch:
    """Robots with what they ask for, how they are pushed, and when their filters are called."""

    def __init__(
        self,
        filtering: Compiled,
        true: Family,
        calls: Calls,
        of: str,
        rng: np.random.Generator,
        count: int,
    ) -> None:
        """Draw them; each is after one of its speeds."""
        stated = filtering.scenario
        l, V = stated.robot.l, np.array(stated.limits.v_u1)
        own, rows = SPEEDS[of]
        axes = 1 if of == "v" else 2
        rim = stated.filter.wheel_speed or min(V[0], l * V[1])
        tops = np.where(rows.all(axis=1), rim, np.abs(rows) @ (V * (1, l)))
        self.loops = (own * (1, l))[:, :axes]
        self.limited = (rows / tops[:, None])[:, :axes] @ np.linalg.inv(own[:, :axes])
        one = true.bases(rng, count)
        members = [one, *(one if of == "rims" else true.bases(rng, count) for _ in own[1:])]
        self.bases = A, b, e = tuple(np.array([item[k] for item in members]) for k in range(3))
        after, (more,) = rng.integers(0, len(rows), count), rng.spawn(1)
        loop = np.abs(self.limited).argmax(axis=1)[after], np.arange(count)
        slow = stated.filter.slew is not None
        asked, self.pushes, wish = _demands(
            rng, (A[loop], b[loop], e[loop]), true.push, calls.samples, slow
        )
        if calls.losses > 1:
            held = np.repeat(more.choice([-1.0, 1.0], (count, calls.samples // 10)), 10, axis=1)
            wish = np.where(more.random((count, 1)) < 0.5, held, wish)
        self.filtering, self.true, self.calls = filtering, true, calls
        self.times = calls.times(rng, count)
        chance = more.choice([-1.0, 1.0], (count, 2))
        self.sides = np.where(rows[after] == 0, chance, np.sign(rows[after])) * V
        self.turns = (HEADINGS / (1, l))[: 1 if axes == 1 else None, :axes]
        seeks = more.random(count) < 0.5
        along = (rows[after] / (1, l))[:, :axes]
        heading = np.where(seeks[:, None], along, more.choice(self.turns, count))
        self.asked, self.wish = (item[:, None] * heading[:, :, None] for item in (asked, wish))
        if axes > 1:
            ends = self._ends(self.limited[after], rim / V[0] - 1 if of.endswith("rims") else 1.0)
            self.asked = np.where(
                (seeks & (np.arange(count) % 4 == 0))[:, None, None], ends, self.asked
            )

    def _ends(self, parts: Floats, rest: float) -> Floats:
        """Commands that are worst for ``parts`` (robots, loops) of what the loops reach.

        Each loop is driven by its own impulse response, seen back from the end; all but the one
        that counts for most at a time go to a ``rest`` of their limit.
        """
        A, b, _ = self.bases
        own = np.stack(
            [impulses(*item, T, self.calls.samples)[:, ::-1] for item in zip(A, b, strict=True)]
        )
        own *= parts.T[:, :, None]
        size = np.where(np.abs(own) < np.abs(own).max(axis=0), rest, 1.0)
        return 9 * np.einsum("al,lrk->rak", np.linalg.inv(self.loops), size * np.sign(own))

    def run(
        self, which: NDArray[np.int64], drawn: Sequence[Floats], times: Floats | None
    ) -> Floats:
        """Largest share of a limit of each of these robots, for demands, wishes and pushes."""
        asked, wish, pushes = drawn
        A, b, e = (item[:, which].reshape(-1, *item.shape[2:]) for item in self.bases)
        sides = self.sides[which, : asked.shape[1]]
        pushed = np.einsum("sa,na,nkp->snkp", self.loops, sides, pushes)
        sender = _wired(self.filtering.sender(len(asked)), self.calls, self.true.error, wish)
        return driven(
            (A, b, e), sender, asked, pushed.reshape(-1, *pushes.shape[1:]), T, times,
            telling=self.calls.telling, loops=self.loops, limited=self.limited,
        )  # fmt: skip

    def climbed(self, rng: np.random.Generator) -> Iterator[Floats]:
        """Largest shares of drawn trials, then of those that climb from the worst of them."""
        times, long = self.times, self.calls.samples
        worst = self.run(np.arange(len(self.asked)), (self.asked, self.wish, self.pushes), times)
        yield worst
        best = np.argsort(worst)[-max(1, len(worst) // CLIMBERS) :]
        known = [item[best] for item in (self.asked, self.wish, self.pushes)]
        worst, times = worst[best], None if times is None else times[best]
        for _ in range(CLIMBS):
            other, wished, pushed = new = [item.copy() for item in known]
            when = None if times is None else times.copy()
            for i in range(len(best)):
                start, size = rng.integers(0, long), rng.integers(1, 12)
                value = rng.choice([-9.0, 0.0, 9.0, rng.uniform(-1, 1)])
                turn = rng.choice(self.turns) if len(self.turns) > 1 else self.turns[0]
                other[i, :, start : start + size] = value * turn[:, None]
                start = rng.integers(0, long)
                pushed[i, start : start + size] *= -1
                wished[i, :, start : start + size] *= -1
                if when is not None and self.calls.when == "at any time":
                    start, size = rng.integers(0, long), rng.integers(1, 12)
                    when[i, start : start + size] = T * rng.choice(UNTIMELY)
            again = self.run(best, new, when)
            yield again
            better = again > worst
            for item, changed in zip(known, new, strict=True):
                item[better] = changed[better]
            worst[better] = again[better]
            if times is not None and when is not None:
                times[better] = when[better]


def _wired(send: Sender, calls: Calls, error: float, wish: Floats) -> Sender:
    """What acts of the commands: off by ``error`` towards what is wished for, late, some lost.

    A command is lost, or comes late, if it may, where it leads away from what is wished for.
    """
    if not (error or calls.losses or calls.late or calls.parts):
        return send
    acting = np.zeros((2, len(wish)))
    lost, under_way, samples = np.zeros(len(wish), int), list[Floats](), iter(wish.T)

    def sending(u: Floats) -> Floats:
        nonlocal acting
        under_way.append(send(u))
        arrived = under_way.pop(0) if len(under_way) > calls.late else np.zeros_like(acting)
        towards = np.sign(next(samples))
        back = np.sum((arrived - acting) * towards, axis=0) < 0
        drop = (lost < calls.losses) & back
        lost[:] = np.where(drop, lost + 1, 0)
        late = drop | (back & (np.arange(PARTS)[:, None] < calls.parts))
        found = np.where(late[:, None], acting, arrived)
        acting = found[-1]
        return found + error * towards

    return sending


def _times(rng: np.random.Generator, count: int) -> Floats:
    """Times [s] from each sample to the next: in time but for some, or all; or none for long."""
    share = np.repeat(rng.choice([0.0, 0.05, 0.3, 1.0], (count, SAMPLES // 20)), 20, axis=1)
    late = rng.random((count, SAMPLES)) < share
    some = np.where(late, rng.choice(UNTIMELY, (count, SAMPLES)), 1.0)
    still = np.arange(SAMPLES) % 40 < rng.integers(20, 40, (count, 1))
    stands = (np.arange(count) % 5 == 0)[:, None]
    return T * np.where(stands, np.where(still, 0.0, 1.0), some)


def _demands(
    rng: np.random.Generator, bases: Sequence[Floats], push: float, samples: int, slow: bool
) -> tuple[Floats, Floats, Floats]:
    """What is asked for, how the base is pushed, and what errors seek, sample by sample.

    By turns: the worst for the base itself seen back from the end, the same after pressing on,
    swings, chance.  The worst of ``slow`` commands rise while the step response is above its end,
    and before it first was.
    """
    A, b, e = bases
    count = len(A)
    swung = impulses(A, b, T, samples)
    seek, worst = np.sign(swung)[:, ::-1], np.sign(swung)
    if slow:
        rest = -np.linalg.solve(A, b[..., None])[:, 0]
        above = np.cumsum(swung, axis=1) * T > rest
        worst = np.where(above | ~np.logical_or.accumulate(above, axis=1), 1.0, -1.0)
    ends = 9 * worst[:, ::-1]
    back = np.sign(impulses(A, e, T / PARTS, samples * PARTS))[:, ::-1]
    style = np.arange(count) % 4
    pressed = np.where(np.arange(samples) < rng.integers(10, 80, (count, 1)), 9.0, ends)
    turns = rng.random((count, samples)) < rng.uniform(0.02, 0.4, (count, 1))
    swings = 9.0 * (-1.0) ** np.cumsum(turns, axis=1)
    chance = rng.uniform(-3, 3, (count, samples))
    asked = np.choose(style[:, None], [ends, pressed, swings, chance])
    own, known = np.repeat(np.sign(asked), PARTS, axis=1), style[:, None] < 2
    pushes = push * np.where(known, back, own)
    wish = np.where(known, seek, np.sign(asked))
    return asked, pushes.reshape(count, samples, PARTS), wish


def beyond(
    kind: str, family: Family, *ends: tuple[str, int], calls: Calls = TIMELY, **how: Any
) -> Callable[[int, int], Floats]:
    """Trials of loops whose numbers ``ends`` are 5 % below their intervals (-1) or above (1)."""
    numbers = dict(family.numbers)
    for name, way in ends:
        end = 0.95 * numbers[name][0] if way < 0 else 1.05 * numbers[name][1]
        numbers[name] = (end, end)
    return linear(kind, family, replace(family, numbers=numbers, corners=1.0), calls, **how)


def pushed(kind: str, family: Family, **how: Any) -> Callable[[int, int], Floats]:
    """Trials of loops that are pushed 5 % more than is stated."""
    return linear(kind, family, replace(family, push=1.05 * family.push, corners=1.0), **how)


FREE_PI = replace(PI, push=0.0, told={**PI.told, "push": (0.0, 0.0)})
FREE_SWUNG = replace(SWUNG, push=0.0, told={**SWUNG.told, "d": (0.0, 0.0)})
"""The same without a push."""
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
CHAINS: Sequence[Mapping[str, Any]] = (
    *({"second_lag": lag, "delay": (0.0, 0.2), "losses": 3, "jitter": 0.02}
      for lag in (0.0, 0.005, 0.05, 0.3)),
    {"hold": 0.12, "quantum": 0.03, "second_lag": 0.05},
)  # fmt: skip
STOPPING: Mapping[str, Any] = {"accel": (2.0, 8.0), "decel": (2.0, 8.0), "loops": "alike"}
"""Ramps of which each axis stops as fast at the rim as the other starts, l being 1/4 m."""
RAMPS: Sequence[Mapping[str, Any]] = (
    STOPPING, {**STOPPING, "delay": (0.0, 0.1), "losses": 2, "second_lag": 0.05},
    {**STOPPING, "accel": (0.5, 6.0), "decel": (3.0, 2.0)},
)  # fmt: skip
APART: Mapping[str, Any] = {"tau": ((0.1, 0.15), (0.4, 0.6)), "gain": ((0.95, 1.05), (0.8, 1.5))}
LATE_APART: Mapping[str, Any] = {
    **APART, "delay": ((0.02, 0.02), (0.02, 0.2)), "losses": 1, "jitter": 0.004, "age": 0.08,
}  # fmt: skip
"""Bounds of v and of omega, each for itself."""
WHEEL_SCALES = ("curvature", "turn", "drive")
SCALES = ("axes", *WHEEL_SCALES)
UNLIKE: Mapping[str, Any] = {"loops": "body", "tau": (0.2, 0.21), "gain": (1.1, 1.1)}
"""Time constants of v and omega 5 % apart."""


def alike(worlds: Sequence[Mapping[str, Any]], loops: str = "alike") -> list[Mapping[str, Any]]:
    """Worlds whose loops of v and omega are alike, or are those of the wheels."""
    return [{**world, "loops": loops} for world in worlds]


def rims_broken(kind: str, **others: Any) -> dict[str, Callable[[int, int], Floats]]:
    """Hypotheses of `filter.wheel_speed` that are broken, by what is broken."""
    broken = {"push": {"d": 0.0525}, "gain": {"gain": (0.9, 1.155)}, "loops 5 % apart": UNLIKE}
    return {name: wrong(kind, {"loops": "alike"}, RIMS, **what)
            for name, what in {**broken, **others}.items()}  # fmt: skip


WHEELED = {"loops": "wheels"}
BODY_PI = replace(PI, told={**PI.told, "push": (10.0, 0.625)})
"""Pushed on both axes alike: l^2 = 1/16 m2."""
RIM_SWUNG = replace(SWUNG, told={**SWUNG.told, "d": (0.05, 0.2)})
ERRING_PI = replace(FREE_PI, error=0.3, told={**FREE_PI.told, "d": (0.3, 0.3)})
"""Commands that are off by so much that 5 % more of it counts for more than what tables cover."""
SLOW = {"w0": (0.5, 0.5), "z": (0.3, 0.3), "K": (1.0, 1.0)}
ONE_SLOW = Family(SLOW, 0.0, {
    **FREE_SWUNG.told, "frequency": SLOW["w0"], "damping": SLOW["z"], "gain": SLOW["K"],
    "slew": (0.15, 0.15),
}, second_order=True)  # fmt: skip
"""A loop with 250 periods a swing behind slow commands."""
SWAYED = {"slew": (0.25, 1.0), "losses": 1, "delay": (0.0, 0.75 * 1.1 * T), "jitter": 0.1 * T}
SWAYED_SWUNG = replace(FREE_SWUNG, told={**FREE_SWUNG.told, **SWAYED})
SWAYED_PI = replace(FREE_PI, told={**FREE_PI.told, **SWAYED})
SWAYING = Calls("apart", telling=False, jitter=0.1 * T, losses=1, parts=3)
"""Slow commands of which one may be lost, all come late by chance, and samples do."""
LATER_SWUNG = replace(FREE_SWUNG, told={**FREE_SWUNG.told, "delay": (0.15, 0.15)})
LATER = Calls(late=3)
FAR_FROM_SWAYING: Mapping[str, Mapping[str, Any]] = {
    "steps early by 70 % of a period": {"when": "early", "jitter": 0.7 * T},
    "forty losses": {"losses": 40},
}
BEAT = replace(FREE_PI, told={**FREE_PI.told, "jitter": T / 10})
EARLY = Calls("early", telling=False, jitter=T / 4)
LOSSY, LONG, ANY_TIME = Calls(losses=2, late=1), Calls(samples=720), Calls("at any time")
ALL_PI = (("M", 1), ("kp", -1), ("ki", 1))
ALL_SWUNG = (("z", -1), ("K", 1), ("w0", -1))
EXACT_CHAINS, EXACT_WORLDS = (
    [world for world in worlds if "quantum" not in world] for worlds in (CHAINS, WORLDS)
)
"""Those without commands that are rounded, an error which counts as a push."""


def sides_broken(kind: str, changes: Mapping[str, Any], loops: str = "body") -> dict[str, Any]:
    """Hypotheses that are broken by 10 % behind a limit of each direction."""
    broken: dict[str, Mapping[str, Any]] = {"push": {"d": 0.055}, "gain": {"gain": (0.9, 1.21)}}
    if kind == "governor":
        broken |= {"time constant": {"tau": (0.18, 0.3)}, "odometry": {"error": 0.022}}
    told = {"loops": loops}
    return {name: wrong(kind, told, changes, **what) for name, what in broken.items()}


STATEMENTS = (
    Statement("clip, bases that never overshoot", first_order("clip", CHAINS, {}, SCALES), {
        "push": wrong("clip", d=0.0525), "gain": wrong("clip", gain=(0.9, 1.155)),
    }),
    Statement("clip, `wheel_speed`", first_order(
        "clip", [*alike(CHAINS), {"tau": (0.2, 0.2)}], RIMS, WHEEL_SCALES), rims_broken("clip"),
    ),
    Statement("clip, `wheel_speed` behind ramps", first_order("clip", RAMPS, RIMS, WHEEL_SCALES), {
        "gain": wrong("clip", STOPPING, RIMS, gain=(0.9, 1.155)),
        "v stops too slowly": wrong("clip", STOPPING, RIMS, decel=(1.9, 8.0)),
        "omega stops too slowly": wrong("clip", STOPPING, RIMS, decel=(2.0, 7.6)),
    }),
    Statement("clip, wheels that are not alike", first_order(
        "clip", alike(CHAINS, "wheels"), WHEELS, WHEEL_SCALES), {
        "push": wrong("clip", WHEELED, WHEELS, d=0.0525),
        "gain": wrong("clip", WHEELED, WHEELS, gain=(0.9, 1.155)),
    }),
    Statement("clip, PI loops", linear("clip", PI, PI), {
        "mass": beyond("clip", PI, ("M", 1)), "kp": beyond("clip", PI, ("kp", -1)),
        "ki": beyond("clip", PI, ("ki", 1)), "push": pushed("clip", PI),
    }),
    Statement("clip, PI loops, both axes, lost and late commands that are off", linear(
        "clip", ERRING_PI, ERRING_PI, LOSSY, of="body"), {
        "error": linear("clip", ERRING_PI, replace(ERRING_PI, error=0.315), of="body"),
        "all three": beyond("clip", ERRING_PI, *ALL_PI, of="body"),
    }),
    Statement("clip, second-order loops", linear("clip", SWUNG, SWUNG), {
        "damping": beyond("clip", SWUNG, ("z", -1)), "gain": beyond("clip", SWUNG, ("K", 1)),
        "push": pushed("clip", SWUNG),
    }),
    Statement("clip, second-order loops, `wheel_speed`", linear(
        "clip", RIM_SWUNG, RIM_SWUNG, of="rims", changes=RIMS, scales=WHEEL_SCALES), {
        "damping": beyond("clip", RIM_SWUNG, ("z", -1), of="rims", changes=RIMS),
        "gain": beyond("clip", RIM_SWUNG, ("K", 1), of="rims", changes=RIMS),
        "push": pushed("clip", RIM_SWUNG, of="rims", changes=RIMS),
        "loops apart": linear("clip", RIM_SWUNG, RIM_SWUNG, of="unlike rims", changes=RIMS),
    }),
    Statement("clip, second-order loops, wheels that are not alike", linear(
        "clip", RIM_SWUNG, RIM_SWUNG, of="wheels", changes=WHEELS, scales=WHEEL_SCALES), {
        "damping": beyond("clip", RIM_SWUNG, ("z", -1), of="wheels", changes=WHEELS),
        "gain": beyond("clip", RIM_SWUNG, ("K", 1), of="wheels", changes=WHEELS),
    }),
    Statement("clip of slow commands, second-order loops", linear("clip", SLOW_SWUNG, SLOW_SWUNG), {
        "gain": beyond("clip", SLOW_SWUNG, ("K", 1)),
        "damping": beyond("clip", SLOW_SWUNG, ("z", -1)),
        "all three": beyond("clip", SLOW_SWUNG, *ALL_SWUNG),
    }),
    Statement("clip of slow commands, a second-order loop that is known", linear(
        "clip", ONE_SLOW, ONE_SLOW, LONG), {
        name: beyond("clip", ONE_SLOW, end, calls=LONG)
        for name, end in zip(("damping", "gain", "frequency"), ALL_SWUNG, strict=True)
    }),
    *(Statement(f"clip of slow commands, {name} loops, both axes, lost, late and not in time",
                linear("clip", family, family, SWAYING, of="body", changes=WIDE_TURNS), {
        "all three": beyond("clip", family, *ends, calls=SWAYING, of="body", changes=WIDE_TURNS),
        **{what: linear("clip", family, family, replace(SWAYING, **calls), of="body",
                        changes=WIDE_TURNS)
           for what, calls in FAR_FROM_SWAYING.items()},
    }) for name, family, ends in (("second-order", SWAYED_SWUNG, ALL_SWUNG),
                                  ("PI", SWAYED_PI, ALL_PI))),
    Statement("clip in single precision, bases that never overshoot", first_order(
        "clip", CHAINS, {}, SCALES, float32=True), {
        "gain": wrong("clip", gain=(0.9, 1.155)),
    }),
    Statement("clip in single precision, `wheel_speed`", first_order(
        "clip", alike(CHAINS), RIMS, WHEEL_SCALES, float32=True), {
        "gain": wrong("clip", {"loops": "alike"}, RIMS, gain=(0.9, 1.155)),
    }),
    Statement("clip in single precision, second-order loops, wheels that are not alike", linear(
        "clip", RIM_SWUNG, RIM_SWUNG, of="wheels", changes=WHEELS, scales=WHEEL_SCALES,
        float32=True), {
        "damping": beyond("clip", RIM_SWUNG, ("z", -1), of="wheels", changes=WHEELS, float32=True),
    }),
    *(Statement(f"{kind}, a limit of each direction", first_order(kind, worlds, BY_SIDE, SCALES),
                sides_broken(kind, BY_SIDE))
      for kind, worlds in (("clip", EXACT_CHAINS), ("governor", EXACT_WORLDS))),
    *(Statement(f"{kind}, wheels, a limit of each direction", first_order(
        kind, alike(worlds, "wheels"), WHEEL_SIDES, WHEEL_SCALES),
        sides_broken(kind, WHEEL_SIDES, "wheels"))
      for kind, worlds in (("clip", CHAINS), ("governor", WORLDS))),
    Statement("governor, first-order bases", first_order("governor", WORLDS, {}, SCALES), {
        "push": wrong("governor", d=0.0525), "time constant": wrong("governor", tau=(0.19, 0.3)),
        "gain": wrong("governor", gain=(0.9, 1.155)), "odometry": wrong("governor", error=0.021),
        "delay, by 5 % of a period": wrong("governor", delay=(0.0, 0.0025)),
        "one loss": wrong("governor", losses=1), "jitter, of 5 %": wrong("governor", jitter=0.0025),
        "a second lag of 5 ms": wrong("governor", second_lag=0.005),
        "hold": wrong("governor", {"hold": 0.12}, hold=0.126),
    }),
    Statement("governor, bounds by axis", first_order(
        "governor", [APART, LATE_APART], {}, SCALES), {
        "gain of v": wrong("governor", APART, gain=((0.95, 1.1025), (0.8, 1.5))),
        "gain of omega": wrong("governor", APART, gain=((0.95, 1.05), (0.8, 1.575))),
        "tau of omega": wrong("governor", APART, tau=((0.1, 0.15), (0.38, 0.6))),
    }),
    Statement("governor, `wheel_speed`", first_order("governor", alike(WORLDS), RIMS, WHEEL_SCALES),
              rims_broken("governor", **{
        "gains apart": {"loops": "body", "tau": (0.2, 0.2), "gain": (1.045, 1.1)},
        "time constant": {"tau": (0.19, 0.3)}, "odometry": {"error": 0.021},
        "one loss": {"losses": 1},
    })),
    Statement("governor, wheels that are not alike", first_order(
        "governor", alike(WORLDS, "wheels"), WHEELS, WHEEL_SCALES), {
        "push": wrong("governor", WHEELED, WHEELS, d=0.0525),
        "gain": wrong("governor", WHEELED, WHEELS, gain=(0.9, 1.155)),
        "time constant": wrong("governor", WHEELED, WHEELS, tau=(0.19, 0.3)),
    }),
    Statement("governor in single precision, `wheel_speed`", first_order(
        "governor", alike(WORLDS), RIMS, WHEEL_SCALES, float32=True), {
        "time constant": wrong("governor", {"loops": "alike"}, RIMS, tau=(0.19, 0.3)),
    }),
    Statement("band, PI loops", linear("band", FREE_PI, FREE_PI), {
        "mass": beyond("band", FREE_PI, ("M", 1)), "kp": beyond("band", FREE_PI, ("kp", -1)),
        "ki": beyond("band", FREE_PI, ("ki", 1)),
        "all three": beyond("band", FREE_PI, *ALL_PI),
    }),
    Statement("band, PI loops, both axes by one factor, commands that are off", linear(
        "band", ERRING_PI, ERRING_PI, of="body"), {
        "error": linear("band", ERRING_PI, replace(ERRING_PI, error=0.315), of="body"),
        "all three": beyond("band", ERRING_PI, *ALL_PI, of="body"),
    }),
    Statement("band, PI loops, both axes not by one factor", linear(
        "band", BODY_PI, BODY_PI, of="body", scales=SCALES[::2]), {
        "all three": beyond("band", BODY_PI, *ALL_PI, of="body", scales=SCALES[:1]),
    }),
    Statement("band in single precision, PI loops", linear("band", PI, PI, float32=True), {
        "all three": beyond("band", PI, *ALL_PI, float32=True),
    }),
    Statement("band, PI loops, steps within jitter of the beat, untold", linear(
        "band", BEAT, BEAT, Calls("beat", jitter=T / 10, telling=False)), {
        "all three": beyond("band", BEAT, *ALL_PI, calls=Calls("beat", jitter=T / 10)),
        "steps early by a quarter of a period": linear("band", BEAT, BEAT, EARLY),
    }),
    Statement("band, PI loops, steps at any time", linear("band", FREE_PI, FREE_PI, ANY_TIME), {
        "times not told": linear("band", FREE_PI, FREE_PI, replace(ANY_TIME, telling=False)),
        "all three": beyond("band", FREE_PI, *ALL_PI, calls=ANY_TIME),
    }),
    Statement("band, PI loops that are pushed", linear("band", PI, PI), {
        "push": pushed("band", PI), "all": beyond("band", PI, *ALL_PI),
    }),
    Statement("band, a PI loop that is known and pushed", linear("band", ONE_PI, ONE_PI), {
        "push": pushed("band", ONE_PI),
    }),
    Statement("band, second-order loops", linear("band", FREE_SWUNG, FREE_SWUNG), {
        "damping": beyond("band", FREE_SWUNG, ("z", -1)),
        "gain": beyond("band", FREE_SWUNG, ("K", 1)),
        "frequency": beyond("band", FREE_SWUNG, ("w0", -1)),
        "all three": beyond("band", FREE_SWUNG, *ALL_SWUNG),
    }),
    Statement("band, second-order loops that are pushed", linear("band", SWUNG, SWUNG), {
        "push": pushed("band", SWUNG),
        "all": beyond("band", SWUNG, *ALL_SWUNG),
    }),
    Statement("band in single precision, second-order loops that are pushed", linear(
        "band", SWUNG, SWUNG, float32=True), {
        "all": beyond("band", SWUNG, *ALL_SWUNG, float32=True),
    }),
    Statement("band, second-order loops, commands late by a constant time", linear(
        "band", LATER_SWUNG, LATER_SWUNG, LATER), {
        "ten losses": linear("band", LATER_SWUNG, LATER_SWUNG, replace(LATER, losses=10)),
        "all three": beyond("band", LATER_SWUNG, *ALL_SWUNG, calls=LATER),
    }),
    Statement("band, second-order loops that are pushed hard", linear(
        "band", HARD_SWUNG, HARD_SWUNG), {"push": pushed("band", HARD_SWUNG)},
    ),
    Statement("band, a second-order loop that is known", linear("band", ONE_SWUNG, ONE_SWUNG), {
        "frequency too low": beyond("band", ONE_SWUNG, ("w0", -1)),
        "frequency too high": beyond("band", ONE_SWUNG, ("w0", 1)),
    }),
)  # fmt: skip


ITS_WHEELS: Sequence[Mapping[str, Any]] = ({"channels": "wheels"}, {"wheel_speed": 1.0})
REFUSED: Sequence[tuple[str, str, Family | None, Sequence[Mapping[str, Any]]]] = (
    ("governor of second-order loops", "governor", SWUNG, [{}]),
    ("governor of PI loops", "governor", PI, [{}]),
    ("band of first-order loops", "band", None, [{}]),
    ("band with losses", "band", SWUNG, [{"losses": 1}]),
    ("band, a base that stops by itself", "band", SWUNG, [{"hold": 0.5}]),
    ("band, a delay that varies", "band", SWUNG, [{"delay": (0.0, 0.02)}]),
    ("band with odometry, or of wheels", "band", SWUNG, [{"odometry": (0.1, 0.1)}, *ITS_WHEELS]),
    ("clip, PI loops of wheels", "clip", PI, ITS_WHEELS),
    ("band with `slew`", "band", SWUNG, [{"slew": (0.1, 0.1)}]),
    ("clip with `slew`, a base that stops by itself, or of wheels", "clip", SLOW_SWUNG,
     [{"hold": 0.5}, *ITS_WHEELS]),
    ('clip with `scale = "axes"`, of wheels', "clip", SWUNG,
     [{"scale": "axes", **own} for own in ITS_WHEELS]),
)  # fmt: skip
"""Combinations that are refused: in words, then a filter's kind, family and further keys."""


def refusals() -> str:
    """A Markdown list of what is refused."""
    return "\n".join(f"- {what}" for what, *_ in REFUSED)


def refused(number: int) -> bool:
    """Whether every filter of a row of REFUSED is."""
    _, kind, family, every = REFUSED[number]
    return all(_refused(kind, {**(family.told if family else {}), **own}) for own in every)


def _refused(kind: str, stated: Mapping[str, Any]) -> bool:
    try:
        filter_system(scenario(kind, **stated))
    except ScenarioError:
        return True
    return False


def row(statement: Statement, trials: int, broken: int) -> str:
    """A Markdown row: the largest |v|/V inside, then that of each broken hypothesis."""
    found = statement.inside(trials, 1)
    if (found > 1).any():
        raise SystemExit(f"{statement.title}: {np.sum(found > 1)} trials broke the limit")
    teeth = []
    for number, (name, run) in enumerate(statement.broken.items()):
        worst = run(broken, 100 + number)
        teeth.append(f"{name} {np.mean(worst > 1):.0%} ({worst.max():.4f})")
    return f"| {statement.title} | {found.max():.9f} | {', '.join(teeth)} |"


def rows_of(page: Path) -> dict[str, str]:
    """Rows of the table on the page, by the statement's title."""
    part = page.read_text(encoding="utf-8").partition(f"<!-- begin {NAME} -->")[2]
    rows = part.partition(f"<!-- end {NAME} -->")[0].splitlines()
    return {line.split("|")[1].strip(): line for line in rows if line.startswith("|")}


def main(arguments: Sequence[str] | None = None) -> None:
    """Run all trials, print the table, and with ``--out`` renew its part of the page."""
    parser = page_parser(__doc__, "a hundredth of the trials")
    parser.add_argument("--only", default="", metavar="WORDS", help="statements with these words")
    given = parser.parse_args(arguments)
    share = 100 if given.quick else 1
    lines = [
        "| statement | largest \\|v\\|/V | broken by 5 %: share of "
        f"{BROKEN_TRIALS // share:,} trials beyond the limit (largest \\|v\\|/V) |",
        "|---|---|---|",
    ]
    known = rows_of(given.out) if given.out else {}
    for statement in STATEMENTS:
        if given.only not in statement.title:
            lines += [known[statement.title]] if statement.title in known else []
            continue
        begin = time.monotonic()
        lines.append(row(statement, TRIALS // share, BROKEN_TRIALS // share))
        print(f"{lines[-1]}  {time.monotonic() - begin:.0f} s", flush=True)
    if given.out:
        renew(given.out, NAME, "\n".join(lines))
        renew(given.out, "refused", refusals())


if __name__ == "__main__":
    main()
