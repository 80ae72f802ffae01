"""Remainders of the linear parts of law and plant step in samples of a passage."""

from __future__ import annotations

import numpy as np

from wmr_ctrl.checks.world import COMMAND, ROBOT, Floats
from wmr_ctrl.corridor.along import Along
from wmr_ctrl.corridor.enclosure import OpenBoxError
from wmr_ctrl.corridor.inputs import Inputs, NoCorridorError
from wmr_ctrl.corridor.instant import Instant, WiderBoxError
from wmr_ctrl.corridor.loop import UP
from wmr_ctrl.corridor.midradius import MidRadius
from wmr_ctrl.corridor.motion import UNSURE, MovingCurve
from wmr_ctrl.corridor.secants import Secants

ROOM, LITTLE, FIRST_ROOM = 1.03, 0.4, 2.0
"""Growth of the box that a bend holds on; below that share of the typical sizes another."""


class Remainders:
    """By bends on a box, which serves as long as no deviation leaves it, or by secants."""

    def __init__(self, along: Along, inputs: Inputs) -> None:
        """Of one loop under bounded inputs."""
        self.along, self.inputs, self.loop = along, inputs, along.loop
        self.nz = len(self.loop.names)
        self.error = np.array([inputs.pose, inputs.pose, 0.0, *inputs.velocity])
        self.misheard = np.zeros(along.outs.shape[1])
        self.misheard[:COMMAND] = inputs.misheard(np.zeros(COMMAND))
        self.commands = np.zeros((self.loop.queue, COMMAND))
        self.latest = [np.zeros(0), np.zeros(0)]
        self.law_bend: tuple[Floats, Floats] | None = None
        self.step_bend: tuple[Floats, Floats] | None = None

    def _products(self, reach: Floats, error: Floats) -> Floats:
        """Largest products (J, 5, 5) of two of the robot's errors as they are measured."""
        along, sizes = self.along, reach[:, :ROBOT]
        pairs = sizes[:, :, None] * sizes[:, None]
        both = reach[:, -2 * len(along.pairs) :].reshape(len(reach), -1, 2).max(axis=2)
        first, second = np.array(along.pairs).T
        least = np.minimum(pairs[:, first, second], both**2 / (4 * along.ratios))
        pairs[:, first, second] = pairs[:, second, first] = least
        mixed = sizes[:, :, None] * error
        return np.asarray(pairs + mixed + mixed.transpose(0, 2, 1) + np.outer(error, error))

    def _left_by(self, secants: Secants, place: int, sizes: Floats, now: Instant) -> Floats:
        """What secants of the law (0) or of the plant step (1) leave; WiderBoxError beyond."""
        most = self.latest[place] = sizes.max(axis=0)
        if (most > secants.wide).any():
            raise WiderBoxError(place, most)
        return np.asarray(secants.left[now.block.at])

    def _law_added(self, reach: Floats, state: Floats, now: Instant) -> Floats:
        """Largest errors of the linear part of the law's outputs, with doubles' rounding."""
        loop, queue = self.loop, self.nz + COMMAND * self.loop.queue
        own, acting = np.split(state[:, queue:], [loop.memory], axis=1)
        robot = state[:, :ROBOT] + self.error
        sizes = np.hstack([robot, own, state[:, self.nz : queue], acting])
        return self._left_of_law(sizes, reach, now) + self.misheard

    def _left_of_law(self, sizes: Floats, reach: Floats, now: Instant) -> Floats:
        if now.here.secants is not None:
            return self._left_by(now.here.secants[0], 0, sizes, now)
        if self.law_bend is None or (sizes > self.law_bend[0]).any():
            ranges = self.along.law_range(now.k, now.end)
            self.law_bend = self._bend(self.loop.law_curve, ranges, sizes.max(axis=0), now.k)
        products = sizes[:, :, None] * sizes[:, None]
        products[:, :ROBOT, :ROBOT] = self._products(reach, self.error)
        left = self.loop.law_curve.remainders(self.law_bend[1], products)
        return (left + self.along.law_off) * UP

    def _step(self, guess: Floats, commands: Floats, now: Instant) -> Floats:
        """Largest errors of a plant step's linear part while the state stays within Z."""
        curve, count = self.loop.step_curve, now.count
        every = np.vstack([self.commands, commands])
        acts = np.max([every[k : k + count] for k in range(len(every) - count + 1)], axis=0)
        known = np.concatenate([self.inputs.push, self.inputs.body])
        sizes = np.hstack([guess[:, : self.nz], acts, np.tile(known, (count, 1))])
        if now.here.secants is not None:
            return self._left_by(now.here.secants[1], 1, sizes, now)
        if self.step_bend is None or (sizes > self.step_bend[0]).any():
            ranges = self.along.step_range(now.k, now.end)
            self.step_bend = self._bend(curve, ranges, sizes.max(axis=0), now.k)
        products = sizes[:, :, None] * sizes[:, None]
        products[:, :ROBOT, :ROBOT] = self._products(guess, np.zeros(ROBOT))
        return (curve.remainders(self.step_bend[1], products) + self.along.step_off) * UP

    def _bend(
        self, curve: MovingCurve, ranges: tuple[MidRadius, MidRadius], sizes: Floats, k: int
    ) -> tuple[Floats, Floats]:
        """A box with room about sizes of deviations, and the bends on it."""
        little = (sizes[:ROBOT] < LITTLE * self.along.typical @ self.inputs.push).all()
        room = FIRST_ROOM if little else ROOM
        grown, (by, numbers) = sizes * room + (sizes > 0) * UNSURE, ranges
        try:
            return grown, curve.bend_within(by, grown, numbers)
        except OpenBoxError as error:
            text = self.along.blamed(sizes, k)
            raise NoCorridorError(text) from error
