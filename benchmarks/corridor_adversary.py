"""Worst pushes and pose errors against the corridor, found on the loop of `tests.oracle`.

The loop's response to one push is measured, not derived.  The worst sequence for a direction and a
time has the signs of that response, read backwards.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from copy import deepcopy
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from tests.oracle.auxiliary import tracking_error
from tests.oracle.loop import Recorder, _Loop
from wmr_ctrl.control.setup import settle
from wmr_ctrl.world.model.evaluate import Floats
from wmr_ctrl.world.references import sample
from wmr_ctrl.world.scenario import Scenario

TINY = 1e-4
WINDOW = 150
"""Samples before the last in which a push still matters."""
STRIDE = 15
"""Samples between the trials of a single push."""
DIRECTIONS = [(math.cos(t), math.sin(t)) for t in np.arange(8) * math.pi / 8]
TRIED = 2
"""Number of worst sequences that are tried, those with the largest sums of responses."""


@dataclass(frozen=True)
class Excursion:
    """Errors e at all plant steps (N, 3), largest wheel torque [N m], and whether the guard changed
    a force.
    """

    e: Floats
    torque: float
    clipped: bool

    @property
    def position(self) -> float:
        """Largest distance from the place on the path [m]."""
        return float(np.hypot(self.e[:, 0], self.e[:, 1]).max())


class Attacked(_Loop):
    """The oracle's loop from a start on the path, with given pushes and measurement errors."""

    def __init__(
        self,
        scenario: Scenario,
        law: str,
        push: Floats,
        pose: Floats | None = None,
        velocity: Floats | None = None,
        changing: bool = False,
    ) -> None:
        setup = settle(scenario, law)
        clock = replace(scenario.clock, duration=len(push) * scenario.clock.control)
        kept = [item for item in scenario.changes if changing and item.t < clock.duration]
        scenario = replace(scenario, clock=clock, changes=tuple(kept))
        super().__init__(scenario, law, vars(setup.gains), vars(setup.kinematics), 0)
        self.noise, start = push, self.reference(0.0)
        self.state = (start.x, start.y, start.theta, start.v1, start.v2)
        if pose is not None:
            self.sensor.pose_error = pose
        if velocity is not None:
            self.sensor.velocity_error = velocity
        self.errors, self.jump, self.at = [], None, 0

    def _plant_step(self, n: int, torque: Floats, noise: Floats) -> None:
        if self.jump is not None and n == self.at:
            x, y, theta, *rest = self.state
            ahead, left, turn = self.jump
            c, s = math.cos(theta), math.sin(theta)
            self.state = (x + c * left + s * ahead, y + s * left - c * ahead, theta + turn, *rest)
        super()._plant_step(n, torque, noise)
        target = self.reference((n + 1) * self.clock.plant)
        self.errors.append(tracking_error(target, self.state[:3]))

    def goes_on(self, first: int, end: int) -> int:
        """Run samples ``first`` to ``end`` - 1, unless the run has ended; return ``end``."""
        for k in range(first, end):
            if not self.ended:
                self._sample(k)
        return end

    def branched(self) -> Attacked:
        """Independent copy of the loop that continues from here with an empty log."""
        self.log, self.errors = Recorder(self._memory()), []
        return deepcopy(self, {id(self.scenario): self.scenario})


def attack(
    scenario: Scenario,
    law: str,
    push: Floats,
    pose: Floats | None = None,
    velocity: Floats | None = None,
    jump: Sequence[float] | None = None,
    at: int = 0,
    changing: bool = False,
) -> Excursion:
    """Excursion under wheel torques ``push`` (N, 2) and errors ``pose``, ``velocity`` (N, 2).

    At sample ``at`` the robot is displaced by ``jump``: ahead, aside [m] and a turn [rad].  With
    ``changing`` the scenario's changes of the robot take place.
    """
    loop = Attacked(scenario, law, push, pose, velocity, changing)
    loop.jump, loop.at = jump, at * scenario.clock.substeps
    loop.run()
    columns = loop.log.columns()
    torque = max(np.abs(columns[name]).max() for name in ("tau_right", "tau_left"))
    return Excursion(np.array(loop.errors), float(torque), bool(np.any(columns["clip_active"])))


def farthest_first(led: Sequence[Floats], size: Floats | float = 1.0) -> list[Floats]:
    """Signs of each sequence in ``led`` (N, 2) times ``size``, worst sequence first.

    The worst sequence has the largest sum of absolute responses over samples and axes.
    """
    order = sorted(led, key=lambda answers: -(np.abs(answers) * size).sum())
    return [np.sign(answers) * size for answers in order]


def led_by(answers: Sequence[Floats], turn: float = 0.0) -> list[Floats]:
    """For each of DIRECTIONS: final displacement that way per unit of input (N, 2) at each sample.

    ``answers``: errors e (N, 3) after a single input of each axis.  The axes are the robot's at
    that sample or, if it turns by ``turn`` [rad] a sample, those of the plane.
    """
    turned, led = turn * np.arange(len(answers[0])), []
    c, s = np.cos(turned), np.sin(turned)
    for ahead, left in DIRECTIONS:
        x, y = (ahead * e[::-1, 0] + left * e[::-1, 1] for e in answers)
        led.append(np.stack([c * x - s * y, s * x + c * y], axis=1))
    return led


@lru_cache(maxsize=16)
def worst_pushes(scenario: Scenario, law: str, samples: int, size: float) -> list[Floats]:
    """For each of DIRECTIONS: pushes (N, 2) of ``size`` that displace the robot most that way.  The
    worst of all comes first.
    """
    steps = scenario.clock.substeps
    rest = attack(scenario, law, np.zeros((samples, 2))).e[steps - 1 :: steps]
    answers = []
    for wheel in (0, 1):
        push = np.zeros((samples, 2))
        push[0, wheel] = TINY
        answers.append(attack(scenario, law, push).e[steps - 1 :: steps] - rest)
    return farthest_first(led_by(answers), size)


@lru_cache(maxsize=64)
def pushed(
    scenario: Scenario, law: str, samples: int, size: float, times: float, place: int
) -> Excursion:
    """Excursion under one of the worst pushes, scaled by ``times``."""
    return attack(scenario, law, times * worst_pushes(scenario, law, samples, size)[place])


def worst_errors(
    scenario: Scenario, law: str, samples: int, kind: str, size: Floats
) -> list[Floats]:
    """For TRIED of DIRECTIONS: errors (N, 2) of ``kind`` "pose" or "velocity" that displace the
    robot most.

    No error exceeds ``size`` (2).  Position errors are along the axes of the plane, in which the
    robot turns.
    """
    steps, first = scenario.clock.substeps, 2  # the law's first sample knows of no velocity before
    push = np.zeros((samples + first, 2))
    exact = {"pose": push, "velocity": push}
    rest = attack(scenario, law, push, **exact).e[(first + 1) * steps - 1 :: steps]
    answers = []
    for axis in (0, 1):
        error = np.zeros_like(push)
        error[first, axis] = TINY
        e = attack(scenario, law, push, **{**exact, kind: error}).e[
            (first + 1) * steps - 1 :: steps
        ]
        answers.append(e - rest)
    rate = sample(scenario, [0.0])[0, 4] if kind == "pose" else 0.0
    return farthest_first(led_by(answers, rate * scenario.clock.control), size)[:TRIED]


def farthest(
    scenario: Scenario, law: str, samples: int, size: float, times: float = 1.0
) -> Excursion:
    """Largest excursion under the worst pushes that are tried, times ``times``."""
    found = (pushed(scenario, law, samples, size, times, place) for place in range(TRIED))
    return max(found, key=lambda x: x.position)
