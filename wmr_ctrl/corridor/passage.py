"""A passage: sets of deviations carried over a whole run, and checked in each sample.

In a sample that begins with deviations X of the state, the law's remainder follows from X.  That of
the plant steps follows from a box Z of what the fast state reaches within the sample, which is
guessed and then has to hold what comes of it (ledger: corridor.passage).
"""

from __future__ import annotations

from collections import deque

import numpy as np

from wmr_ctrl.checks.world import COMMAND, ROBOT, Floats
from wmr_ctrl.corridor.along import Along
from wmr_ctrl.corridor.carried import CarriedColumns
from wmr_ctrl.corridor.inputs import Inputs, NoCorridorError
from wmr_ctrl.corridor.instant import Instant, Kept, RunBounds, WiderBoxError
from wmr_ctrl.corridor.loop import MOST_COLUMNS, MOST_NUMBERS, UP
from wmr_ctrl.corridor.midradius import rounding
from wmr_ctrl.corridor.motion import UNSURE
from wmr_ctrl.corridor.remainders import Remainders

FAR, NEAR, TRIES = 30.0, 1e-3, 40
"""Growth over the linear loop, and more [m, rad], with which a sample counts as lost; tries."""
HELD, LITTLE_MORE = 1.01, 1e-9
"""Bound on what samples of a standing set add: a share of the latest, and a constant."""
GUESSED, GROWN = 1.01, 1.03
"""Of Z: its first guess, and its growth from try to try."""
DOT = rounding(MOST_NUMBERS)
"""Share by which a sum of products over a state can err."""


SLOW_ROOM, SLOW_SHARE, SLOW_NEAR, SLOW_FROM = 1.05, 0.02, 0.3, 4.0
"""Of boxes of secants: growth, what is added as a share of the typical sizes, their NEAR, and
growth of what is reached that brings the robot to a stop where they are tried at last."""


class Passing(Remainders):
    """One passage of a loop under bounded inputs; ``run`` makes it."""

    def __init__(self, along: Along, inputs: Inputs, start: Floats) -> None:
        """From a start off by |e| <= ``start`` (3)."""
        super().__init__(along, inputs)
        n = along.states.shape[1]
        width = 2 * COMMAND if inputs.velocity.any() else COMMAND
        self.carried = CarriedColumns(
            along.lasting, n, along.memory, (width, COMMAND if inputs.pose else 0)
        )
        if (columns := self.carried.values.shape[1]) > MOST_COLUMNS:
            raise NoCorridorError(f"the loop forgets too slowly: it takes {columns} columns")
        self.pending = np.zeros(n)
        self.pending[:3] = start
        if self.loop.filter:
            self._begin_estimate()
        self.rows = np.hstack([along.rows, np.zeros((len(along.rows), n - self.nz))])
        self.newest = np.zeros(0)
        self.history = deque[Floats](maxlen=along.memory)

    def _begin_estimate(self) -> None:
        """A run's first estimate of the pose is the measured one, not one that is reckoned."""
        loop = self.loop
        first = COMMAND + loop.memory - loop.filter
        place = len(self.pending) - loop.acting - loop.filter
        share = self.along.setup.scenario.sensor.correction
        begun = np.abs(self.along.outs[0, first : first + 3]) / (1 - share) + self.pending[:3]
        way = abs(self.along.motion.v_d[0, 0]) * self.along.setup.scenario.clock.control
        off = np.hypot(*begun[:2]) + way * begun[2] + self.inputs.pose
        self.pending[place : place + 3] = np.array([off, off, begun[2]]) * UP + UNSURE

    def run(self) -> RunBounds:
        """Over all samples; NoCorridorError at the first at which a condition is broken."""
        result = list[tuple[float, ...]]()
        reach = np.zeros(len(self.rows)), np.abs(self.rows) @ self.pending
        for first, last in self.along.chunks():
            if first < len(result):
                first = len(result)
            elif held := self._held(first):
                reach, items = held
                result += items
                first = len(result)
            if first >= last:
                continue
            if self.along.is_slow(first, last, reach[1]):
                reach = self._slowly(first, last, reach, result)
                continue
            here = self.along.stretch(first, last)
            self.law_bend = self.step_bend = None
            for k in range(first, last):
                slow = self.along.is_slow(k, k + 1, SLOW_FROM * reach[1])
                before = self._kept() if slow else None
                try:
                    reach, item = self._sample(Instant(k, k - first, last, here), reach)
                except NoCorridorError:
                    if before is None:
                        raise
                    self._restore(before)
                    reach = self._slowly(k, last, reach, result)
                    break
                result.append(item)
        values = np.array(result)
        position, linear, heading, share, worst = values.T
        return RunBounds(position, linear, heading, share, worst.astype(int))

    def _slowly(
        self, first: int, last: int, reach: tuple[Floats, Floats], result: list[tuple[float, ...]]
    ) -> tuple[Floats, Floats]:
        """Some samples by secants over boxes, which are made wider where they are left."""
        k, wide = (
            first,
            [np.zeros(curve.by.numel()) for curve in (self.loop.law_curve, self.loop.step_curve)],
        )
        tries = 0
        while k < last:
            end = min(k + self.along.brief, last)
            here = self.along.secant_stretch(k, end, (wide[0], wide[1]))
            for j in range(k, end):
                before = self._kept()
                try:
                    reach, item = self._sample(Instant(j, j - k, end, here), reach)
                except WiderBoxError as error:
                    self._restore(before)
                    wide[error.place] = self._roomy(error.sizes)
                    k, tries = j, tries + 1
                    if tries > 4 * TRIES:
                        raise NoCorridorError(self.along.blamed(reach[1], j)) from error
                    break
                result.append(item)
            else:
                k, tries = end, 0
                wide = [self._roomy(sizes) for sizes in self.latest]
        return reach

    def _roomy(self, sizes: Floats) -> Floats:
        """A box of secants for deviations of such sizes."""
        wide = sizes * SLOW_ROOM
        wide[:ROBOT] += SLOW_SHARE * self.along.typical @ self.inputs.push
        return wide

    def _kept(self) -> Kept:
        slots = [kind.slot for kind in self.carried.kinds]
        return self.carried.values.copy(), self.pending, list(self.history), self.commands, slots

    def _restore(self, before: Kept) -> None:
        self.carried.values, self.pending, history, self.commands, slots = before
        self.history = deque(history, maxlen=self.along.memory)
        for kind, slot in zip(self.carried.kinds, slots, strict=True):
            kind.slot = slot

    def _held(self, k: int) -> tuple[tuple[Floats, Floats], list[tuple[float, ...]]] | None:
        """All samples from ``k`` on in which nothing changes, by one set that none of them leaves.

        None where there are few, or where no such set is shown (ledger: corridor.passage).
        """
        carried, memory = self.carried, self.along.memory
        begin, end = self.along.steady_until(k)
        if k - begin <= 2 * memory or end - k <= memory:
            return None
        before = carried.values.copy(), self.pending, list(self.history), self.commands
        slots = [kind.slot for kind in carried.kinds]
        most = np.max(self.history, axis=0) * HELD + LITTLE_MORE
        now = Instant(k, 0, end, self.along.held(k, end), held=True)
        force, box = np.split(most, [COMMAND])
        new = self._columns(now, force)
        new["boxes"] = np.zeros((len(self.pending), len(box)))
        new["boxes"][carried.lasting, range(len(box))] = box
        shares = np.array(self.history)[::-1] / most
        off = carried.stand(
            now.here.A.middle[0], new,
            {"added": shares[:, :COMMAND], "boxes": shares[:, COMMAND:]},
        )  # fmt: skip
        rest = off.copy()
        rest[carried.lasting] = 0
        pending = self.pending = self.pending * HELD + rest + UNSURE
        self.pending[carried.lasting] = 0
        standing, self.law_bend, self.step_bend = carried.values.copy(), None, None
        reach = self._reach()
        try:
            within = bool((self.history[-1][COMMAND:] + off[carried.lasting] <= box).all())
            if within:
                _, item = self._sample(now, reach)
                within = bool((self.newest <= most).all() and (self.pending <= pending).all())
        except NoCorridorError:
            within = False
        for kind, slot in zip(carried.kinds, slots, strict=True):
            kind.slot = slot
        if not within:
            carried.values, self.pending = before[:2]
            self.history, self.commands = deque(before[2], maxlen=memory), before[3]
            return None
        carried.values, self.pending = standing, pending
        self.history = deque([most] * memory, maxlen=memory)
        return reach, [item] * (end - k)

    def _reach(self) -> tuple[Floats, Floats]:
        sizes = np.abs(self.carried.values).sum(axis=1) * UP
        linear, every = self.carried.sums(self.rows, sizes)
        return linear, (every + np.abs(self.rows) @ self.pending) * UP

    def _columns(self, now: Instant, force: Floats) -> dict[str, Floats]:
        """Columns of the state from a sample's inputs and its law's remainder ``force`` (2)."""
        by_law, push, seen = (
            getattr(now.here, name).middle[now.at] for name in ("law", "push", "seen")
        )
        known, inputs = [push * self.inputs.push], self.inputs
        if inputs.velocity.any():
            known.append(by_law @ seen[:, 3:] * inputs.velocity)
        columns = {"known": np.hstack(known), "added": by_law[:, :COMMAND] * force}
        if inputs.pose:
            columns["misled"] = by_law @ seen[:, :2] * inputs.pose
        return columns

    def _sample(
        self, now: Instant, reach: tuple[Floats, Floats]
    ) -> tuple[tuple[Floats, Floats], tuple[float, ...]]:
        """From what rows reach at a sample, by pushes and errors alone and in all, to the next."""
        along, nz = self.along, self.nz
        state, law, added, direct = self._law(now, reach[1])
        share, worst = self._conditions(law, now)
        extra, knots = self._within(now, state, added[:COMMAND] + direct[:COMMAND])
        box, sizes = self._carry(now, state, added, direct), np.zeros(len(state))
        sizes[:nz] = np.abs(self.carried.values[:nz]).sum(axis=1) * UP
        linear, old = self.carried.sums(self.rows, sizes)
        old = old + np.abs(self.rows) @ self.pending
        guess = np.maximum(reach[1], old) * GUESSED + UNSURE
        near = NEAR if now.here.secants is None else SLOW_NEAR
        far = FAR * np.maximum(reach[0], linear)[:ROBOT] + near
        for _ in range(TRIES):
            step = self._step(guess, law, now) + now.here.body[now.at] @ self.inputs.body
            left = now.here.steps[now.at] @ step * UP
            own = box.copy()
            own[:nz] += left
            most = np.maximum(np.maximum(reach[1], old + np.abs(self.rows) @ own), knots)
            most = (most + np.abs(along.rows) @ (extra + left)) * UP
            if (most <= guess).all():
                break
            if (most[:ROBOT] > far).any():
                raise NoCorridorError(along.blamed(guess, now.k))
            guess = np.maximum(guess, most * GROWN)
        else:
            raise NoCorridorError(along.blamed(guess, now.k))
        box = self.pending + own
        self.newest = np.concatenate([added[:COMMAND], box[along.lasting]])
        self.history.append(self.newest)
        self.pending = self.carried.boxed(box)
        ahead = np.maximum(reach[0], linear)
        reached = along.distance(now.part, most), along.distance(now.part, ahead)
        heading = float(most[2] + np.abs(along.fine[now.part, :, 2]).max())
        heading = (heading + float(along.motion.turned[now.part].max())) * UP
        after = old + np.abs(self.rows) @ own
        return (linear, after * UP), (*reached, heading, share, float(worst))

    def _law(self, now: Instant, reach: Floats) -> tuple[Floats, Floats, Floats, Floats]:
        """State, the law's outputs, what it adds to its linear part, and what errors add to it."""
        here, at, nz = now.here, now.at, self.nz
        outputs = here.outputs.middle[at]
        others = np.abs(self.carried.values[nz:]).sum(axis=1) + self.pending[nz:]
        state = np.concatenate([reach[:nz], others]) * UP
        _, result = self.carried.sums(outputs, state)
        result = result + np.abs(outputs) @ self.pending
        wide = (here.outputs.radius[at] + DOT * np.abs(outputs)) @ state
        added, direct = self._law_added(reach, state, now), here.seen.most[at] @ self.error * UP
        law = (result + wide + direct + added) * UP
        self.commands = [law[:COMMAND], *self.commands][: self.loop.queue + 1]
        return state, law, added, direct

    def _carry(self, now: Instant, state: Floats, added: Floats, direct: Floats) -> Floats:
        """All columns a sample on, with its own; returns what it adds beside them, as a box (n)."""
        here, at, inputs, carried = now.here, now.at, self.inputs, self.carried
        A, by_law, push, seen = (
            getattr(here, name).middle[at] for name in ("A", "law", "push", "seen")
        )
        carried.carry(A)
        gone = np.zeros(len(A))
        for name, column in self._columns(now, added[:COMMAND]).items():
            gone += carried.replace(getattr(carried, name), column)
        self.pending = np.abs(A) @ self.pending * UP
        gone += carried.replace(carried.boxes, 0.0)
        box = gone + (here.A.radius[at] + DOT * np.abs(A)) @ state
        box += np.abs(by_law[:, COMMAND:]) @ added[COMMAND:]
        box += (here.law.radius[at] + DOT * np.abs(by_law)) @ (added + direct)
        box += here.law.most[at] @ (here.seen.radius[at] + DOT * np.abs(seen)) @ self.error
        box += (here.push.radius[at] + DOT * np.abs(push)) @ inputs.push
        box[:2] += self.along.motion.gap[now.part].max()
        if self.loop.filter:
            place = len(A) - self.loop.acting - self.loop.filter
            box[place : place + 2] += self.along.motion.reckoned[now.part].max()
        return np.asarray(box * UP)

    def _within(self, now: Instant, state: Floats, commands: Floats) -> tuple[Floats, Floats]:
        """Largest distances from the chords within the sample; reach of the rows at the knots."""
        rows, at, push = self.along.rows, now.at, self.inputs.push
        extra, most = np.zeros(self.nz), np.zeros(len(rows))
        for j, knot in enumerate(now.here.knots):
            by_state, by_push, by_command = (part[at] for part in knot.apart)
            extra = np.maximum(extra, by_state @ state + by_push @ push + by_command @ commands)
            if j:
                here = rows @ knot.state.middle[at]
                _, result = self.carried.sums(here, state)
                result = result + np.abs(here) @ self.pending
                wide = (knot.state.radius[at] + DOT * np.abs(knot.state.middle[at])) @ state
                added = wide + knot.command.most[at] @ commands
                pushed = np.abs(rows @ knot.push.middle[at]) @ push
                wide = added + DOT * knot.push.most[at] @ push + knot.push.radius[at] @ push
                most = np.maximum(most, result + pushed + np.abs(rows) @ wide)
        return extra, most

    def _conditions(self, law: Floats, now: Instant) -> tuple[float, int]:
        """Share of the condition that is used most, and its number."""
        along, count = self.along, self.loop.count
        level = np.abs(along.outs[now.part, -count:]).max(axis=0) + law[-count:]
        shares = np.full(count, np.inf)
        np.divide(level, along.most, out=shares, where=along.most > 0)
        worst = int(shares.argmax())
        if not shares[worst] * UP <= 1:
            raise NoCorridorError(
                f"{self.loop.conditions[worst].name} may reach {level[worst]:.3g} of "
                f"{along.most[worst]:.3g} {along.place(now.k)}"
            )
        return float(shares[worst] * UP), worst
