"""A base with first-order speed loops, driven by an adversary; it shares no code with the filter.

Many trials at once, each a row: exact exponentials between the instants at which commands take
over, and in each piece the gain, time constant, push, error of odometry that are worst for the side
of the limit that the trial is after.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from wmr_ctrl.control.filter import filter_system
from wmr_ctrl.world.scenario import Scenario

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
NONE, LONG_AGO = (np.inf, np.inf), -1e9
RAMPED = 6
"""Number of parts of a sample in which ramped commands are held."""


Interval = tuple[float, float] | tuple[tuple[float, float], tuple[float, float]]


@dataclass(frozen=True)
class Base:
    """True numbers of the base and its connection: intervals from which the adversary chooses.

    ``tau``, ``gain``, ``delay``: one interval of both axes, or two. ``loops``: loops of the "body"
    (v and omega) or the "wheels"; if v and omega are "alike", they have one time constant and
    gain. ``d`` and ``error``, of both axes, are shares of their limits. ``accel``, ``decel``:
    ramps of the firmware, as in [base]. A base that hears nothing for ``hold`` stops; with it,
    nothing is sent now and then for some periods. A command within ``deadband``, or the part of
    one within ``wheel_deadband`` at a rim, may act as 0.
    """

    tau: Interval = (0.2, 0.3)
    gain: Interval = (0.9, 1.1)
    d: float = 0.05
    error: float = 0.02
    delay: Interval = (0.0, 0.0)
    losses: int = 0
    jitter: float = 0.0
    age: float = 0.0
    heard: bool = True
    second_lag: float = 0.0
    loops: str = "body"
    accel: tuple[float, float] = NONE
    decel: tuple[float, float] = NONE
    hold: float = np.inf
    quantum: float = 0.0
    deadband: tuple[float, float] = (0.0, 0.0)
    wheel_deadband: float = 0.0

    def wrong(self, **changes: Any) -> Base:
        """Copy of the base with some numbers beyond their stated bounds."""
        return replace(self, **changes)

    def bands(self, l: float) -> tuple[Floats, Floats] | None:
        """Speeds that have a dead band, as parts of v and omega, and its size; None without one."""
        if self.wheel_deadband:
            return np.array([[1.0, l], [1.0, -l]]), np.full(2, self.wheel_deadband)
        return (np.eye(2), np.array(self.deadband)) if any(self.deadband) else None


Sender = Callable[[Floats], Floats]
"""Function with its own memory: inputs (inputs, trials) to commands (2, trials)."""


def graphs(scenario: Scenario, trials: int) -> Sender:
    """The filter's graph for so many bases."""
    system = filter_system(scenario)
    step = system.function("filter", [system.update, system.y]).map(trials)
    x, p = (ca.repmat(ca.DM(item), 1, trials) for item in (system.x0, system.p0))

    def send(u: Floats) -> Floats:
        nonlocal x
        x, out = step(ca.DM(u), x, p)
        x = ca.DM(x)
        return np.asarray(out)[:2]

    return send


def limited_speeds(scenario: Scenario) -> tuple[Floats, Floats, Floats]:
    """Limited speeds, each as its parts of v and omega, and their limits.

    The larger of both directions, then those of each, forwards first.
    """
    rim, l, limits = scenario.filter.wheel_speed, scenario.robot.l, scenario.limits
    rows, tops = [(1.0, 0.0), (0.0, 1.0)], [*limits.v_u1]
    sides = [(high, -low) for low, high in zip(limits.v_min, limits.v_max, strict=True)]
    if rim is not None:
        rows, tops = [*rows, (1.0, l), (1.0, -l)], [*tops, rim, rim]
        sides += [(rim, rim)] * 2
    return np.array(rows), np.array(tops), np.array(sides)


def fastest(
    scenario: Scenario,
    base: Base,
    trials: int = 400,
    samples: int = 200,
    seed: int = 0,
    sending: Callable[[Scenario, int], Sender] = graphs,
) -> Floats:
    """Largest share of a limit in each trial, over all instants at which a piece ends.

    Each trial tries to exceed one of the limited speeds.
    """
    rng = np.random.default_rng(seed)
    send, T, l = sending(scenario, trials), scenario.clock.control, scenario.robot.l
    governs, every = scenario.filter.kind == "governor", np.arange(trials)
    loops = np.array([[1.0, l], [1.0, -l]] if base.loops == "wheels" else np.eye(2))
    back, (rows, tops, sides) = np.linalg.inv(loops), limited_speeds(scenario)
    after = rng.integers(0, len(rows), trials)
    weights, chance = (rows @ back)[after], rng.choice([-1.0, 1.0], (trials, 2))
    towards, seen_as = (np.where(w == 0, chance, np.sign(w)) for w in (weights, rows[after]))
    ends = base.d * np.abs(loops) @ tops[:2]
    own, rim = np.sign(rows[after]) / (1.0, l), np.array(HEADINGS) / (1.0, l)
    heading = np.where((every % 2 == 0)[:, None], own, rng.choice(rim, trials) * seen_as)
    delays = np.reshape(base.delay, (-1, 2))  # of both axes, or of each
    tau, K = (np.reshape(item, (-1, 2)).T for item in (base.tau, base.gain))
    keep = int(np.ceil((delays.max() + base.age) / (T - base.jitter))) + base.losses + 3
    sent, since = np.zeros((trials, keep, 2)), np.full((trials, keep, 2), LONG_AGO)
    v, inner, acting = (np.zeros((trials, 2)) for _ in range(3))
    now, way, dt, worst = np.zeros(trials), np.ones(trials), np.zeros(trials), np.zeros(trials)
    past_v, past_t, lost = [v], [now], np.zeros(trials, int)
    style = rng.integers(0, 3, trials)  # presses on, swings, acts at random
    ramps = bool(np.isfinite([base.accel, base.decel]).any())
    bands, quiet, shares = base.bands(l), np.zeros(trials, bool), np.zeros((trials, 2))
    inside = np.linspace(0, 1, RAMPED)[1:-1] if ramps else np.zeros(0)
    for _ in range(samples):
        turns = (style > 0) & (rng.random(trials) < 0.05)
        way = np.where(turns & (rng.random(trials) < 0.6), -way, way)
        signs = np.where(rng.random((trials, 1)) < 0.7, seen_as, rng.choice([-1, 1], (trials, 2)))
        drawn = np.where(rng.random((trials, 1)) < 0.3, own, rng.choice(rim, trials) * signs)
        heading = np.where(turns[:, None] & (every % 4 > 0)[:, None], drawn, heading)
        loud = np.where((style == 2)[:, None], 2 * tops[:2] * rng.uniform(-1, 1, (trials, 2)),
                        10 * way[:, None] * heading)  # fmt: skip
        if bands is not None:
            changes = (rng.random(trials) < 0.1) & ((style > 0) | (every % 3 > 0))
            changes |= now == 0
            quiet = np.where(changes, rng.random(trials) < 0.5, quiet)
            others = rng.choice(EDGES, (trials, 2), p=[0.5, 0.2, 0.1, 0.1, 0.1])
            shares = np.where(changes[:, None], others, shares)
            small = _on_the_edge(scenario, bands, after, way[:, None] * seen_as, shares)
            loud = np.where(quiet[:, None], small, loud)
        old, seen = _recorded(past_t, past_v, now - rng.choice([0.0, base.age], trials))
        lie = np.where((style == 2)[:, None], rng.uniform(-1, 1, (trials, 2)), way[:, None])
        there = np.full(trials, base.heard) & ((style < 2) | (rng.random(trials) < 0.5))
        u = np.zeros((6 if governs else 3, trials))
        u[:2], u[-1] = loud.T, dt
        if governs:
            y = seen @ back.T - base.error * tops[:2] * seen_as * lie
            u[2:4], u[4] = y.T, np.where(there, now - old, -1.0)
        command = send(u)[:2].T
        if base.quantum:
            command = base.quantum * np.round(command / base.quantum)
        if bands is not None:
            command = _heard(command, bands, (style < 2) | (rng.random(trials) < 0.5))
        drop = (rng.random(trials) < 0.5) & (lost < base.losses)
        lost = np.where(drop, lost + 1, 0)
        late = [rng.choice([*ends, rng.uniform(*ends)], trials) for ends in delays]
        takes = np.maximum(now[:, None] + np.transpose(late), _newest(since))
        takes = np.where(drop[:, None], np.inf, takes)
        sent = np.concatenate([sent[:, 1:], command[:, None]], axis=1)
        since = np.concatenate([since[:, 1:], takes[:, None]], axis=1)
        dt = T + base.jitter * rng.choice([-1.0, 0.0, 1.0], trials)
        if np.isfinite(base.hold):
            dt = np.where(rng.random(trials) < 0.02, T * rng.uniform(1, 9, trials), dt)
        end = now + dt
        taken = since.reshape(trials, -1)
        cuts = np.c_[now, taken, end, now[:, None] + dt[:, None] * inside]
        if np.isfinite(base.hold):
            cuts = np.c_[cuts, taken + base.hold]
        cuts = np.sort(np.clip(cuts, now[:, None], end[:, None]), axis=1)
        for a, b in zip(cuts.T[:-1], cuts.T[1:], strict=True):
            began, ages = since <= a[:, None, None], np.arange(keep)[:, None]
            place = np.argmax(np.where(began, ages, -1), axis=1)[:, None]
            last, told = (np.take_along_axis(item, place, 1)[:, 0] for item in (since, sent))
            given = np.where(a[:, None] < last + base.hold, told, 0)
            acting = _ramped(acting, given, base, (b - a)[:, None]) if ramps else given
            told = acting @ loops.T
            share = np.where(style == 2, rng.random(trials), 1.0)[:, None]
            side = way[:, None] * (weights if base.loops == "alike" else towards)
            gain = np.where(_forward(told * side, base), K[1], K[0])
            aim = gain * told + way[:, None] * towards * ends * share
            if base.second_lag:
                aim = inner = aim + (inner - aim) * np.exp(-(b - a) / base.second_lag)[:, None]
            quick = _forward((aim - v) * side, base)
            v = aim + (v - aim) * np.exp(-(b - a)[:, None] / np.where(quick, tau[0], tau[1]))
            reached = v @ (rows @ back).T
            of_limit = np.maximum(reached / sides[:, 0], -reached / sides[:, 1])
            worst = np.maximum(worst, of_limit.max(axis=1))
            past_v.append(v)
            past_t.append(b)
        now = end
        past_v, past_t = past_v[-8 * keep :], past_t[-8 * keep :]
    return worst


HEADINGS = ((1, 0), (0, 1), (1, 1), (5, 1), (1, 5))
"""Further directions of commands, as sizes of v and l omega, beside that of the attacked speed."""


def _heard(command: Floats, bands: tuple[Floats, Floats], drops: Flags) -> Floats:
    """Commands (trials, 2) that act behind dead bands, in trials in which these drop small ones."""
    rows, sizes = bands
    parts = command @ rows.T
    small = drops[:, None] & (np.abs(parts) < sizes)
    left = np.where(small, 0.0, parts) @ np.linalg.inv(rows).T
    return np.where(small.any(axis=1, keepdims=True), left, command)


EDGE = 0.999
EDGES = (-EDGE, EDGE, -0.5, 0.3, 1.5)
"""Requested shares of a dead band: just within it, then others."""


def _on_the_edge(
    scenario: Scenario,
    bands: tuple[Floats, Floats],
    after: NDArray[np.int64],
    side: Floats,
    shares: Floats,
) -> Floats:
    """Commands (trials, 2) with a part within a dead band.

    A rim's part is in it while the attacked speed is as fast as the clip admits; or ``shares`` of
    it.
    """
    rows, sizes = bands
    both = sizes * shares * side @ np.linalg.inv(rows).T
    if rows[0, 1] == 0:
        return both
    stated, i, each = scenario.filter, np.minimum(after, 1), np.arange(len(after))
    most = (np.array(scenario.limits.v_u1) - stated.d) / np.max(stated.intervals("gain"), axis=1)
    l = rows[0, 1]
    sought, forth = (most * (1, l))[i], side[each, i]
    other = forth * (sought + EDGE * sizes[0])  # what stands is the left wheel
    pair = np.where((i == 0)[:, None], np.c_[forth * sought, other], np.c_[other, forth * sought])
    return np.where((each % 2 == 0)[:, None], pair / (1, l), both)


def _newest(since: Floats) -> Floats:
    """Last instant at which a command took or takes over, for each axis."""
    return np.max(np.where(np.isfinite(since), since, LONG_AGO), axis=1)


def _forward(motion: Floats, base: Base) -> Flags:
    """True where the motion of each loop (or of both, if they are equal) is forwards."""
    return (motion.sum(axis=1, keepdims=True) if base.loops == "alike" else motion) > 0


def _ramped(now: Floats, wanted: Floats, base: Base, time: Floats) -> Floats:
    """Commands that approach ``wanted`` at the ramps' rates; they stop at 0 to reverse."""
    goal = np.where(now * wanted < 0, 0, wanted)
    most = np.where(np.abs(goal) < np.abs(now), base.decel, base.accel) * np.maximum(time, 1e-300)
    return now + np.clip(goal - now, -most, most)


def _recorded(times: list[Floats], values: list[Floats], when: Floats) -> tuple[Floats, Floats]:
    """The first instants from ``when`` on at which a piece ended, and the speeds there."""
    t, v = np.array(times), np.array(values)
    place = np.argmax(t >= when - 1e-12, axis=0)
    columns = np.arange(t.shape[1])
    return t[place, columns], v[place, columns]
