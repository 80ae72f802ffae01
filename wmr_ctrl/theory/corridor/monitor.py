"""Monitor of the latch, one sampled System: whether a robot is in its corridor or left it.

A robot that was within the latch's box at K consecutive samples is in the corridor from then on
(ledger: corridor.latch), so one that leaves it later refutes an assumption of the certificate. Runs
are judged by this graph, and C packages and FMUs are made from it.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import reduce

import casadi as ca
import numpy as np

from wmr_ctrl.control.laws.observer import FORCE_HAT, OLD_VELOCITY, STARTED
from wmr_ctrl.control.setup import Setup
from wmr_ctrl.core.signals import D_HAT, POSE, REFERENCE, TORQUE, VELOCITY, Signal
from wmr_ctrl.theory.checks.error_coordinates import COMMAND, ROBOT, Floats
from wmr_ctrl.theory.checks.sending import loop_of
from wmr_ctrl.world.model.dynamics import wheel_to_force
from wmr_ctrl.world.model.kinematics import tracking_error
from wmr_ctrl.world.model.system import Output, Parameters, Port, System, port, ports, stack

SEEN = (FORCE_HAT, OLD_VELOCITY, STARTED)
"""Memory of a law that a monitor knows of; laws that have more get none."""
IN_CORRIDOR = Signal("in_corridor", "1", "1: the corridor holds the robot, from here on")
LEFT = Signal("corridor_left", "1", "1: it left all the same, so a bound that was stated is false")
MOST = Signal("corridor_most", "m", "distance that is certified at this sample, 0: none yet")
DISTANCE = Signal("corridor_distance", "m", "distance of the measured from the desired position")
OUTPUTS = (IN_CORRIDOR, LEFT, MOST, DISTANCE)


@dataclass(frozen=True)
class Latch:
    """Box ``b`` of deviations of the state at samples, the number ``samples`` K, and the resulting
    bounds.

    ``position`` [m]: largest deviation from its place after K samples in b, after 2 K, and so on;
    the last is valid from then on.  ``level``: the state on the reference; ``push`` [N m] of
    each wheel, ``pose`` [m] and ``velocity`` [m/s, rad/s]: the assumed push and measurement errors.
    """

    box: Floats
    samples: int
    position: tuple[float, ...]
    level: Floats
    push: Floats
    pose: float
    velocity: Floats


def monitor(setup: Setup, latch: Latch, *, measured: bool) -> System:
    """The monitor of a setup whose state is ``seen``, to be stepped at every sample.

    Its inputs are the law's inputs and the torques sent; with an observer, also its estimate.
    ``measured``: pose and velocity are the law's, with errors; else the true ones.
    """
    memory = [item.signal for item in loop_of(setup).core.state]
    desired, pose, v, torque = map(ports, (REFERENCE[:3], POSE, VELOCITY, TORQUE))
    observed = [port(D_HAT)] if FORCE_HAT in memory else []
    p = Parameters(setup.scenario)
    e, v_now = tracking_error(_stack(desired), _stack(pose)), _stack(v)
    force = wheel_to_force(p.take("robot.r"), p.take("robot.l"), _stack(torque))
    count = (len(latch.level) - ROBOT - sum(item.size for item in memory)) // COMMAND
    queue = [port(_signal(f"sent{age}", "N, N.m", "forces sent before", 2)) for age in range(count)]
    now = {
        FORCE_HAT: -observed[0].sym if observed else ca.SX(),
        OLD_VELOCITY: v_now,
        STARTED: ca.SX(1),
    }
    memories = [port(_signal(item.name, item.unit, item.meaning, item.size)) for item in memory]
    streak, age, left = (port(_signal(*row)) for row in (
        ("streak", "1", "samples running within the box"),
        ("age", "1", "samples since the corridor holds, 0: it does not"),
        ("was_left", "1", "1 once the corridor was left"),
    ))  # fmt: skip
    state = ca.vertcat(e, v_now, _stack(queue), _stack(memories))
    numbers = _numbers(setup, latch, measured)
    level, box, samples, most = (port(signal, value) for signal, value in numbers)
    K, distance = samples.sym, ca.sqrt(ca.sumsqr(e[:2]))
    inside = reduce(ca.logic_and, ca.vertsplit(abs(state - level.sym) <= box.sym))
    running = ca.if_else(inside, ca.fmin(streak.sym + 1, K), 0)
    stages = len(latch.position)
    held = age.sym > 0
    certified = most.sym[stages - 1]
    for stage in reversed(range(stages - 1)):
        certified = ca.if_else(age.sym <= (stage + 1) * K, most.sym[stage], certified)
    certified = ca.if_else(held, certified, 0)
    beyond = ca.fmax(left.sym, ca.if_else(ca.logic_and(held, distance > certified), 1, 0))
    older = ca.if_else(held, ca.fmin(age.sym + 1, stages * K), ca.if_else(running >= K, 1, 0))
    update = ca.vertcat(
        *([force, *(item.sym for item in queue[:-1])] if queue else []),
        *(now[item] for item in memory), running, older, beyond,
    )  # fmt: skip
    shown = (ca.if_else(older > 0, 1, 0), beyond, certified, distance)
    return System(
        "corridor",
        "monitor of the certified corridor",
        inputs=(*desired, *pose, *v, *torque, *observed),
        state=(*queue, *memories, streak, age, left),
        params=(*p.ports, level, box, samples, most),
        update=update,
        outputs=tuple(Output(signal, expr) for signal, expr in zip(OUTPUTS, shown, strict=True)),
        period=setup.scenario.clock.control,
    )


def _numbers(setup: Setup, latch: Latch, measured: bool) -> list[tuple[Signal, Floats]]:
    """Parameters of the monitor; measurement errors make its box smaller."""
    n, errors, slack = len(latch.level), latch.velocity, np.zeros(len(latch.level))
    off = latch.pose if measured else 0.0
    if measured:
        slack[:ROBOT] = off, off, 0.0, *errors
    place = n
    for item in reversed(loop_of(setup).core.state):
        place -= item.signal.size
        if item.signal == OLD_VELOCITY and not measured:
            slack[place : place + COMMAND] = errors
    box = np.where(slack > 0, (latch.box - slack) * (1 - 2**-50), latch.box)
    most = np.array(latch.position) + off * (1 + 2**-50)
    return [
        (Signal("corridor.level", "1", "the loop's state on the reference", n), latch.level),
        (Signal("corridor.box", "1", "sizes of its deviations within which it counts", n), box),
        (Signal("corridor.samples", "1", "samples running for which it has to"),
         np.array([float(latch.samples)])),
        (Signal("corridor.position", "m", "distance certified after so many samples, twice, ... "
                "as many", len(most)), most),
    ]  # fmt: skip


def _signal(name: str, unit: str, meaning: str, size: int = 1) -> Signal:
    return Signal(f"corridor_{name}", unit, meaning, size)


def _stack(listed: Iterable[Port]) -> ca.SX:
    return stack(item.sym for item in listed)
