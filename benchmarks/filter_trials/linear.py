"""Linear loops that may overshoot, against the clip and the band, with hill climbing."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.linear_loops import driven, impulses

from .adversary import Sender
from .compiled import BATCH, SAMPLES, Compiled, Floats, T, scenario
from .linear_base import pi_base, second_order_base

PARTS = 4


@dataclass(frozen=True)
class Family:
    """Linear loops: intervals of their numbers, their push, and the values stated to the filter.

    ``corners``: share of the members at corners; ``error``: error of the acting command [m/s].
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
SWUNG_SIDES: Mapping[str, Any] = {"limits.v_min": (-0.6, -1.0), "limits.v_max": (1.0, 1.0)}
"""Unequal limits, both of which the clip uses, because a loop also swings back."""

AXES, WHEELS_OF = np.array([(1, 0), (0, 1)]), np.array([(1, 1), (1, -1)])
ALL_FOUR = np.concatenate([AXES, WHEELS_OF])
SPEEDS: Mapping[str, tuple[Floats, Floats]] = {
    "v": (AXES[:1], AXES[:1]), "body": (AXES, AXES), "wheels": (WHEELS_OF, ALL_FOUR),
    "rims": (AXES, ALL_FOUR), "unlike rims": (AXES, ALL_FOUR),
}  # fmt: skip
"""Quantities with loops, and limited speeds, by parts of v and l omega; "rims": of equal loops."""
HEADINGS = np.array([(1, 0), (0, 1), (1, 1), (1, -1), (2, 1), (1, -3)])
"""Directions of commands, in v and l omega."""


@dataclass(frozen=True)
class Calls:
    """Times of a filter's calls, its knowledge, and the effects between it and its base.

    ``when``: "in time", "at any time", within ``jitter`` [s] of a "beat", a period "apart" give or
    take ``jitter``, or each ``jitter`` too "early". At most ``losses`` commands in a row are
    lost. All come ``late`` samples late, and ``parts`` quarters of a period more if that is worse.
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

    ``of``: limited speeds; ``options``: those of the compiled filter.
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
"""Steps of a hill climb, and drawn trials per climber; the worst ones climb."""
UNTIMELY = (0.0, 0.02, 0.3, 0.9, 1.0, 1.2, 1.7, 3.0)
"""Times between steps that come at any time, in periods."""


class _Batch:
    """Robots with their demands, pushes, and times at which their filters are called."""

    def __init__(
        self,
        filtering: Compiled,
        true: Family,
        calls: Calls,
        of: str,
        rng: np.random.Generator,
        count: int,
    ) -> None:
        """Draw the robots; each tries to exceed one of its limited speeds."""
        stated = filtering.scenario
        l, V = stated.robot.l, np.array(stated.limits.v_u1)
        own, rows = SPEEDS[of]
        axes = 1 if of == "v" else 2
        rim = stated.filter.wheel_speed or min(V[0], l * V[1])
        self.signed = bool(stated.limits.unequal)
        if self.signed:
            rows = np.concatenate([rows, -rows])
        ahead, back = (
            np.abs(limit) * (1, l) for limit in (stated.limits.v_max, stated.limits.v_min)
        )
        each = np.maximum(rows, 0) @ ahead + np.maximum(-rows, 0) @ back
        tops = np.where(rows.all(axis=1), rim, each)
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
        """Commands that make ``parts`` (robots, loops) of the speeds in the loops largest.

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
        """Largest speed of each of these robots over its limit, for demands, wishes and pushes."""
        asked, wish, pushes = drawn
        A, b, e = (item[:, which].reshape(-1, *item.shape[2:]) for item in self.bases)
        sides = self.sides[which, : asked.shape[1]]
        pushed = np.einsum("sa,na,nkp->snkp", self.loops, sides, pushes)
        sender = _wired(self.filtering.sender(len(asked)), self.calls, self.true.error, wish)
        return driven(
            (A, b, e), sender, asked, pushed.reshape(-1, *pushes.shape[1:]), T, times,
            telling=self.calls.telling, loops=self.loops, limited=self.limited, signed=self.signed,
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
    """Commands that act: off by ``error`` towards ``wish``, late, some lost.

    A command is lost, or comes late, if it may and if it leads away from ``wish``.
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
    """Times [s] from each sample to the next: punctual with exceptions, or all late, or a gap."""
    share = np.repeat(rng.choice([0.0, 0.05, 0.3, 1.0], (count, SAMPLES // 20)), 20, axis=1)
    late = rng.random((count, SAMPLES)) < share
    some = np.where(late, rng.choice(UNTIMELY, (count, SAMPLES)), 1.0)
    still = np.arange(SAMPLES) % 40 < rng.integers(20, 40, (count, 1))
    stands = (np.arange(count) % 5 == 0)[:, None]
    return T * np.where(stands, np.where(still, 0.0, 1.0), some)


def _demands(
    rng: np.random.Generator, bases: Sequence[Floats], push: float, samples: int, slow: bool
) -> tuple[Floats, Floats, Floats]:
    """Demands, pushes of the base and directions of errors, sample by sample.

    By turns: the worst for the base itself, computed backwards from the end; the same after a
    constant demand; oscillations; random demands. The worst of ``slow`` commands rise while the
    step response is above its final value, and before it first exceeds this.
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
"""The loops above without a push."""
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
"""Loops with known numbers, so that the tables cover these alone."""
HARD_SWUNG = replace(SWUNG, push=0.3, told={**SWUNG.told, "d": (0.3, 0.0)})
"""Second-order loops with pushes that cause nearly a third of the limit."""
BODY_PI = replace(PI, told={**PI.told, "push": (10.0, 0.625)})
"""Loops of the body with equal pushes on both axes: l^2 = 1/16 m2."""
RIM_SWUNG = replace(SWUNG, told={**SWUNG.told, "d": (0.05, 0.2)})
ERRING_PI = replace(FREE_PI, error=0.3, told={**FREE_PI.told, "d": (0.3, 0.3)})
"""Command errors so large that 5 % more exceeds the reserve of the tables."""
SLOW = {"w0": (0.5, 0.5), "z": (0.3, 0.3), "K": (1.0, 1.0)}
ONE_SLOW = Family(SLOW, 0.0, {
    **FREE_SWUNG.told, "frequency": SLOW["w0"], "damping": SLOW["z"], "gain": SLOW["K"],
    "slew": (0.15, 0.15),
}, second_order=True)  # fmt: skip
"""Loop with 250 periods per oscillation, behind slow commands."""
SWAYED = {"slew": (0.25, 1.0), "losses": 1, "delay": (0.0, 0.75 * 1.1 * T), "jitter": 0.1 * T}
SWAYED_SWUNG = replace(FREE_SWUNG, told={**FREE_SWUNG.told, **SWAYED})
SWAYED_PI = replace(FREE_PI, told={**FREE_PI.told, **SWAYED})
SWAYING = Calls("apart", telling=False, jitter=0.1 * T, losses=1, parts=3)
"""Slow commands, one of which may be lost; commands and samples are late at random."""
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
