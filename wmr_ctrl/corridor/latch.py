"""The latch: from when on a run is held by the corridor, wherever it started, and whether it left.

With Y a box that what follows K samples in it does not leave, and b a box of states at samples from
which no sample leaves Y: a run that was within b at K samples running stays in Y from then on, and
after K more samples within what follows them (ledger: corridor.latch).  So a run that leaves proves
that something was not as the scenario says: a push, a mass, a measurement, the plane model.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import casadi as ca
import numpy as np

from wmr_ctrl.checks.loop import loop_of
from wmr_ctrl.checks.world import COMMAND, ROBOT, Floats
from wmr_ctrl.control.setup import Setup, settle
from wmr_ctrl.corridor.answer import CorridorLeft, bounds
from wmr_ctrl.corridor.certificate import Certifier
from wmr_ctrl.corridor.inputs import Inputs, NoCorridorError
from wmr_ctrl.errors import WmrError
from wmr_ctrl.fields.orientation import inward
from wmr_ctrl.laws.observer import FORCE_HAT, OLD_VELOCITY, STARTED
from wmr_ctrl.model.dynamics import wheel_to_force
from wmr_ctrl.model.kinematics import tracking_error
from wmr_ctrl.results import Run
from wmr_ctrl.scenario import Scenario, override
from wmr_ctrl.signals import D_HAT, TORQUE

LARGER = (1.6, 1.4, 1.2, 1.1, 1.05, 1.02)
"""Multiples of the corridor's box that are tried for Y."""
HALVINGS, STAGES = 20, 4
"""Of the search for b; times K samples after which the bound is taken once more."""
DUST = 1e-9
"""Added to all of Y, in units of each: what a run starts with may be off by rounding."""
SEEN = (FORCE_HAT, OLD_VELOCITY, STARTED)
"""Memory of a law that a run's log tells; no latch of a law that has more."""


@dataclass(frozen=True)
class Latch:
    """Box ``b`` of deviations of the state at samples, the ``samples`` K, and what then holds.

    ``position`` [m]: the most that the robot is off its place after K samples in b, after 2 K, and
    so on; the last holds from then on.  ``level``: the state on the reference; ``inputs``: what was
    counted on.
    """

    box: Floats
    samples: int
    position: tuple[float, ...]
    level: Floats
    inputs: Inputs


def latch_of(certifier: Certifier, inputs: Inputs) -> Latch | None:
    """The Latch of a loop whose corridor closes; None where no larger box does.

    Raises NoCorridorError where there is no corridor.
    """
    peaks = certifier.tube(inputs).peaks
    for factor in LARGER:
        held = peaks.times(factor, DUST)
        follows = certifier.settled(inputs, held)
        if follows.within(held) and certifier.share(held) <= 1:
            break
    else:
        return None
    low, high = 0.0, 1.0
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        inside = certifier.next_sample(inputs, middle * held.state, held).within(held)
        low, high = (middle, high) if inside else (low, middle)
    position = [certifier.position(follows)]
    for _ in range(STAGES - 1):
        follows = certifier.settled(inputs, follows)
        position.append(certifier.position(follows))
    return Latch(
        low * held.state, certifier.gains.samples, tuple(position), certifier.loop.at, inputs
    )


def left_by(run: Run, scenario: Scenario) -> CorridorLeft | None:
    """The first leaving of the corridor by a run on ``scenario`` that was settled in it."""
    alone = {"guard.enabled": run.guard, "corridor.start": (0.0, 0.0, 0.0), "corridor.cells": 0}
    try:
        setup = settle(override(scenario, alone), run.law)
        latch = _latch(setup)
    except WmrError:
        return None
    if latch is None or not _seen(setup, latch):
        return None
    end = min((run.settings.index(item.t) for item in scenario.changes), default=run.rows)
    e, within = _within(run, setup, latch, end)
    streak, since = 0, None
    for k, held in enumerate(within):
        if since is None:
            streak = streak + 1 if held else 0
            since = k if streak == latch.samples else None
            continue
        stage = min((k - since - 1) // latch.samples, STAGES - 1)
        if e[k] > latch.position[stage]:
            first, second = map(float, latch.inputs.velocity)
            counted = bounds(float(max(latch.inputs.push)), latch.inputs.pose, (first, second))
            mass = f"{counted} and M = {scenario.robot.m:g} kg"
            times = float(run.time[k]), float(run.time[since])
            return CorridorLeft(times[0], float(e[k]), latch.position[stage], times[1], mass)
    return None


@lru_cache(maxsize=64)
def _latch(setup: Setup) -> Latch | None:
    try:
        certifier = Certifier(setup)
        return latch_of(certifier, certifier.inputs)
    except NoCorridorError:
        return None


def _seen(setup: Setup, latch: Latch) -> bool:
    """True where the log has the whole state: no drives that remember, no memory beside SEEN."""
    memory = [item.signal for item in loop_of(setup).core.state]
    size = sum(item.size for item in memory)
    ideal = (len(latch.level) - ROBOT - size) % COMMAND == 0 and setup.scenario.actuator.ideal
    return ideal and all(item in SEEN for item in memory)


def _within(run: Run, setup: Setup, latch: Latch, end: int) -> tuple[Floats, list[bool]]:
    """Distances [m] from the place on the path, and whether each sample's state is in the box."""
    rows, frames = slice(0, end), run.settings.frames
    poses = [
        np.stack([*(run[name][rows] for name in place), inward(run[angle], frames)[rows]])
        for place, angle in ((("x_d", "y_d"), "theta_d"), (("x", "y"), "theta"))
    ]
    e = np.asarray(_errors()(*poses)).T
    v = np.stack([run["v1"][rows], run["omega"][rows]], axis=1)
    robot, names = setup.scenario.robot, [item.name for item in TORQUE]
    torque = ca.SX.sym("torque", COMMAND)
    force = ca.Function("force", [torque], [wheel_to_force(ca.SX(robot.r), ca.SX(robot.l), torque)])
    sent = np.asarray(force(np.stack([run[name][rows] for name in names]))).T
    memory = {FORCE_HAT: -run[D_HAT.name][rows], OLD_VELOCITY: v, STARTED: np.ones((len(v), 1))}
    ports = loop_of(setup).core.state
    queue = (len(latch.level) - ROBOT - sum(item.signal.size for item in ports)) // COMMAND
    before = [*(_earlier(sent, age) for age in range(1, queue + 1)),
              *(_earlier(memory[item.signal], 1) for item in ports)]  # fmt: skip
    state, slack = np.hstack([e, v, *before]), np.zeros(len(latch.level))
    at = ROBOT + COMMAND * queue
    for item in ports:
        if item.signal == OLD_VELOCITY:
            slack[at : at + COMMAND] = latch.inputs.velocity
        at += item.signal.size
    inside = np.all(np.abs(state - latch.level) + slack <= latch.box, axis=1)
    return np.hypot(e[:, 0], e[:, 1]), [bool(item) for item in inside]


def _earlier(values: Floats, samples: int) -> Floats:
    """Values so many samples ago, NaN before the first."""
    return np.vstack([np.full((samples, values.shape[1]), np.nan), values])[: len(values)]


@lru_cache(maxsize=1)
def _errors() -> ca.Function:
    desired, pose = ca.SX.sym("desired", 3), ca.SX.sym("pose", 3)
    return ca.Function("errors", [desired, pose], [tracking_error(desired, pose)])
