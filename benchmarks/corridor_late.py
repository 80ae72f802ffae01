"""Adversary of drives with jitter: it chooses when each command takes over.

A command acts after a wait of some plant steps; until then the previous one acts.  The law is given
the torque that it sent, as in the product.
"""

from __future__ import annotations

import numpy as np

from benchmarks.corridor_adversary import TINY, TRIED, Attacked, Excursion, led_by
from tests.oracle.plant import wheel_torques
from wmr_ctrl.world.model.evaluate import Floats
from wmr_ctrl.world.scenario import Scenario

ROUNDS = 4


class _Waiting:
    """Drives in which the command of sample k waits for ``waits[k]`` plant steps."""

    def __init__(self, waits: Floats, steps: int, before: tuple[float, float]) -> None:
        self.waits, self.steps, self.before, self.now, self.n = waits, steps, before, before, 0

    def advance(self, commanded: tuple[float, float]) -> tuple[float, float]:
        k, phase = divmod(self.n, self.steps)
        if phase == 0:
            self.before, self.now = self.now, commanded
        self.n += 1
        return self.now if phase >= self.waits[k] else self.before


def taken(scenario: Scenario, v: float) -> tuple[float, float]:
    """Wheel torques that balance friction at a velocity."""
    robot = scenario.robot
    friction = robot.mu * robot.m * robot.g * np.tanh(v / robot.v_s)
    return wheel_torques((float(friction), 0.0), robot)


class Jittered(Attacked):
    """The oracle's loop with `_Waiting` drives, whose first command balances friction."""

    def __init__(self, scenario: Scenario, law: str, push: Floats, waits: Floats) -> None:
        super().__init__(scenario, law, push)
        before = taken(scenario, self.state[3])
        self.actuator = _Waiting(waits, scenario.clock.substeps, before)

    def _sample(self, k: int) -> None:
        super()._sample(k)
        self.applied = self.sent[0]


def jittered(scenario: Scenario, law: str, push: Floats, waits: Floats) -> tuple[Excursion, Floats]:
    """Excursion, and the torques that were sent (N, 2)."""
    loop = Jittered(scenario, law, push, waits)
    loop.run()
    columns = loop.log.columns()
    sent = np.stack([columns["tau_right"], columns["tau_left"]], axis=1)
    clipped = bool(np.any(columns["clip_active"]))
    return Excursion(np.array(loop.errors), float(np.abs(sent).max()), clipped), sent


def farthest_held(scenario: Scenario, law: str, samples: int, size: float, wait: int) -> Excursion:
    """Largest excursion under pushes of ``size`` if every command waits ``wait`` plant steps."""
    return _farthest(scenario, law, samples, size, (wait, wait))


def farthest_jittered(
    scenario: Scenario, law: str, samples: int, size: float, most: int, times: float = 1.0
) -> Excursion:
    """Largest excursion under pushes of ``size`` and waits of up to ``most`` plant steps."""
    return _farthest(scenario, law, samples, times * size, (0, most))


def _farthest(
    scenario: Scenario, law: str, samples: int, size: float, ends: tuple[int, int]
) -> Excursion:
    steps, held = scenario.clock.substeps, np.full(samples, sum(ends) // 2)
    blank = np.zeros((samples, 2))
    rest = jittered(scenario, law, blank, held)[0].e[steps - 1 :: steps]
    answers = []
    for wheel in (0, 1):
        push = blank.copy()
        push[0, wheel] = TINY
        answers.append(jittered(scenario, law, push, held)[0].e[steps - 1 :: steps] - rest)
    found = []
    for led in sorted(led_by(answers), key=lambda led: -np.abs(led).sum())[:TRIED]:
        push, waits = size * np.sign(led), held
        for _ in range(ROUNDS):
            course, sent = jittered(scenario, law, push, waits)
            found.append(course)
            back = np.vstack([sent[:1], sent[:-1]]) - sent
            waits = np.where((back * led).sum(axis=1) > 0, ends[1], ends[0])
    return max(found, key=lambda x: x.position)
