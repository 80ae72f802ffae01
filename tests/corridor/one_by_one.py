"""What the tests' own loops do of each little disturbance of a run, one by one, and their sums.

The loop is disturbed by a little in one sample and along one axis at a time.  As long as all that
disturbs is little, its worst sequence leads as far as the sum of the sizes of these answers, in
each direction and at each plant step.
"""

from __future__ import annotations

import copy
from dataclasses import dataclass

import numpy as np

from tests.corridor.adversary import Attacked
from tests.corridor.sending import course

TINY = 1e-6
ROUND = np.array([(np.cos(t), np.sin(t), 0.0) for t in np.arange(36) * np.pi / 36])
HEADING = np.array([[0.0, 0.0, 1.0]])
SIDES = np.eye(2)


@dataclass(frozen=True)
class Answers:
    """Errors e at plant steps (N, 3) [0] and what is sent at samples (n, 2) [1] of a run.

    ``rest``: undisturbed; ``by``: by kind, answers to 1 in a sample along an axis (n, 2, ...);
    ``start``: to 1 of each element of e at first.
    """

    rest: tuple[np.ndarray, np.ndarray]
    by: dict[str, tuple[np.ndarray, np.ndarray]]
    start: list[tuple[np.ndarray, np.ndarray]]

    def sums(self, part, ways, sizes, start):
        """The most that some ``ways`` of e [0] or of what is sent [1] reach, at each time.

        ``sizes``: of each kind, one number for a disc, two for its axes.
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
        """The same of e in each sample: at its plant steps, and at its begin."""
        each = self.sums(0, ways, sizes, start).reshape(len(self.rest[1]), -1)
        begun = (np.abs(ways) @ start).max()
        return np.maximum(each.max(axis=1), np.append(begun, each[:-1, -1]))


def of_torques(scenario, law, kinds):
    """Of a robot whose wheels are pushed, and whose position and velocities are measured amiss."""
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
    """Of a base that takes velocities, whose commands act a little otherwise than they are sent."""
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
