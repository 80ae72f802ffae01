"""Propagation of a flowpipe over one block of samples, by a guess that is then verified.

The remainders of the law in a sample follow from the deviations X at its beginning.  The remainders
of its plant steps follow from a box Z that contains the fast state within the sample.  All
remainders of a block are guessed; the guess is valid if it contains the remainders that it implies
(ledger: corridor.passage).
"""

from dataclasses import dataclass

import numpy as np

from wmr_ctrl.theory.checks.budget import spend
from wmr_ctrl.theory.checks.error_coordinates import COMMAND, ROBOT, Floats

from .along import Along
from .blocks import DOT, each
from .carried import CarriedColumns
from .inputs import Inputs, NoCorridorError
from .instant import Guess, Instant, OtherBoxError
from .loop import MOST_COLUMNS, UP
from .midradius import MidRadius
from .motion import UNSURE
from .remainders import Remainders

FAR = 30.0
"""Growth over the linear loop beyond which a sample counts as lost."""
NEAR = 1e-3
"""Deviation that is allowed beside it [m, rad]."""
SLOW_NEAR = 0.3
"""The same deviation near standstill, where secants are used [m, rad]."""
TRIES = 40
"""Most tries for a block."""
COST = 10.0
"""Work of a block (`wmr_ctrl.theory.checks.budget`)."""
COLUMNS = 1000.0
"""Number of columns that cost one such block more."""
GUESSED = 1.003
"""Growth of the first guess."""
GROWN = 1.02
"""Growth of a guess from try to try."""
SURE = 1.01
"""Growth of a command's deviation with which it still has to exceed the dead band."""


@dataclass(frozen=True)
class _Until:
    """Part of a block's bounds that does not depend on the guess.

    ``linear``, ``after`` (J, rows): bounds of the rows at samples' ends, by disturbances alone and
    by all contributions; ``inner``: those of inner rows.  ``through`` (n): sizes of all generators
    propagated by the last matrix.  ``box`` (J, n): additional box.
    """

    linear: Floats
    after: Floats
    inner: Floats
    through: Floats
    box: Floats


class Following(Remainders):
    """A set of deviations (generators and boxes), and its propagation over a block."""

    def __init__(self, along: Along, inputs: Inputs, start: Floats) -> None:
        """Begin with initial deviations |e| <= ``start`` (3)."""
        super().__init__(along, inputs)
        n = along.states.shape[1]
        each = 2 * COMMAND + len(along.lasting)
        each += COMMAND * (bool(inputs.velocity.any()) + bool(inputs.pose))
        if (columns := each * along.memory) > MOST_COLUMNS:
            raise NoCorridorError(f"the loop forgets too slowly: it takes {columns} columns")
        self.carried = self._none()
        self.pending = np.zeros(n)
        self.pending[:3] = start
        if self.loop.filter:
            self._begin_estimate()
        self.begun = self.pending.copy()
        rows = np.hstack([along.rows, np.zeros((len(along.rows), n - self.nz))])
        self.rows = np.vstack([rows, np.eye(n)[self.nz :]])
        self.row_sizes, self.fast_sizes = np.abs(self.rows), np.abs(along.rows)
        outs = along.outs.shape[1]
        self.read = np.array([*range(COMMAND), *range(outs - self.loop.count, outs)])
        self.which = self.rows, along.rows, self.read
        self.tried = 0
        nothing = (np.zeros((1, size)) for size in (COMMAND, n, self.nz))
        self.last = self.before = Guess(*nothing)

    def _begin_estimate(self) -> None:
        """Set the initial error of the pose estimate, which starts as the measured pose."""
        loop = self.loop
        first = COMMAND + loop.memory - loop.filter
        place = len(self.pending) - loop.acting - loop.filter
        share = self.along.setup.scenario.sensor.correction
        begun = np.abs(self.along.outs[0, first : first + 3]) / (1 - share) + self.pending[:3]
        way = abs(self.along.motion.v_d[0, 0]) * self.along.setup.scenario.clock.control
        off = np.hypot(*begun[:2]) + way * begun[2] + self.inputs.pose
        self.pending[place : place + 3] = np.array([off, off, begun[2]]) * UP + UNSURE

    def _none(self) -> CarriedColumns:
        """Empty set of columns."""
        known = COMMAND * (2 if self.inputs.velocity.any() else 1)
        ends = known, known + COMMAND + len(self.along.lasting)
        m, n = ends[1] + COMMAND * bool(self.inputs.pose), self.along.states.shape[1]
        return CarriedColumns(np.zeros(0, dtype=int), np.zeros((n, m, 0)), np.zeros((m, 0)), ends)

    def _reached(self) -> tuple[Floats, Floats]:
        """Bounds of the rows, by disturbances alone and by all contributions."""
        linear, every = self.carried.sums(self.rows, self.carried.sizes)
        return linear, (every + self.row_sizes @ self.pending) * UP

    def _state(self, reach: Floats) -> Floats:
        """Sizes of the state's numbers (J, n) from those of the rows."""
        return np.hstack([reach[:, : self.nz], reach[:, len(self.along.rows) :]])

    def _until(self, now: Instant) -> _Until:
        """Compute the part that does not depend on the guess."""
        block, motion, count = now.block, self.along.motion, len(self.rows)
        sizes = self.carried.sizes
        through = np.abs(block.chain) @ (sizes + self.pending)
        linear, every = self.carried.sums(block.ahead, sizes)
        size = [through[1:] @ self.row_sizes.T, each(np.abs(block.inner), through[:-1])]
        own = block.own + DOT * np.hstack(size)
        every = (every + own + np.abs(block.ahead) @ self.pending) * UP
        box = block.box + DOT * each(np.abs(now.here.A.middle[block.at]), through[:-1])
        box[:, :2] += now.most(motion.gap)[:, None]
        if self.loop.filter:
            place = box.shape[1] - self.loop.acting - self.loop.filter
            box[:, place : place + 2] += now.most(motion.reckoned)[:, None]
        after, inner = every[:, :count], every[:, count:]
        return _Until((linear + own)[:, :count] * UP, after, inner, through[-1], box)

    def _follow(
        self,
        now: Instant,
        reach: tuple[Floats, Floats],
        guess: Guess | None = None,
        *,
        first: bool = True,
    ) -> tuple[tuple[Floats, Floats], Floats]:
        """Propagate the bounds of the rows, by disturbances alone and by all contributions, to a
        block's end.

        Also returns the numbers of RunBounds of each sample (J, any).  Raises OtherBoxError if
        deviations leave the secant boxes, or these are too wide on a ``first`` try.
        """
        self.tried = now.k + now.count
        spend(0, COST + self.carried.weight.size / COLUMNS)
        along, until, count = self.along, self._until(now), now.count
        guess = guess or self.last.going_on(self.before, count)
        before = np.vstack([reach[0], until.linear])
        ahead = np.maximum(before[:-1], before[1:])[:, : len(along.rows)]
        near = NEAR if now.here.secants is None else SLOW_NEAR
        for tried in range(TRIES):
            answer, (most, state, law) = self._found(now, guess, reach[1], until)
            if guess.holds(answer):
                if not self._bent(now):
                    break
                continue
            lost = (most[:, :ROBOT] > FAR * ahead[:, :ROBOT] + near).any(axis=1)
            if lost.any() and tried > 1:
                k = int(lost.argmax())
                raise NoCorridorError(self.along.grown(most[k], now.k + k))
            guess = guess.and_more(answer.grown(GROWN)) if tried else answer.grown(GUESSED)
        else:
            raise NoCorridorError(self.along.grown(most[0], now.k))
        if first and self._too_wide(now):
            raise OtherBoxError
        if self._leaves(now):
            raise OtherBoxError(answer.grown(GROWN))
        share, worst = self._conditions(law, now)
        self._carry(now, answer, until)
        self.commands = np.vstack([self.commands, law[:, :COMMAND]])[count:]
        self.before, self.last = self.last, answer
        off = now.most(along.off)
        heading = (most[:, 2] + now.most(along.turned)) * UP
        items = (along.distance(off, most), along.distance(off, ahead), heading, share, worst)
        after = self._beside(now, answer, until, slice(now.count - 1, None))[0][-1]
        return (until.linear[-1], after), np.column_stack([*items, most, state, law])

    def _beside(
        self, now: Instant, guess: Guess, until: _Until, places: slice = slice(None)
    ) -> tuple[Floats, Floats]:
        """Largest values of rows at the ends of samples (J, rows), and of inner rows within
        them.
        """
        weights, first = np.zeros((now.count, now.block.columns.shape[2])), now.block.ends[1]
        weights[:, first:] = guess.weights
        flat, count = weights.ravel(), len(self.rows)
        beside = np.array([by @ flat[: by.shape[1]] for by in now.block.by[places]])
        after = until.after[places] + beside[:, :count]
        after = (after + DOT * self._state(after) @ self.row_sizes.T) * UP
        return after, until.inner[places] + beside[:, count:]

    def _found(
        self, now: Instant, guess: Guess, reach: Floats, until: _Until
    ) -> tuple[Guess, tuple[Floats, Floats, Floats]]:
        """The next guess; bounds of the rows within samples, the state, and the law's outputs."""
        block, rows, at = now.block, self.along.rows, now.block.at
        after, inner = self._beside(now, guess, until)
        begin = np.vstack([reach, after[:-1]])
        state = self._state(begin)
        begin, after = begin[:, : len(rows)], after[:, : len(rows)]
        added, direct = self._law_added(begin, state, now), block.direct
        outs = len(self.read)
        beside = each(block.wide, state) + (direct + added)[:, self.read]
        law = (inner[:, :outs] + beside) * UP
        sizes = np.abs(self.along.outs[:, :COMMAND]) * (1 - 2**-50)
        least = now.least(sizes) - law[:, :COMMAND] * SURE
        misheard = self.inputs.misheard(least)
        added[:, :COMMAND] += misheard
        law[:, :COMMAND] += misheard
        box = each(block.box_by_state, state) + each(block.box_by_law, added) + until.box
        ask = added[:, :COMMAND] + direct[:, :COMMAND]
        extra, knots = self._within(now, state, ask, inner[:, outs:])
        most = np.maximum(np.maximum(begin, after), knots)
        most = (most + (extra + guess.left) @ self.fast_sizes.T) * UP
        step = self._step(most, law[:, :COMMAND], now) + now.here.body[at] @ self.inputs.body
        left = each(now.here.steps[at], step) * UP
        box[:, : self.nz] += left
        return Guess(added[:, :COMMAND], box * UP, left), (most, state, law)

    def _within(
        self, now: Instant, state: Floats, commands: Floats, inner: Floats
    ) -> tuple[Floats, Floats]:
        """Largest distances from the chords within samples, and largest values of the rows at the
        knots.
        """
        rows, at, push = self.along.rows, now.block.at, self.inputs.push
        extra, most = np.zeros((now.count, self.nz)), np.zeros((now.count, len(rows)))
        for j, knot in enumerate(now.here.knots):
            by_state, by_push, by_command = (part[at] for part in knot.apart)
            off = each(by_state, state) + by_push @ push + each(by_command, commands)
            extra = np.maximum(extra, off)
            if j:
                place = slice((j - 1) * len(rows), j * len(rows))
                size = np.abs(knot.state.middle[at])
                wide = each(knot.state.radius[at] + DOT * size, state)
                pushed, command = (
                    MidRadius(part.middle[at], part.radius[at])
                    for part in (knot.push, knot.command)
                )
                wide += each(command.most, commands)
                wide += (pushed.radius + DOT * pushed.most) @ push
                own = np.abs(rows @ pushed.middle) @ push
                most = np.maximum(most, inner[:, place] + own + wide @ self.fast_sizes.T)
        return extra, most

    def _carry(self, now: Instant, answer: Guess, until: _Until) -> None:
        """Propagate all generators over a block and add its own; the rest becomes a box."""
        new, beside = self._added(now, answer.force, answer.box)
        self.carried, gone = self._moved(self.carried, now, new)
        box = (gone + beside + np.abs(now.block.chain[-1]) @ self.pending) * UP
        box += DOT * until.through
        newest = self.carried.bent[-1, COMMAND:]
        newest[:] = (newest + box[self.along.lasting]) * UP
        self.pending = self._rest(box * UP)

    def _moved(
        self, carried: CarriedColumns, now: Instant, new: CarriedColumns
    ) -> tuple[CarriedColumns, Floats]:
        """Generators at the end of a block, with its own; sizes (n) of the dropped ones."""
        along, last = self.along, now.k + now.count
        columns, gone = carried.later(now.block.chain[-1], last + 1 - along.memory)
        for age, apart in along.spacings:
            columns, beside = columns.thinned(last - age - now.count + 1, last - age, apart)
            gone = gone + beside
        return columns.and_more(new), gone

    def _rest(self, box: Floats) -> Floats:
        """The box without the components that persist."""
        rest = box.copy()
        rest[self.along.lasting] = 0.0
        return rest

    def _added(self, now: Instant, force: Floats, box: Floats) -> tuple[CarriedColumns, Floats]:
        """Generators that a block adds, at its end, and an additional box (n)."""
        lasting, (known, first) = self.along.lasting, now.block.ends
        law, boxes = range(first, first + COMMAND), first + COMMAND
        places = [*range(known), *law, *(boxes + k for k in lasting), *range(known, first)]
        columns, ends = now.block.columns, self.carried.ends
        weight = np.ones((len(places), now.count))
        weight[slice(*ends)] = np.hstack([force, box[:, lasting]]).T
        rest = box.copy()
        rest[:, lasting] = 0.0
        born, values = np.arange(now.k, now.k + now.count) + 1, columns[..., places].swapaxes(1, 2)
        new = CarriedColumns(born, values, weight, ends)
        return new, np.einsum("njm,jm->n", np.abs(columns[..., boxes:]), rest)

    def _conditions(self, law: Floats, now: Instant) -> tuple[Floats, Floats]:
        """Largest use of a condition in each sample (share of its bound), and its index."""
        along = self.along
        level = now.most(along.levels) + law[:, COMMAND:]
        shares = np.full(level.shape, np.inf)
        np.divide(level, along.most, out=shares, where=along.most > 0)
        worst, share = shares.argmax(axis=1), shares.max(axis=1) * UP
        beyond = ~(share <= 1)
        if beyond.any():
            k = int(beyond.argmax())
            i = worst[k]
            raise NoCorridorError(
                f"{self.loop.conditions[i].name} may reach {level[k, i]:.3g} of "
                f"{along.most[i]:.3g} {along.place(now.k + k)}"
            )
        return share, worst.astype(float)
