"""Reachable deviations along a run (a flowpipe), block by block (ledger: corridor.passage)."""

from contextlib import suppress
from copy import copy
from dataclasses import replace
from itertools import pairwise
from typing import TypeAlias

import numpy as np

from wmr_ctrl.theory.checks.error_coordinates import COMMAND, Floats

from .along import Along
from .blocks import FollowedBlock, blocks_of
from .carried import CarriedColumns, sizes_of
from .following import TRIES, Following, OtherBoxError
from .inputs import Inputs, NoCorridorError
from .instant import Guess, Instant, RunBounds
from .loop import UP
from .motion import UNSURE

HELD, RAISED, HELD_TRIES, AGAIN_AFTER = 1.002, 1.005, 20, 4
"""Bound on what samples of a standing set add, as a share of the latest; growth where that was too
little, and how often; part of the time without changes after which such a set is sought again."""
SLOW_FROM = 4.0
"""Growth of what is reached that brings the robot to a stop where secants are tried at last."""
LAP_HELD, LAP_GUESSED, LAP_TRIES = 1.0003, 1.0005, 5
"""Growth of the set that a lap begins with, and of what its blocks add; how often it is tried."""
GROWTH = 1.25
"""Most growth of what is reached from one block to the next that is expected."""
ALIKE = 2.0**-46
"""Share of two columns by which the rounding of their difference is less."""
LapBlock: TypeAlias = "tuple[Instant, Guess, tuple[tuple[Floats, Floats] | None, ...]]"
"""A block, what it adds, and the boxes that law's and plant step's bends are for."""
Reached: TypeAlias = "tuple[Floats, Floats]"
"""Bounds of rows by disturbances alone, and in all."""


class Passing(Following):
    """Flowpipe of a loop under bounded inputs; ``run`` computes it."""

    def __init__(self, along: Along, inputs: Inputs, start: Floats, first: int = 0) -> None:
        """Begin with deviations |e| <= ``start`` (3), or at a later sample ``first`` with none."""
        super().__init__(along, inputs, start if first == 0 else np.zeros(3))
        self._result, self._first, self._done = list[Floats](), first, first
        self._again = 0
        self._blocks: list[LapBlock] | None = None
        self._sizes = [np.full((len(along.states), x.shape[1]), np.nan) for x in self.latest]
        self._reach = np.zeros(len(self.rows)), self.row_sizes @ self.pending

    def run(self, until: int | None = None) -> RunBounds:
        """Propagate over all samples, or ``until`` one of them; bounds of all done so far.

        Raises NoCorridorError at the first sample with a broken condition; ``tried`` is the next.
        """
        for first, last in self.along.chunks():
            if until is None:
                self._lapped(max(first, self._done))
            if last <= self._done or (until is not None and first >= until):
                continue
            k, reach = max(first, self._done), self._reach
            if k == first and (held := self._held(first)):
                reach, items = held
                self._result.append(items)
                k = first + len(items)
            if k < last:
                reach = self._chunk(k, last, reach, self._result)
            self._done, self._reach = max(k, last), reach
        position, linear, heading, share, worst = np.vstack(self._result).T
        return RunBounds(position, linear, heading, share, worst.astype(int))

    def _chunk(self, k: int, last: int, reach: Reached, result: list[Floats]) -> Reached:
        """Propagate over samples that share one bound of the second derivatives."""
        if self.along.is_slow(k, last, reach[1]):
            return self._slowly(k, last, reach, result)
        here, before = self.along.matrices(k, last), k
        self.bends = [None, None]
        alone = ready = k
        blocks = list[FollowedBlock]()
        while k < last:
            if not blocks or ready != k:
                count = 1 if k < alone else min(self.along.count_from(k), last - k)
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
            self._followed(now)
            k = ready = k + now.count
        return reach

    def _slowly(self, first: int, last: int, reach: Reached, result: list[Floats]) -> Reached:
        """Propagate by secants over boxes, which grow if a deviation leaves them."""
        k, tries, most = first, 0, self.along.brief
        foreseen, guess = self._foreseen(first, last), None
        while k < last:
            foreseen = [item for item in foreseen if item.k >= k]
            if not tries and foreseen and foreseen[0].k == k and foreseen[0].count <= most:
                now = foreseen[0]
            elif not tries:
                count = min(most, last - k)
                law, step = self._expected(k, count)
                now = self._slow_blocks(k, k + count, count, (law, step))[0]
            try:
                reach, items = self._follow(now, reach, guess, first=tries < 3)
            except OtherBoxError as error:
                law, step = map(self.roomy, self.latest)
                if tries and error.guess:
                    assert now.here.secants is not None
                    held = (item.wide[now.block.at] for item in now.here.secants)
                    law, step = map(np.maximum, (law, step), held)
                now = self._slow_blocks(k, k + now.count, now.count, (law, step))[0]
                tries, guess = tries + 1, error.guess
                if tries > TRIES:
                    raise NoCorridorError(self.along.grown(reach[1], k)) from error
            except NoCorridorError:
                if now.count == 1:
                    raise
                most, tries, guess = now.count // 2, 0, None
            else:
                for seen, sizes in zip(self._sizes, self.latest, strict=True):
                    seen[k : k + now.count] = sizes
                self._followed(now)
                k, tries, guess = k + now.count, 0, None
                most = min(2 * most, self.along.brief)
                result.append(items)
        return reach

    def _followed(self, now: Instant) -> None:
        """Store a block for later laps."""
        if self._blocks is not None:
            self._blocks.append((now, self.last, tuple(self.bends)))

    def _expected(self, k: int, count: int) -> list[Floats]:
        """Secant boxes for some samples, extrapolated from the samples before."""
        before = slice(k - 2 * count, k - count), slice(k - count, k)
        result = []
        for seen, latest in zip(self._sizes, self.latest, strict=True):
            old, new = (seen[max(0, part.start) : part.stop] for part in before)
            if len(old) == count and not np.isnan(old).any() and not np.isnan(new).any():
                growth = np.clip(new / np.maximum(old, 1e-300), 1 / GROWTH, GROWTH)
                result.append(self.roomy(new * growth))
            else:
                result.append(np.tile(latest.max(axis=0), (count, 1)))
        return result

    def _foreseen(self, first: int, last: int) -> list[Instant]:
        """Secant blocks over boxes sized by the deviations a lap earlier, if there was one."""
        lap, count = self.along.laps.lap, self.along.brief
        last -= (last - first) % count
        before = slice(first - lap, last - lap)
        lately = any(first - lap - self.along.memory < k <= first for k in self.along.motion.moved)
        unseen = any(np.isnan(seen[before]).any() for seen in self._sizes)
        if not 0 < lap <= first or lately or unseen:
            return []
        law, step = (self.roomy(seen[before]) for seen in self._sizes)
        return self._slow_blocks(first, last, count, (law, step)) if first < last else []

    def _slow_blocks(
        self, first: int, last: int, count: int, wide: tuple[Floats, Floats]
    ) -> list[Instant]:
        """Secant blocks of ``count`` samples each over boxes ``wide``."""
        here = self.along.secant_stretch(first, last, wide)
        at = np.arange(last - first).reshape(-1, count)
        blocks = blocks_of(here, self.inputs, at, self.which)
        return [Instant(first + int(x.at[0]), first + int(x.at[-1]) + 1, here, x) for x in blocks]

    def _lapped(self, k: int) -> None:
        """Follow a lap from ``k`` on, if it represents others, and with it all later ones."""
        along, lap = self.along, self.along.laps.lap
        since = max(self._first, *(m + 1 for m in (-1, *along.motion.moved) if m < k))
        if k < since + along.memory or not along.laps.are_from(k):
            return
        if along.steady_until(k)[1] >= k + lap:
            return  # a set that stands takes less
        end = int(along.laps.end[k])
        stop = k + ((end - k) % lap or lap)
        ends = {k, stop, k + lap, *(last for _, last in along.chunks())}
        reach, self._blocks = self._reach, []
        for first, last in pairwise(sorted(x for x in ends if k <= x <= k + lap)):
            reach = self._chunk(first, last, reach, self._result)
        self._done, self._reach = k + lap, reach
        blocks, self._blocks = self._blocks, None
        with suppress(NoCorridorError, OtherBoxError):
            items = (later := copy(self))._later_laps(blocks, k, end)
            again = k + np.arange(lap, end - k) % lap
            for seen in self._sizes:
                seen[k + lap : end] = seen[again]
            self._result.append(items)
            vars(self).update(vars(later))

    def _later_laps(self, blocks: list[LapBlock], k: int, end: int) -> Floats:
        """The numbers of RunBounds of all samples until ``end`` after a lap from ``k`` on.

        Lap by lap, it starts from sets slightly larger than the reached ones, until a lap begins
        and ends in one set, which is then valid for all later ones: at the end of a lap deviations
        are counted from its beginning again (ledger: corridor.passage).  NoCorridorError without
        such a set.
        """
        along, lap = self.along, self.along.laps.lap
        stop, left = k + ((end - k) % lap or lap), -(-(end - k) // lap) - 1
        every = list[Floats]()
        jump, heard = along.jump(k + lap, k)
        self._moved_on(-lap, jump, heard)
        held = None
        for _ in range(LAP_TRIES):
            self.carried = held = self.carried.with_more(LAP_HELD, UNSURE, held)
            pending = self.pending = self._rest(self.pending * LAP_HELD + UNSURE)
            sent = self.commands = self.commands * LAP_HELD + UNSURE
            reach, items = self._reached(), list[Floats]()
            for place, (now, answer, bends) in enumerate(blocks):
                self.bends = list(bends)
                reach, item = self._follow(now, reach, answer.grown(LAP_GUESSED), first=False)
                blocks[place] = now, self.last, tuple(self.bends)
                items.append(item)
                if now.k + now.count == stop:
                    stopped = self.carried, self.pending, self.commands
            self._moved_on(-lap, jump, heard)
            off, fits = self._apart(held)
            off = self._rest((self.pending + off) * UP)
            every.append(np.vstack(items))
            fits = fits and bool((off <= pending).all() and (self.commands <= sent).all())
            if fits or len(every) == left:
                self.carried, self.pending, self.commands = stopped
                self._moved_on(end - stop, *along.jump(end, stop))
                self._done, self._reach = end, self._reached()
                every += [every[-1]] * (left - len(every))
                return np.vstack(every)[: end - k - lap]
        raise NoCorridorError("no set is shown that a lap begins and ends in")

    def _moved_on(self, samples: int, jump: Floats, heard: Floats) -> None:
        """Move all deviations by ``samples`` samples, with a ``jump`` of the undisturbed loop."""
        self.carried = self.carried.older(samples).with_more(1.0, 0.0, None)
        newest = self.carried.bent[-1, COMMAND:]
        newest[:] = (newest + jump[self.along.lasting]) * UP
        self.pending = (self.pending + self._rest(jump)) * UP
        self.commands = (self.commands + heard) * UP

    def _held(self, k: int) -> tuple[Reached, Floats] | None:
        """Bound the constant samples from ``k`` on by one invariant set.

        None if there are few, or if no such set is found (ledger: corridor.passage).
        """
        along, count = self.along, self.along.batch
        begin, end = along.steady_until(k)
        begin = max(begin, self._first)
        many = (end - k) // count
        brief = k - begin <= 2 * along.memory or many * count <= along.memory
        if brief or along.young < count or k < self._again:
            return None
        self._again = k + (k - begin) // AGAIN_AFTER
        here, at = along.held(k, end), np.zeros((1, count), dtype=int)
        block = blocks_of(here, self.inputs, at, self.which)[0]
        now = Instant(k, end, here, block, held=True)
        young = self.carried.bent[-(along.young // count) * count :]
        latest = [
            young.reshape(-1, count, young.shape[1]).max(axis=0),
            self.commands.max(axis=0, initial=0.0), self.pending,
        ]  # fmt: skip
        most = [part * HELD + UNSURE for part in latest]
        before = vars(self).copy()
        for _ in range(HELD_TRIES):
            vars(self).update(before)
            standing = self._standing(now, most[0])
            off, fits = self._apart(standing)
            if not fits:
                break
            pending = most[2] = self._rest(np.maximum(most[2], (self.pending + off) * UP))
            sent = np.tile(most[1], (len(self.commands), 1))
            self.carried, self.commands, self.pending = standing, sent, pending
            self.bends, reach = [None, None], self._reached()
            try:
                _, items = self._follow(now, reach)
            except NoCorridorError:
                break
            off, fits = self._apart(standing.older(count))
            latest = [
                self.carried.bent[-count:], self.commands.max(axis=0, initial=0.0),
                self._rest((self.pending + off) * UP),
            ]  # fmt: skip
            pairs = list(zip(latest, most, strict=True))
            if fits and all((one <= other).all() for one, other in pairs):
                self.carried, self.pending = standing.older(many * count), pending
                return reach, np.repeat(items.max(axis=0)[None], many * count, axis=0)
            most = [np.where(one > other, one * RAISED, other) for one, other in pairs]
        vars(self).update(before)
        return None

    def _standing(self, now: Instant, most: Floats) -> CarriedColumns:
        """The generators if every block had been like this one and had added ``most``."""
        new, _ = self._added(now, most[:, :COMMAND], np.zeros((now.count, len(self.pending))))
        new.bent[:] = most
        result = self._none()
        for behind in range(-(-self.along.memory // now.count), -1, -1):
            samples = now.count * (behind + 1)
            before = replace(now, k=now.k - samples)
            result, _ = self._moved(result, before, new.older(-samples))
        return result

    def _apart(self, standing: CarriedColumns) -> tuple[Floats, bool]:
        """Sizes (n) of the generators' differences from shares of standing ones, and if they are
        bounded.

        A difference in a component that persists must fit beside its newest box.
        """
        own = self.carried
        if not np.array_equal(own.born, standing.born):
            return np.zeros(len(self.pending)), False
        apart = np.abs(own.values - standing.values)
        apart += ALIKE * (np.abs(own.values) + np.abs(standing.values))
        off = sizes_of(apart, own.weight) * UP
        newest = (own.bent[-1, COMMAND:] + off[self.along.lasting]) * UP
        fits = (own.weight <= standing.weight).all() and (
            newest <= standing.bent[-1, COMMAND:]
        ).all()
        return off, bool(fits)
