"""The latch: decides when the corridor is valid for a run, and whether the run leaves it.

Let Y be a box with this property: after K samples in it, the loop never leaves it.  Let b be a box
of states at samples from which no sample leaves Y. A run within b at K consecutive samples stays in
Y from then on, and after K more samples within the next, smaller box (ledger: corridor.latch).  So
a run that leaves proves that something differs from the scenario: a push, a mass, a measurement,
the plane model.
"""

from functools import lru_cache

import numpy as np

from wmr_ctrl.control.setup import Setup, settle
from wmr_ctrl.core.errors import ScenarioError, WmrError
from wmr_ctrl.core.fields.orientation import inward
from wmr_ctrl.core.signals import D_HAT, POSE, REFERENCE, TORQUE, VELOCITY, Signal
from wmr_ctrl.results import Run
from wmr_ctrl.results.verdicts import CorridorLeft
from wmr_ctrl.theory.checks.error_coordinates import COMMAND, ROBOT, Floats
from wmr_ctrl.theory.checks.sending import loop_of
from wmr_ctrl.theory.corridor.answer import bounds
from wmr_ctrl.theory.corridor.monitor import (
    DISTANCE,
    IN_CORRIDOR,
    LEFT,
    MOST,
    SEEN,
    Latch,
    monitor,
)
from wmr_ctrl.world.model.system import System
from wmr_ctrl.world.scenario import Scenario, override
from wmr_proofs.corridor_check.check import latched

from .certificate import Certifier
from .inputs import Inputs, NoCorridorError
from .stated import of_loop, refused_unchecked

LARGER = (1.6, 1.4, 1.2, 1.1, 1.05, 1.02)
"""Multiples of the corridor's box that are tried for Y."""
HALVINGS = 20
"""Halvings in the search for b."""
STAGES = 4
"""Rounds of K samples over which the bound is refined."""
DUST = 1e-9
"""Added to all of Y, in units of each: what a run starts with may be off by rounding."""
ALONE = {"corridor.start": (0.0, 0.0, 0.0), "corridor.cells": 0}
"""Keys that a latch leaves out: the start, and other masses than the scenario's."""


def latch_of(certifier: Certifier, inputs: Inputs) -> Latch | None:
    """The Latch of a loop whose corridor closes; None if no larger box does.

    Raises NoCorridorError if there is no corridor.
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
    box, samples = low * held.state, certifier.gains.samples
    with refused_unchecked():
        shown = latched(of_loop(certifier, inputs, held), box, samples, STAGES)
    position = np.maximum(position, shown).tolist()
    errors = inputs.push, inputs.pose, inputs.velocity
    return Latch(box, samples, tuple(position), certifier.loop.at, *errors)


def seen(certifier: Certifier) -> bool:
    """True if a monitor knows the whole state: drives without memory, laws with SEEN only."""
    setup = certifier.loop.setup
    memory = [item.signal for item in loop_of(setup).core.state]
    size = sum(item.size for item in memory)
    ideal = (len(certifier.loop.at) - ROBOT - size) % COMMAND == 0
    known = ideal and setup.scenario.actuator.ideal and not certifier.inputs.missing
    return known and not setup.takes_velocity and all(item in SEEN for item in memory)


def monitor_of(scenario: Scenario, law: str) -> System:
    """See `wmr_ctrl.theory.corridor.corridor_monitor`."""
    setup = settle(override(scenario, ALONE), law)
    try:
        certifier = Certifier(setup)
        if not seen(certifier):
            raise ScenarioError(
                f"{scenario.name} with {law}: drives with delay or lag, bases that take "
                "velocities, rare or partly corrected poses and laws with a memory of their own "
                "have states that a monitor cannot see. Watch prox or mb with torques, ideal "
                "drives and a pose at every sample that is taken as it is."
            )
        latch = latch_of(certifier, certifier.inputs)
    except NoCorridorError as error:
        raise ScenarioError(
            f"{scenario.name} with {law} has no corridor to be watched: {error}. Change what stops "
            "it (`wmr-ctrl check --only corridor`)."
        ) from error
    if latch is None:
        raise ScenarioError(
            f"{scenario.name} with {law}: no box around the corridor keeps a robot inside, so "
            "nothing could be concluded. State smaller pushes or errors."
        )
    graph = monitor(setup, latch, measured=True)
    box = next(item.value for item in graph.params if item.signal.name == "corridor.box")
    if min(box) < 0:
        raise ScenarioError(
            f"{scenario.name} with {law}: measured poses or velocities are off by more than the "
            "box in which a robot has to be, so that no monitor could tell that it is. State "
            "smaller errors."
        )
    return graph


def left_by(run: Run, scenario: Scenario) -> CorridorLeft | None:
    """First time at which a run on ``scenario`` leaves the corridor in which it had settled."""
    try:
        setup = settle(override(scenario, {"guard.enabled": run.guard, **ALONE}), run.law)
        latch = _latch(setup)
    except WmrError:
        return None
    if latch is None:
        return None
    end = min((run.settings.index(item.t) for item in scenario.changes), default=run.rows)
    verdicts = _watched(run, monitor(setup, latch, measured=False), end)
    gone = np.flatnonzero(verdicts[LEFT])
    if not len(gone):
        return None
    k, since = gone[0], np.flatnonzero(verdicts[IN_CORRIDOR])[0]
    first, second = map(float, latch.velocity)
    limits = bounds(float(latch.push[0]), latch.pose, (first, second))
    mass = f"{limits} and M = {scenario.robot.m:g} kg"
    times, (off, most) = (
        (float(run.time[k]), float(run.time[since])),
        (verdicts[DISTANCE], verdicts[MOST]),
    )
    return CorridorLeft(times[0], float(off[k]), float(most[k]), times[1], mass)


@lru_cache(maxsize=64)
def _latch(setup: Setup) -> Latch | None:
    try:
        certifier = Certifier(setup)
        return latch_of(certifier, certifier.inputs) if seen(certifier) else None
    except NoCorridorError:
        return None


def _watched(run: Run, graph: System, end: int) -> dict[Signal, Floats]:
    """The monitor's outputs at the first samples of a run."""
    columns = {item: run[item.name][:end] for item in (*REFERENCE[:3], *POSE, *VELOCITY, *TORQUE)}
    for item in (REFERENCE[2], POSE[2]):
        columns[item] = inward(columns[item], run.settings.frames)
    columns |= {D_HAT: run[D_HAT.name][:end].T} if D_HAT.name in run.columns else {}
    given = np.vstack([columns[item.signal] for item in graph.inputs])
    step = graph.function("monitor", [graph.update, graph.y])
    x, rows = np.array(graph.x0), []
    for u in given.T:
        x, y = step(u, x, graph.p0)
        rows.append(y.full().ravel())
    return dict(zip((item.signal for item in graph.outputs), np.array(rows).T, strict=True))
