"""A wheeled robot written a second time, with effects that no model of `identify` contains.

Nothing of wmr_ctrl is imported: Newton's law for body and wheels, integrated by small steps of
Heun, for many robots side by side.  Sources: Coulomb friction with a sharper start at rest
(stiction), play between motor and wheel, tyres whose tread creeps in proportion to the force.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


COLUMNS = (
    *("wheel_counts[1]", "wheel_counts[2]", "tau_right", "tau_left"),
    *("x", "y", "theta", "v1", "omega"),
)


@dataclass(frozen=True)
class Truth:
    """Numbers of the robot, SI units; friction forces at the body, ``c`` at each wheel."""

    m: float = 30.0
    I: float = 1.6
    Fc: float = 12.0
    Fv: float = 6.0
    c: float = 3.0
    Mv: float = 0.3
    delay: float = 0.035
    lag: float = 0.05
    r: float = 0.08
    l: float = 0.2
    v_s: float = 0.01
    counts: int = 2048
    period: float = 0.02
    noise: float = 0.15
    gust: tuple[float, float, float] = (0.0, 0.0, 0.5)
    backlash: float = 0.0
    stiction: float = 0.0
    creep: float = np.inf
    radius: float = 0.0
    tau_max: float = 6.0


@dataclass
class Drives:
    """Commands of a drive in closed loop: a reference of both speeds and gains of a PI law.

    ``kind``: "steps" (random levels), "circle", "sines", or "given": ``wanted`` (samples, 2) for
    every robot, at rest after it.
    """

    kind: str = "steps"
    most: tuple[float, float] = (0.5, 1.2)
    gains: tuple[float, float] = (60.0, 30.0)
    turning: tuple[float, float] = (3.0, 1.5)
    wanted: Floats | None = None


def references(drive: Drives, robots: int, t: Floats, rng: np.random.Generator) -> Floats:
    """Desired speeds (samples, robots, 2)."""
    v, w = drive.most
    if drive.kind == "given" and drive.wanted is not None:
        speeds = np.zeros((len(t), 2))
        speeds[: len(drive.wanted)] = drive.wanted[: len(t)]
        return np.repeat(speeds[:, None, :], robots, axis=1)
    if drive.kind == "circle":
        return np.broadcast_to(np.array([0.6 * v, 0.4 * w]), (len(t), robots, 2)).copy()
    if drive.kind == "sines":
        tones = np.array([0.1, 0.25, 0.45, 0.7, 1.1, 1.6, 2.1])
        phase = rng.uniform(0, 2 * np.pi, (robots, 2, len(tones)))
        waves = np.sin(2 * np.pi * tones * t[:, None, None, None] + phase) / np.sqrt(len(tones))
        return waves.sum(axis=-1) * np.array([0.7 * v, 0.7 * w])
    spans = 1 + int(t[-1] / 1.0)
    levels = rng.uniform(-1, 1, (spans + 1, robots, 2)) * np.array([v, w])
    levels[:, :, 0] = np.abs(levels[:, :, 0]) * np.where(
        rng.random((spans + 1, robots)) < 0.8, 1, -1
    )
    return levels[np.minimum((t / 1.0).astype(int), spans)]


def simulate(
    truth: Truth,
    robots: int,
    seconds: float,
    seed: int,
    drive: Drives | None = None,
    step: float = 5e-4,
) -> dict[str, Floats]:
    """Columns (samples, robots) of closed-loop drives; the same seed gives the same bits.

    t (samples,), wheel_counts[1], [2] whole counts, tau_right, tau_left as commanded, x, y, theta,
    v1, omega true.
    """
    drive = drive or Drives()
    rng = np.random.default_rng(seed)
    T, inner = truth.period, round(truth.period / step)
    t = np.arange(round(seconds / T)) * T
    wanted = references(drive, robots, t, rng)
    r, l = truth.r, truth.l
    radius = r * (1 + truth.radius * np.array([1.0, -1.0]))
    queue = round(truth.delay / step)
    sent = np.zeros((queue + 1, robots, 2))
    state = {name: np.zeros(robots) for name in ("x", "y", "theta", "v", "w")}
    torque, turn = np.zeros((robots, 2)), np.zeros((robots, 2))
    gust, sums, slack = np.zeros((robots, 2)), np.zeros((robots, 2)), np.zeros((robots, 2))
    phase = rng.uniform(0, 1, (robots, 2))
    out = {name: np.empty((len(t), robots)) for name in COLUMNS}
    last = None
    decay = np.exp(-step / truth.lag) if truth.lag > 0 else 0.0
    place = 0
    for k in range(len(t)):
        counts = np.floor(turn * truth.counts / (2 * np.pi) + phase)
        speed = (
            np.zeros((robots, 2))
            if last is None
            else (counts - last) * (2 * np.pi * r / truth.counts / T)
        )
        last = counts
        v_seen, w_seen = speed.sum(axis=1) / 2, (speed[:, 0] - speed[:, 1]) / (2 * l)
        error = wanted[k] - np.column_stack((v_seen, w_seen))
        sums = np.clip(sums + error * T, -1, 1)
        ahead = drive.gains[0] * error[:, 0] + drive.gains[1] * sums[:, 0]
        around = drive.turning[0] * error[:, 1] + drive.turning[1] * sums[:, 1]
        tau = 0.5 * r * np.column_stack((ahead + around / l, ahead - around / l))
        tau = np.clip(tau, -truth.tau_max, truth.tau_max)
        values = (
            counts[:, 0],
            counts[:, 1],
            tau[:, 0],
            tau[:, 1],
            *(state[n] for n in ("x", "y", "theta", "v", "w")),
        )
        for name, value in zip(out, values, strict=True):
            out[name][k] = value
        push = rng.normal(size=(robots, 2)) * truth.noise
        size, moment, time = truth.gust
        fade = np.exp(-T / time)
        gust = fade * gust + np.sqrt(1 - fade**2) * rng.normal(size=(robots, 2)) * np.array(
            [size, moment]
        )
        for _ in range(inner):
            sent[place] = tau
            place = (place + 1) % (queue + 1)
            arriving = sent[place] if queue else tau
            before = torque
            torque = arriving + (torque - arriving) * decay
            acting = (before + torque) / 2 + push
            if truth.backlash > 0:
                # The motor runs through the play almost unloaded before it drives the other flank.
                slack = np.clip(
                    slack + np.sign(acting) * 2.0 * step, -truth.backlash / 2, truth.backlash / 2
                )
                acting = np.where(np.abs(slack) >= truth.backlash / 2 - 1e-12, acting, 0.1 * acting)
            force = acting / radius

            v, w = state["v"], state["w"]
            a = _rates(truth, v, w, force, gust)
            b = _rates(truth, v + step * a[0], w + step * a[1], force, gust)
            v_new, w_new = v + step * (a[0] + b[0]) / 2, w + step * (a[1] + b[1]) / 2
            v_mid, w_mid = (v + v_new) / 2, (w + w_new) / 2
            heading = state["theta"] + step * w_mid / 2
            state["x"] = state["x"] - step * v_mid * np.sin(heading)
            state["y"] = state["y"] + step * v_mid * np.cos(heading)
            state["theta"] = state["theta"] + step * w_mid
            state["v"], state["w"] = v_new, w_new
            rolled = _rims(v_mid, l * w_mid)
            if np.isfinite(truth.creep):
                rolled = rolled + force / truth.creep
            turn = turn + step * rolled / radius
    return {"t": t, **out}


def _rates(
    truth: Truth, v: Floats, w: Floats, force: Floats, gust: Floats
) -> tuple[Floats, Floats]:
    """Accelerations (robots,) under the wheels' forces (robots, 2) [N]."""
    rims, body = _rims(v, truth.l * w), truth.Fc
    wheel = truth.c * np.tanh(rims / truth.v_s)
    if truth.stiction:
        wheel = wheel * (1 + truth.stiction * np.exp(-((rims / 0.05) ** 2)))
        body = body * (1 + truth.stiction * np.exp(-((np.abs(v) / 0.05) ** 2)))
    right, left = (force - wheel).T
    dv = (right + left - body * np.tanh(v / truth.v_s) - truth.Fv * v + gust[:, 0]) / truth.m
    dw = (truth.l * (right - left) - truth.Mv * w + gust[:, 1]) / truth.I
    return dv, dw


def _rims(v: Floats, turning: Floats) -> Floats:
    """Velocities of the right and the left wheel (robots, 2) [m/s]."""
    both = np.empty((len(v), 2))
    both[:, 0], both[:, 1] = v + turning, v - turning
    return both


def log_of(
    columns: Mapping[str, Floats], robot: int, names: tuple[str, ...] = ()
) -> dict[str, list[float]]:
    """One robot's log as ``identify`` takes it."""
    units = {"t": "s", "tau_right": "N.m", "tau_left": "N.m", "x": "m", "y": "m", "theta": "rad",
             "v1": "m/s", "omega": "rad/s"}  # fmt: skip
    wanted = names or ("t", "wheel_counts[1]", "wheel_counts[2]", "tau_right", "tau_left")
    return {
        f"{name} [{units.get(name, '1')}]": (
            columns[name] if name == "t" else columns[name][:, robot]
        ).tolist()
        for name in wanted
    }
