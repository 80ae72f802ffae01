"""Linearisation remainders of law and plant step in the samples of a flowpipe."""

import numpy as np

from wmr_ctrl.theory.checks.error_coordinates import COMMAND, ROBOT, Floats

from .along import Along
from .enclosure import OpenBoxError
from .inputs import Inputs, NoCorridorError
from .instant import Instant
from .loop import UP
from .motion import UNSURE
from .secants import LEAST

ROOM = 1.03
"""Growth of the box on which a bend is computed."""
MORE_ROOM = 1.06
"""Growth once such a box has been left."""
LITTLE = 0.4
"""Share of the typical sizes below which FIRST_ROOM is taken."""
FIRST_ROOM = 2.0
"""Growth of the box while deviations are small."""
SLOW_ROOM = 1.05
"""Growth of a box of secants."""
SLOW_SHARE = 0.02
"""Share of the typical sizes that is added to such a box."""
TOO_WIDE = 1.05
"""Ratio of such a box to the needed one from which on it is made anew."""


class Remainders:
    """Remainder bounds by second derivatives on a box, reused while it fits, or by secants."""

    def __init__(self, along: Along, inputs: Inputs) -> None:
        """Begin without any deviation, for one loop under bounded inputs."""
        self.along, self.inputs, self.loop = along, inputs, along.loop
        self.nz = len(self.loop.names)
        self.error = inputs.measured
        self.commands = np.zeros((self.loop.queue, COMMAND))
        self.curves = self.loop.law_curve, self.loop.step_curve
        self.latest = [np.zeros((1, curve.by.numel())) for curve in self.curves]
        self.bends: list[tuple[Floats, Floats] | None] = [None, None]

    def _products(self, reach: Floats, error: Floats) -> Floats:
        """Largest products (J, 5, 5) of two of the robot's measured errors."""
        along, sizes = self.along, reach[:, :ROBOT]
        pairs = sizes[:, :, None] * sizes[:, None]
        both = reach[:, -2 * len(along.pairs) :].reshape(len(reach), -1, 2).max(axis=2)
        first, second = np.array(along.pairs).T
        least = np.minimum(pairs[:, first, second], both**2 / (4 * along.ratios))
        pairs[:, first, second] = pairs[:, second, first] = least
        mixed = sizes[:, :, None] * error
        return np.asarray(pairs + mixed + mixed.transpose(0, 2, 1) + np.outer(error, error))

    def _left(self, place: int, sizes: Floats, products: Floats, now: Instant) -> Floats:
        """Remainders of the linear parts of law (0) or plant step (1) on the latest boxes."""
        self.latest[place] = sizes
        if now.here.secants is not None:
            return np.asarray(now.here.secants[place].left[now.block.at])
        _, bend = self.bends[place] or self._bend(place, now)
        pairs = sizes[:, :, None] * sizes[:, None]
        pairs[:, :ROBOT, :ROBOT] = products
        along = self.along
        curve, off = self.curves[place], along.residuals[place]
        return np.asarray((curve.remainders(bend, pairs) + off) * UP)

    def roomy(self, sizes: Floats) -> Floats:
        """A secant box with room for deviations of these sizes."""
        wide = sizes * SLOW_ROOM
        wide[:, :ROBOT] += SLOW_SHARE * self.along.typical @ self.inputs.push
        return wide

    def _leaves(self, now: Instant) -> bool:
        """True if deviations leave the secant boxes."""
        pairs = zip(now.here.secants or (), self.latest, strict=False)
        return any((sizes > item.wide[now.block.at]).any() for item, sizes in pairs)

    def _too_wide(self, now: Instant) -> bool:
        """True if secant boxes are wider than necessary."""
        for item, sizes in zip(now.here.secants or (), self.latest, strict=False):
            need = TOO_WIDE * self.roomy(sizes) + 2 * LEAST
            if (need < item.wide[now.block.at])[:, :ROBOT].any():
                return True
        return False

    def _bent(self, now: Instant) -> bool:
        """True if deviations left the boxes of the second derivatives, which are then
        recomputed.
        """
        bends = zip(self.bends, self.latest, strict=True)
        left = [p for p, (bend, x) in enumerate(bends) if bend and (x > bend[0]).any()]
        for place in left if now.here.secants is None else ():
            self._bend(place, now)
        return now.here.secants is None and bool(left)

    def _law_added(self, reach: Floats, state: Floats, now: Instant) -> Floats:
        """Largest linearisation remainders of the law's outputs, with rounding."""
        loop, queue = self.loop, self.nz + COMMAND * self.loop.queue
        own, acting = np.split(state[:, queue:], [loop.memory], axis=1)
        robot = state[:, :ROBOT] + self.error
        sizes = np.hstack([robot, own, state[:, self.nz : queue], acting])
        products = self._products(reach, self.error)
        return self._left(0, sizes, products, now)

    def _step(self, guess: Floats, commands: Floats, now: Instant) -> Floats:
        """Largest linearisation errors of a plant step while the state stays within Z."""
        count = now.count
        every = np.vstack([self.commands, commands])
        acts = np.max([every[k : k + count] for k in range(len(every) - count + 1)], axis=0)
        known = np.concatenate([self.inputs.push, self.inputs.body])
        sizes = np.hstack([guess[:, : self.nz], acts, np.tile(known, (count, 1))])
        return self._left(1, sizes, self._products(guess, np.zeros(ROBOT)), now)

    def _bend(self, place: int, now: Instant) -> tuple[Floats, Floats]:
        """A box with a margin around the latest deviations, and the stored second derivatives on
        it.
        """
        sizes = self.latest[place].max(axis=0)
        little = (sizes[:ROBOT] < LITTLE * self.along.typical @ self.inputs.push).all()
        room = FIRST_ROOM if little else MORE_ROOM if self.bends[place] else ROOM
        ranges = (self.along.law_range, self.along.step_range)[place]
        grown, (by, numbers) = sizes * room + 4 * UNSURE * (sizes > 0), ranges(now.k, now.end)
        try:
            bend = grown, self.curves[place].bend_within(by, grown, numbers, fine=now.held)
        except OpenBoxError as error:
            text = self.along.grown(sizes, now.k)
            raise NoCorridorError(text) from error
        self.bends[place] = bend
        return bend
