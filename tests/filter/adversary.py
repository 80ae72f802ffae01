"""A base with a first-order speed loop, driven by an adversary; it shares no code with the filter.

Many trials at once, each a row: exact exponentials between the instants at which commands take
over, and in each piece the gain, time constant, push, error of odometry that are worst for the side
of the limit that the trial is after.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import casadi as ca
import numpy as np

from wmr_ctrl.filter import filter_system
from wmr_ctrl.scenario import Scenario


@dataclass(frozen=True)
class Base:
    """True numbers of the base and its wires: intervals, within which the adversary chooses."""

    tau: tuple[float, float] = (0.2, 0.3)
    gain: tuple[float, float] = (0.9, 1.1)
    d: float = 0.05
    error: float = 0.02
    delay: tuple[float, float] = (0.0, 0.0)
    losses: int = 0
    jitter: float = 0.0
    age: float = 0.0
    heard: bool = True
    second_lag: float = 0.0

    def wrong(self, **changes: object) -> Base:
        """The base with some numbers beyond what is stated."""
        return replace(self, **changes)


Sender = Callable[[np.ndarray], np.ndarray]
"""Sends for inputs (inputs, trials) the commands (2, trials), with a memory of its own."""


def graphs(scenario: Scenario, trials: int) -> Sender:
    """The filter's graph for so many bases."""
    system = filter_system(scenario)
    step = system.function("filter", [system.update, system.y]).map(trials)
    x, p = (ca.repmat(ca.DM(item), 1, trials) for item in (system.x0, system.p0))

    def send(u: np.ndarray) -> np.ndarray:
        nonlocal x
        x, out = step(ca.DM(u), x, p)
        x = ca.DM(x)
        return np.asarray(out)[:2]

    return send


def fastest(
    scenario: Scenario,
    base: Base,
    trials: int = 400,
    samples: int = 200,
    seed: int = 0,
    sending: Callable[[Scenario, int], Sender] = graphs,
) -> np.ndarray:
    """Largest |v|/V of each trial on the first axis, over all instants at which a piece ends."""
    rng = np.random.default_rng(seed)
    send, T = sending(scenario, trials), scenario.clock.control
    governs, V = scenario.filter.kind == "governor", scenario.limits.v_u1[0]
    keep = int(np.ceil((base.delay[1] + base.age) / (T - base.jitter))) + base.losses + 3
    sent, since = np.zeros((trials, keep)), np.full((trials, keep), -np.inf)
    v, inner, now, way = np.zeros(trials), np.zeros(trials), np.zeros(trials), np.ones(trials)
    past_v, past_t = [v.copy()], [now.copy()]
    lost, worst, dt = np.zeros(trials, int), np.zeros(trials), np.zeros(trials)
    style = rng.integers(0, 3, trials)  # presses on, swings, acts at random
    for _ in range(samples):
        way = np.where((style > 0) & (rng.random(trials) < 0.05), -way, way)
        loud = np.where(style == 2, rng.uniform(-2, 2, trials), 10 * way)
        old, seen = _recorded(past_t, past_v, now - rng.choice([0.0, base.age], trials))
        y = seen - base.error * np.where(style == 2, rng.uniform(-1, 1, trials), way)
        there = np.full(trials, base.heard) & ((style < 2) | (rng.random(trials) < 0.5))
        u = np.zeros((6 if governs else 3, trials))
        u[0], u[-1] = loud, dt
        if governs:
            u[2], u[4] = y, np.where(there, now - old, -1.0)
        command = send(u)[0]
        drop = (rng.random(trials) < 0.5) & (lost < base.losses)
        lost = np.where(drop, lost + 1, 0)
        takes = now + rng.choice([*base.delay, rng.uniform(*base.delay)], trials)
        newest = np.max(np.where(np.isfinite(since), since, -np.inf), axis=1)
        takes = np.where(drop, np.inf, np.maximum(takes, newest))
        sent, since = np.c_[sent[:, 1:], command], np.c_[since[:, 1:], takes]
        dt = T + base.jitter * rng.choice([-1.0, 0.0, 1.0], trials)
        end = now + dt
        cuts = np.sort(np.clip(np.c_[now, since, end], now[:, None], end[:, None]), axis=1)
        for a, b in zip(cuts.T[:-1], cuts.T[1:], strict=True):
            place = np.argmax(np.where(since <= a[:, None], np.arange(keep), -1), axis=1)
            acting = sent[np.arange(trials), place]
            share = np.where(style == 2, rng.random(trials), 1.0)
            push = way * base.d * share
            gain = np.where(acting * way > 0, base.gain[1], base.gain[0])
            aim = gain * acting + push
            if base.second_lag:
                passed = np.exp(-(b - a) / base.second_lag)
                inner = aim + (inner - aim) * passed
                aim = inner
            tau = np.where((aim - v) * way > 0, base.tau[0], base.tau[1])
            v = aim + (v - aim) * np.exp(-(b - a) / tau)
            worst = np.maximum(worst, np.abs(v) / V)
            past_v.append(v.copy())
            past_t.append(b.copy())
        now = end
        past_v, past_t = past_v[-8 * keep :], past_t[-8 * keep :]
    return worst


def _recorded(
    times: list[np.ndarray], values: list[np.ndarray], when: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """The first instants from ``when`` on at which a piece ended, and the speeds there."""
    t, v = np.array(times), np.array(values)
    place = np.argmax(t >= when - 1e-12, axis=0)
    columns = np.arange(t.shape[1])
    return t[place, columns], v[place, columns]
