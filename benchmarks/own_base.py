"""Bases that take velocities, written a second time: nothing of wmr_ctrl is imported.

Each axis: a command late by a delay, a ramp, a loop, and a push; small steps of Heun, many bases
side by side, each with commands of its own.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Base:
    """Numbers of a base, of v and omega where there are two.

    ``push``: rms acceleration [m/s2, rad/s2] of a push with the time constant ``push_time`` [s], 0
    for one that is new in each sample.  ``counts`` of encoders, or 0 for speeds with ``noise``.
    """

    loop: str = "first-order"
    gain: tuple[float, float] = (0.95, 1.05)
    tau: tuple[float, float] = (0.25, 0.15)
    wn: tuple[float, float] = (5.0, 8.0)
    zeta: tuple[float, float] = (0.6, 0.9)
    delay: float = 0.035
    accel: tuple[float, float] = (np.inf, np.inf)
    push: tuple[float, float] = (0.3, 0.6)
    push_time: float = 0.0
    counts: int = 0
    noise: tuple[float, float] = (0.003, 0.006)
    period: float = 0.02
    held: float = 0.8
    most: tuple[float, float] = (0.5, 1.0)
    r: float = 0.08
    l: float = 0.2


def _rates(base: Base, v: Floats, f: Floats, u: Floats, push: Floats) -> tuple[Floats, Floats]:
    """Rates of the speed and of the loop's second state."""
    gain, tau, wn, zeta = (np.array(x) for x in (base.gain, base.tau, base.wn, base.zeta))
    if base.loop == "first-order":
        return (gain * u - v) / tau + push, 0 * f
    if base.loop == "pi":
        return 2 * zeta * wn * (u - v) + f + push, wn**2 * (u - v)
    return f, wn**2 * (gain * u - v) - 2 * zeta * wn * f + push * wn


def simulate(base: Base, robots: int, seconds: float, seed: int, step: float = 5e-4) -> list[dict]:
    """Logs as ``identify`` takes them, of random steps; the same seed gives the same bits."""
    rng = np.random.default_rng(seed)
    count, inner = round(seconds / base.period), round(base.period / step)
    spans, rows = round(seconds / base.held) + 1, round(base.held / base.period)
    sent = rng.uniform(-1, 1, (spans, robots, 2)) * np.array(base.most)
    sent = sent.repeat(rows, axis=0)[:count]
    late = round(base.delay / step)
    v, f, ramped, way = (np.zeros((robots, 2)) for _ in range(4))
    push = np.zeros((robots, 2))
    phase = rng.uniform(0, 1, (robots, 2))
    keep = np.exp(-base.period / base.push_time) if base.push_time else 0.0
    most = np.array(base.accel) * step
    seen = np.empty((count, robots, 2))
    none = np.zeros((robots, 2))
    for k in range(count):
        if base.counts:
            turn = np.column_stack((way[:, 0] + base.l * way[:, 1], way[:, 0] - base.l * way[:, 1]))
            seen[k] = np.floor(turn / (2 * np.pi * base.r) * base.counts + phase)
        else:
            seen[k] = v + rng.normal(size=(robots, 2)) * np.array(base.noise)
        push = keep * push + np.sqrt(1 - keep**2) * rng.normal(size=(robots, 2)) * base.push
        for i in range(k * inner, (k + 1) * inner):
            u = sent[(i - late) // inner] if i >= late else none
            ramped = ramped + np.clip(u - ramped, -most, most)
            before = v
            rate = _rates(base, v, f, ramped, push)
            later = _rates(base, v + step * rate[0], f + step * rate[1], ramped, push)
            v = v + step * (rate[0] + later[0]) / 2
            f = f + step * (rate[1] + later[1]) / 2
            way = way + (before + v) / 2 * step
    names = ("wheel_counts[1] [1]", "wheel_counts[2] [1]")
    if not base.counts:
        names = ("v1_measured [m/s]", "omega_measured [rad/s]")
    t = (np.arange(count) * base.period).tolist()
    return [
        {"t [s]": t, "v_command [m/s]": sent[:, k, 0].tolist(),
         "omega_command [rad/s]": sent[:, k, 1].tolist(),
         **{name: seen[:, k, i].tolist() for i, name in enumerate(names)}}
        for k in range(robots)
    ]  # fmt: skip
