"""Test vectors of a law: short runs of samples with results of CasADi's virtual machine."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from wmr_ctrl.control.filter.channels import ELAPSED, FREE, FREE_AGE, TOLD
from wmr_ctrl.control.sides import LIMITS
from wmr_ctrl.core.data import data
from wmr_ctrl.core.signals import ASKED, ODOMETRY_AGE, REFUSED, TORQUE, VELOCITY, places
from wmr_ctrl.world.encoder import MOVED
from wmr_ctrl.world.model.system import System
from wmr_ctrl.world.scenario.sections import Limits

Floats = NDArray[np.float64]

SAMPLES = 6
"""Samples of a run; the memory begins anew with each run and is carried from sample to sample."""

FAR = 100.0
"""Free distances [m, rad] that limit no command."""
TOLERANCES = {False: 1e-12, True: 2e-4}
"""Largest error of a torque, relative to 1 N m + its size, in double (False) and single precision.
"""


@dataclass(frozen=True)
class Situation:
    """A run's operating point: error e1, e2 [m], e3 [rad]; velocities as shares of their limits."""

    error: list[float]
    desired: list[float]
    measured: list[float]


SITUATIONS = [Situation(**row) for row in data(__package__, "vectors.toml")["situation"]]


@dataclass(frozen=True)
class Vectors:
    """Inputs (steps, inputs) and outputs (steps, outputs); a run starts every SAMPLES steps.

    ``counts`` (steps, 2): the counters whose changes are the last inputs, if there are encoders.
    """

    inputs: Floats
    torques: Floats
    counts: NDArray[np.int64]


def vectors_of(
    system: System, limits: Limits, *, float32: bool = False, half: int = 2**31
) -> Vectors:
    """Runs in all SITUATIONS of a law whose velocities are limited by ``limits``.

    Counters begin just below ``half`` of their range, where they wrap.  In single precision inputs
    and parameters are rounded to it first; the torques are those of double precision.
    """
    machine = system.function("step", [system.update, system.y])
    known = {item.signal for item in system.inputs}
    if ASKED in known:
        exact = _commands(system, limits)
    else:
        draw, v_u1 = np.random.default_rng(2024), np.array(limits.v_u1)
        exact = np.array([row for place in SITUATIONS for row in _run(place, v_u1, draw)])
    if TORQUE[0] in known:
        # Desired and measured pose, velocity, and torques: what a monitor is given in the place.
        told = np.random.default_rng(7).uniform(-1, 1, (len(exact), system.u.numel() - 8))
        exact = np.hstack([exact[:, :3], exact[:, 7:12], told])
    inputs: Floats = np.round(exact, 6)
    p, x = np.array(system.p0), np.array(system.x0)
    counts = np.zeros((len(inputs), 0), int)
    if MOVED in known:
        inputs, counts = _with_counts(inputs, system, half)
    if ASKED not in known:  # nothing is late, nothing refused, and nothing in the way
        at, sides = places(item.signal for item in system.inputs), np.ravel(limits.sides)
        usual = {LIMITS: sides, FREE: np.full(4, FAR)}
        nothing = (ODOMETRY_AGE, ELAPSED, FREE_AGE, REFUSED)
        for signal in (
            s for s in (item.signal for item in system.inputs) if s in (*usual, *nothing)
        ):
            begin = [at[signal.name].start] * signal.size
            inputs = np.insert(inputs, begin, usual.get(signal, np.zeros(1)), axis=1)
    if float32:
        inputs, p = (values.astype(np.float32).astype(np.float64) for values in (inputs, p))
    torques = np.empty((len(inputs), system.y.numel()))
    for k, u in enumerate(inputs):
        following, torque = machine(u, x if k % SAMPLES else np.array(system.x0), p)
        x, torques[k] = following.full().ravel(), torque.full().ravel()
    return Vectors(inputs, torques, counts)


def _run(place: Situation, v_u1: Floats, draw: np.random.Generator) -> list[Floats]:
    """Rows of one run: errors shrink by 1 % a sample, velocities drift by up to 0.1 %."""
    x_d, y_d, theta_d = draw.uniform(-3, 3, 3)
    rates, drift, rows = draw.uniform(-0.1, 0.1, 2), draw.uniform(-1e-3, 1e-3, 2), []
    for k in range(SAMPLES):
        e1, e2, e3 = np.array(place.error) * 0.99**k
        s, c = np.sin(theta_d - e3), np.cos(theta_d - e3)
        pose = [x_d + s * e1 + c * e2, y_d - c * e1 + s * e2, theta_d - e3]
        desired, measured = (v_u1 * np.array(pair) for pair in (place.desired, place.measured))
        rows.append(
            np.array([x_d, y_d, theta_d, *desired, *rates, *pose, *(measured * (1 + k * drift))])
        )
    return rows


def _commands(system: System, limits: Limits) -> Floats:
    """Commands up to five times the limits; if used, odometry within them, half of the time.

    Received limits and free distances are mostly smaller than the scenario's.
    """
    draw, rows, known = np.random.default_rng(2024), [], [item.signal for item in system.inputs]
    own = sum(item.size for item in known if item not in TOLD)
    for k in range(len(SITUATIONS) * SAMPLES):
        asked, measured = (size * draw.uniform(-1, 1, 2) * limits.v_u1 for size in (5, 0.02))
        age = 0.0 if k % 2 else -1.0
        row = [*asked, *measured, age, 0.0][:own]
        if LIMITS in known:
            row += (draw.uniform(0, 1, (2, 1)) * limits.sides).ravel().tolist()
        if FREE in known:
            row += [*draw.uniform(0, 1, 4), 0.0]
        rows.append(np.array(row))
    return np.array(rows)


def _with_counts(inputs: Floats, system: System, half: int) -> tuple[Floats, NDArray[np.int64]]:
    """The inputs with changes of counts at the end, in place of the speeds; and the counts."""
    numbers = {item.signal.name: item.value[0] for item in system.params}
    names = [name for item in system.inputs for name in item.signal.elements]
    turn = numbers["robot.l"] * inputs[:, -1:] * (1.0, -1.0)
    share = numbers["encoder.counts"] / (2 * np.pi * numbers["robot.r"])
    moved = (inputs[:, -2:-1] + turn) * numbers["clock.control"] * share
    runs = [np.floor(np.cumsum(run, axis=0)) for run in np.split(moved, len(SITUATIONS))]
    steps = np.vstack([np.diff(run, axis=0, prepend=run[:1]) for run in runs])
    counts = np.vstack([run - run[0] for run in runs]).astype(np.int64) + half - 1
    gyro = inputs[:, -1:] if VELOCITY[1].name in names else inputs[:, :0]
    return np.hstack([inputs[:, :-2], gyro, steps]), (counts + half) % (2 * half) - half
