"""Reachable deviations along a run (a flowpipe), block by block (ledger: corridor.passage)."""

from dataclasses import replace
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

HELD = 1.002
"""Assumed bound of what a standing set's samples add, over the latest."""
RAISED = 1.005
"""Growth of that bound where it was too small."""
HELD_TRIES = 20
"""Most such tries."""
AGAIN_AFTER = 4
"""Divisor: such a set is sought again after the time without changes divided by this."""
SLOW_FROM = 4.0
"""Growth of what is reached that brings the robot to a stop where secants are tried at last."""
GROWTH = 1.25
"""Most growth of what is reached from one block to the next that is expected."""
ALIKE = 2.0**-46
"""Share of two columns by which the rounding of their difference is less."""
Reached: TypeAlias = "tuple[Floats, Floats]"
"""Bounds of rows by disturbances alone, and in all."""


class Passing(Following):
    """Flowpipe of a loop under bounded inputs; ``run`` computes it."""

    def __init__(self, along: Along, inputs: Inputs, start: Floats, first: int = 0) -> None:
        """Begin with deviations |e| <= ``start`` (3), or at a later sample ``first`` with none."""
        super().__init__(along, inputs, start if first == 0 else np.zeros(3))
        self._result, self._first, self._done = list[Floats](), first, first
        self._again = 0
        self._sizes = [np.full((len(along.states), x.shape[1]), np.nan) for x in self.latest]
        self._reach = np.zeros(len(self.rows)), self.row_sizes @ self.pending

    def run(self, until: int | None = None) -> RunBounds:
        """Propagate over all samples, or ``until`` one of them; return the bounds of all samples so
        far.

        Raises NoCorridorError at the first sample with a broken condition; ``tried`` is the next.
        """
        for first, last in self.along.chunks():
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
        every, count = np.vstack(self._result), len(self.along.rows)
        position, linear, heading, share, worst = every[:, :5].T
        fast, state, out = np.split(every[:, 5:], [count, count + len(self.pending)], axis=1)
        box = fast, np.vstack([state, self._state(self._reach[1][None])]), out
        return RunBounds(position, linear, heading, share, worst.astype(int), box)

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
            k = ready = k + now.count
        return reach

    def _slowly(self, first: int, last: int, reach: Reached, result: list[Floats]) -> Reached:
        """Propagate by secants over boxes, which grow if a deviation leaves them."""
        k, tries, most = first, 0, self.along.brief
        guess: Guess | None = None
        while k < last:
            if not tries:
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
                k, tries, guess = k + now.count, 0, None
                most = min(2 * most, self.along.brief)
                result.append(items)
        return reach

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

    def _slow_blocks(
        self, first: int, last: int, count: int, wide: tuple[Floats, Floats]
    ) -> list[Instant]:
        """Secant blocks of ``count`` samples each over boxes ``wide``."""
        here = self.along.secant_stretch(first, last, wide)
        at = np.arange(last - first).reshape(-1, count)
        blocks = blocks_of(here, self.inputs, at, self.which)
        return [Instant(first + int(x.at[0]), first + int(x.at[-1]) + 1, here, x) for x in blocks]

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
        """Sizes (n) of the generators' differences from standing ones, and whether those cover the
        rest.

        A difference in a component that persists must fit into its newest box.
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
