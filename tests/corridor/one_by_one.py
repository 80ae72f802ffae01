"""Responses of the tests' own loops to each small disturbance of a run, and their sums.

One sample and one axis is disturbed at a time.  For small disturbances the worst sequence displaces
the robot by the sum of the absolute responses, in each direction and at each plant step.
"""

from __future__ import annotations

import copy
from dataclasses import dataclass

import numpy as np

from benchmarks.corridor_adversary import Attacked
from tests.corridor.sending import course

TINY = 1e-6
ROUND = np.array([(np.cos(t), np.sin(t), 0.0) for t in np.arange(36) * np.pi / 36])
HEADING = np.array([[0.0, 0.0, 1.0]])
SIDES = np.eye(2)


@dataclass(frozen=True)
class Answers:
    """Responses of a run: errors e at plant steps (N, 3) [0] and commands sent at samples (n, 2)
    [1].

    ``rest``: undisturbed run.  ``by``: for each kind, responses to 1 in a sample along an axis (n,
    2, ...).  ``start``: responses to 1 of each element of the initial e.
    """

    rest: tuple[np.ndarray, np.ndarray]
    by: dict[str, tuple[np.ndarray, np.ndarray]]
    start: list[tuple[np.ndarray, np.ndarray]]

    def sums(self, part, ways, sizes, start):
        """Largest value along any of ``ways`` that e [0] or the command sent [1] can reach, at each
        time.

        ``sizes``: for each kind, one number for a disc, two for its axes.
        """
        most = np.abs(self.rest[part] @ ways.T)
        for kind, answers in self.by.items():
            led, size = answers[part] @ ways.T, sizes[kind]
            if np.ndim(size):
                most += np.tensordot(size, np.abs(led).sum(axis=0), 1)
            else:
                most += size * np.hypot(led[:, 0], led[:, 1]).sum(axis=0)
        for size, answer in zip(start, self.start, strict=True):
            most += size * np.abs(answer[part] @ ways.T)
        return most.max(axis=1)

    def of_samples(self, ways, sizes, start):
        """Largest value of e along ``ways`` in each sample: at its plant steps and at its
        beginning.
        """
        each = self.sums(0, ways, sizes, start).reshape(len(self.rest[1]), -1)
        begun = (np.abs(ways) @ start).max()
        return np.maximum(each.max(axis=1), np.append(begun, each[:-1, -1]))


def of_torques(scenario, law, kinds):
    """Answers of a robot with pushes on its wheels and errors of measured pose and velocity."""
    n = scenario.clock.samples

    def fresh():
        return Attacked(scenario, law, *(np.zeros((n, 2)) for _ in range(3)), changing=True)

    def ended(loop, first=0):
        for k in range(first, n):
            loop._sample(k)
        columns = loop.log.columns()
        return np.array(loop.errors), np.stack([columns["tau_right"], columns["tau_left"]], axis=1)

    def disturbed(k, kind, axis):
        loop = copy.deepcopy(kept[k])
        error = loop.noise if kind == "push" else getattr(loop.sensor, f"{kind}_error")
        error[k, axis] = TINY
        return ended(loop, k)

    def moved(axis):
        loop, (ahead, aside, turn) = fresh(), TINY * np.eye(3)[axis]
        x, y, theta, *v = loop.state
        c, s = np.cos(theta - turn), np.sin(theta - turn)
        loop.state = (x + c * aside + s * ahead, y + s * aside - c * ahead, theta - turn, *v)
        return ended(loop)

    loop, kept = fresh(), []
    for k in range(n):
        kept.append(copy.deepcopy(loop))
        loop._sample(k)
    return _answers(ended(loop, n), disturbed, kinds, moved, n)


def of_base(scenario, law, kinds):
    """Answers of a base that takes velocities and executes commands with errors."""
    n = scenario.clock.samples

    def ended(**told):
        run = course(scenario, law, n, idle=True, **told)
        return run.e, run.sent

    def disturbed(k, kind, axis):
        error = np.zeros((n, 2))
        error[k, axis] = TINY
        return ended(**{kind: error})

    def moved(axis):
        return ended(jump=TINY * np.eye(3)[axis])

    return _answers(ended(), disturbed, kinds, moved, n)


def _answers(rest, disturbed, kinds, moved, n):
    def off(run):
        return [(one - other) / TINY for one, other in zip(run, rest, strict=True)]

    by = {}
    for kind in kinds:
        each = [off(disturbed(k, kind, axis)) for k, axis in np.ndindex(n, 2)]
        by[kind] = tuple(np.array(part).reshape(n, 2, *part[0].shape)
                         for part in zip(*each, strict=True))  # fmt: skip
    return Answers(rest, by, [off(moved(axis)) for axis in range(3)])
