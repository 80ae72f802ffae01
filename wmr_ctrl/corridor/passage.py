"""A passage: sets of deviations carried over a whole run (ledger: corridor.passage)."""

from __future__ import annotations

from dataclasses import replace
from typing import TypeAlias

import numpy as np

from wmr_ctrl.checks.world import COMMAND, ROBOT, Floats
from wmr_ctrl.corridor.blocks import FollowedBlock, blocks_of
from wmr_ctrl.corridor.carried import CarriedColumns, Kind
from wmr_ctrl.corridor.following import TRIES, Following
from wmr_ctrl.corridor.inputs import NoCorridorError
from wmr_ctrl.corridor.instant import Instant, RunBounds, WiderBoxError
from wmr_ctrl.corridor.loop import UP
from wmr_ctrl.corridor.motion import UNSURE
from wmr_ctrl.corridor.stretch import Stretch

HELD, LITTLE_MORE = 1.01, 1e-9
"""Bound on what samples of a standing set add: a share of the latest, and a constant."""
SLOW_ROOM, SLOW_SHARE, SLOW_FROM = 1.05, 0.02, 4.0
"""Of boxes of secants: growth, what is added as a share of the typical sizes, and growth of what is
reached that brings the robot to a stop where they are tried at last."""
ALIKE = 2.0**-46
"""Share of two columns by which the rounding of their difference is less."""
Reached: TypeAlias = "tuple[Floats, Floats]"
"""What rows reach by what disturbs alone, and in all."""


class Passing(Following):
    """One passage of a loop under bounded inputs; ``run`` makes it."""

    def run(self) -> RunBounds:
        """Over all samples; NoCorridorError at the first at which a condition is broken."""
        result, done = list[Floats](), 0
        reach = np.zeros(len(self.rows)), np.abs(self.rows) @ self.pending
        for first, last in self.along.chunks():
            k = max(first, done)
            if k == first and (held := self._held(first)):
                reach, items = held
                result.append(items)
                k = first + len(items)
            if k < last:
                reach = self._chunk(k, last, reach, result)
            done = max(k, last)
        position, linear, heading, share, worst = np.vstack(result).T
        return RunBounds(position, linear, heading, share, worst.astype(int))

    def _chunk(self, k: int, last: int, reach: Reached, result: list[Floats]) -> Reached:
        """Samples whose bends are taken together."""
        if self.along.is_slow(k, last, reach[1]):
            return self._slowly(k, last, reach, result)
        here, before = self.along.matrices(k, last)
        self.law_bend = self.step_bend = None
        alone = ready = k
        blocks = list[FollowedBlock]()
        while k < last:
            if not blocks or ready != k:
                count = 1 if k < alone else min(self.along.together, last - k)
                many = 1 if k < alone else (last - k) // count
                at = k - before + np.arange(many * count).reshape(many, count)
                blocks = blocks_of(here, self.inputs, at, self.which)
                ready = k
            now = Instant(k, last, here, blocks.pop(0))
            try:
                reach, items = self._follow(now, reach)
            except NoCorridorError:
                if now.count > 1:
                    alone, blocks = k + now.count, []
                    continue
                if not self.along.is_slow(k, k + 1, SLOW_FROM * reach[1]):
                    raise
                return self._slowly(k, last, reach, result)
            result.append(items)
            k = ready = k + now.count
        return reach

    def _slowly(self, first: int, last: int, reach: Reached, result: list[Floats]) -> Reached:
        """Some samples by secants over boxes, which are made wider where they are left."""
        curves = self.loop.law_curve, self.loop.step_curve
        wide = [np.zeros(curve.by.numel()) for curve in curves]
        k, tries, alone = first, 0, first
        while k < last:
            end = min(k + 1 if k < alone else k + self.along.brief, last)
            here = self.along.secant_stretch(k, end, (wide[0], wide[1]))
            try:
                reach, items = self._follow(self._instant(k, end, here), reach)
            except WiderBoxError as error:
                wide[error.place], tries = self._roomy(error.sizes), tries + 1
                if tries > 4 * TRIES:
                    raise NoCorridorError(self.along.blamed(reach[1], k)) from error
            except NoCorridorError:
                if end == k + 1:
                    raise
                alone = end
            else:
                k, tries = end, 0
                wide = [self._roomy(sizes) for sizes in self.latest]
                result.append(items)
        return reach

    def _instant(self, k: int, end: int, here: Stretch) -> Instant:
        """A block of all samples of a stretch."""
        at = np.arange(end - k)[None]
        block = blocks_of(here, self.inputs, at, self.which)[0]
        return Instant(k, end, here, block)

    def _roomy(self, sizes: Floats) -> Floats:
        """A box of secants for deviations of such sizes."""
        wide = sizes * SLOW_ROOM
        wide[:ROBOT] += SLOW_SHARE * self.along.typical @ self.inputs.push
        return wide

    def _held(self, k: int) -> tuple[Reached, Floats] | None:
        """Samples from ``k`` on in which nothing changes, by one set that no block leaves.

        None where there are few, or where no such set is shown (ledger: corridor.passage).
        """
        along, count, before = self.along, self.along.together, vars(self).copy()
        begin, end = along.steady_until(k)
        many = (end - k) // count
        if k - begin <= 2 * along.memory or many * count <= along.memory:
            return None
        here, at = along.held(k, end), np.zeros((1, count), dtype=int)
        block = blocks_of(here, self.inputs, at, self.which)[0]
        now = Instant(k, end, here, block, held=True)
        young = self.carried.bent.weight[-(along.young // count) * count :]
        most = young.reshape(-1, count, young.shape[1]).max(axis=0) * HELD + LITTLE_MORE
        standing = self._standing(now, most)
        off = self._beside(standing)
        if off is None:
            return None
        pending = self.pending = self._rest((self.pending + off) * HELD + UNSURE)
        self.carried, self.law_bend, self.step_bend = standing, None, None
        latest = self.commands.max(axis=0, initial=0.0)
        sent = np.tile(latest, (len(self.commands), 1)) * HELD + UNSURE
        self.commands = sent
        reach = self._reach()
        try:
            _, items = self._follow(now, reach)
            off = self._beside(standing.older(count))
        except NoCorridorError:
            off = None
        inside = off is not None and (self._rest(self.pending + off) <= pending).all()
        if not inside or (self.commands > sent).any():
            vars(self).update(before)
            return None
        self.carried, self.pending = standing.older(many * count), pending
        return reach, np.repeat(items.max(axis=0)[None], many * count, axis=0)

    def _standing(self, now: Instant, most: Floats) -> CarriedColumns:
        """The columns, had every block been like this one and had each added the ``most``."""
        new, _ = self._added(now, most[:, :COMMAND], np.zeros((now.count, len(self.pending))))
        new.bent.weight[:] = most
        result = self._none()
        for behind in range(-(-self.along.memory // now.count), -1, -1):
            samples = now.count * (behind + 1)
            before = replace(now, k=now.k - samples)
            result, _ = self._moved(result, before, new.older(-samples))
        return result

    def _beside(self, standing: CarriedColumns) -> Floats | None:
        """Sizes (n) by which the columns are off shares of standing ones; None where not within.

        What is off in a component that lasts has to have room beside its newest box.
        """
        own, off = self.carried, np.zeros(len(self.pending))
        if not np.array_equal(own.born, standing.born):
            return None
        for mine, new in zip(own.kinds, standing.kinds, strict=True):
            if (mine.weight > new.weight).any():
                return None
            apart = np.abs(mine.values - new.values)
            apart += ALIKE * (np.abs(mine.values) + np.abs(new.values))
            off += Kind(apart, mine.weight).sizes()
        off *= UP
        room = standing.bent.weight[-1, COMMAND:]
        newest = (own.bent.weight[-1, COMMAND:] + off[self.along.lasting]) * UP
        return off if (newest <= room).all() else None
