"""The nominal trajectory of a law's loop over a whole run, and matrices of the deviations from it.

Each disturbance of a sample is a generator (a column): pushes, measurement errors, and the
linearisation remainder of the law's force, each with either sign.  The sample's matrix propagates
them.  The other contributions of a sample are a box: remainders, the radii of the matrices, and
rounding.  Order reduction: generators that have become old are added to that box.
"""

from dataclasses import replace
from functools import cached_property, partial
from itertools import pairwise
from math import ceil, cos, pi

import numpy as np

from wmr_ctrl.control.setup import Setup
from wmr_ctrl.theory.checks.error_coordinates import COMMAND, ROBOT, Floats
from wmr_ctrl.theory.checks.loop import IntArray

from .enclosure import OpenBoxError
from .gains import fast_rows
from .inputs import NoCorridorError, check_size, conditions
from .loop import UP
from .midradius import ROUNDED, MidRadius, hull
from .motion import MovingLoop, motion_of
from .secants import SecantCurve
from .stretch import Stretch, forgets, stretch

DIRECTIONS = 12
CHUNK = 1.0
"""Time for which one bend holds [s]."""
KNOT = 0.02
"""Time between knots within a sample [s]."""
LEFT = 5e-3
"""Share of its first size below which a generator is old."""
LONGEST = 1500
"""Samples after which every generator is old."""
STEADY = 1e-9
"""Difference of numbers from sample to sample that counts as none; nothing rests on it."""
BATCH_TIME = 0.2
"""Time of the samples that are followed in one block [s]."""
BATCH_MOST = 20
"""Most samples of a block."""
YOUNG = 0.5
"""Age from which on the generators of some samples stand for all [s]."""
APART = 0.03
"""Time between these samples [s]."""
OLD = 1.2
"""Further age from which on still fewer generators are kept [s]."""
OF_OLD = 3
"""Samples for each generator that is then kept."""
BRIEF = 0.1
"""Time for which a box of secants is made [s]."""
SLOW = 2.0
"""Speed up to which secants are used, over v_s."""
SPREAD = 1.2
"""Growth of deviations that this speed includes."""
KEPT = 4
"""Lists of slopes that are kept."""
MOST_CHUNKS = 8
"""Most chunks of such a list."""
PORTION, PLACES = 500, 9
"""Samples whose undisturbed run is compared with the graphs at once; samples at which it is looked
how fast the loop forgets."""


class Along:
    """A law's loop along its scenario's run."""

    def __init__(self, setup: Setup) -> None:
        """Compose the graphs and run the loop undisturbed; NoCorridorError if that fails."""
        self.setup, self.motion = setup, motion_of(setup.scenario)
        self.loop = loop = MovingLoop(setup, self.motion, partial(conditions, setup))
        check_size(loop)
        self.states, self.fine, self.outs = loop.undisturbed()
        if not (np.isfinite(self.states).all() and np.isfinite(self.outs).all()):
            raise NoCorridorError("the loop is unstable where nothing disturbs it")
        self.residuals = self._residuals()
        self.rows = fast_rows(len(loop.names), DIRECTIONS, self.pairs, self.ratios)
        self._kept = list[tuple[int, int, MidRadius, MidRadius]]()

    @cached_property
    def knots(self) -> list[int]:
        """Plant steps of a sample between which rows are bounded."""
        steps = self.loop.steps
        count = max(1, min(steps, ceil(self.setup.scenario.clock.control / KNOT - 1e-9)))
        return [round(k * steps / count) for k in range(count)]

    @cached_property
    def most(self) -> Floats:
        """Sizes that the conditions' values may have."""
        sizes = self.loop.sizes(*(
            [MidRadius(np.array([x])) for x in part]
            for part in (self._law_by(np.array([0]))[0], self.loop.law_numbers[0])
        ))  # fmt: skip
        return np.asarray((sizes.middle - sizes.radius)[0] * (1 - 2**-50))

    def place(self, k: int) -> str:
        """Text on the time of a sample and the reference's motion there."""
        time, (v, w) = k * self.setup.scenario.clock.control, self.motion.v_d[k]
        return f"at t = {time:.4g} s, where v_d = {v:.3g} m/s and w_d = {w:.3g} rad/s"

    def grown(self, reach: Floats, k: int) -> str:
        """Text on products of deviations that grow too large in a sample, beyond a ``reach``."""
        far = f" beyond {d:.3g} mm" if np.isfinite(d := 1e3 * np.hypot(*reach[:2])) else ""
        text = "products of deviations may grow as large as what the loop corrects"
        return f"{text}{far} {self.place(k)}"

    def chunks(self) -> list[tuple[int, int]]:
        """First and last samples of the chunks that share one bound of the second derivatives.

        The first sample is a chunk of its own, and so is one in which the robot changes.
        """
        n, period = len(self.motion.v_d), self.setup.scenario.clock.control
        size = self.batch * max(1, round(CHUNK / period / self.batch))
        bodies = self.motion.robot
        within = np.flatnonzero((bodies != bodies[:, :1]).any(axis=(1, 2)))
        own = [0, 1, *range(1 + size, n, size), n, *self.motion.moved, *(k + 1 for k in within)]
        ends = sorted({int(k) for k in own})
        return [(a, b) for a, b in pairwise(ends) if a < b]

    @cached_property
    def batch(self) -> int:
        """Number of samples in a block, which are propagated together."""
        period = self.setup.scenario.clock.control
        return min(BATCH_MOST, max(1, round(BATCH_TIME / period)))

    def count_from(self, k: int) -> int:
        """Samples in a block that begins at ``k``: fewer soon after a change of the robot."""
        lately = any(moved <= k < moved + self.memory for moved in self.motion.moved)
        return max(1, self.batch // (1 + lately))

    @cached_property
    def young(self) -> int:
        """Number of recent samples that keep all their generators."""
        blocks = max(1, round(YOUNG / self.setup.scenario.clock.control / self.batch))
        return min(self.memory, blocks * self.batch)

    @cached_property
    def spacings(self) -> list[tuple[int, int]]:
        """Thinning of generators: pairs (age from which it applies, samples for each kept one)."""
        period = self.setup.scenario.clock.control
        return [
            (self.young, max(1, int(APART / period + 1e-9))),
            (self.young + self.batch * round(OLD / period / self.batch), OF_OLD),
        ]

    @cached_property
    def pairs(self) -> list[tuple[int, int]]:
        """Pairs of the robot's errors with a mixed second derivative in law or plant step."""
        both = [self.loop.law_curve.bends, self.loop.step_curve.bends]
        result = {(min(i, j), max(i, j)) for item in both for _, i, j in item.tolist() if i != j}
        return sorted((i, j) for i, j in result if j < ROBOT)

    @cached_property
    def halfway(self) -> Stretch:
        """Matrices of the sample in the middle."""
        return self._stretch(np.array([len(self.motion.v_d) // 2]))

    @cached_property
    def lasting(self) -> list[int]:
        """Components of the state that persist; their boxes become generators."""
        first = len(self.loop.names) + COMMAND * self.loop.queue
        lasting = np.abs(np.diag(self.halfway.A.middle[0])) > ROUNDED
        return [*range(len(self.loop.names)), *(first + np.flatnonzero(lasting[first:])).tolist()]

    @cached_property
    def typical(self) -> Floats:
        """Typical sizes of errors (5, 2) due to pushes of 1 N m, halfway; no bound depends on
        them.
        """
        here = self.halfway
        A, x, seen = here.A.middle[0], here.push.middle[0], 0.0
        for _ in range(LONGEST):
            seen, x = seen + np.abs(x[:ROBOT]), A @ x
        return np.asarray(seen)

    @cached_property
    def ratios(self) -> Floats:
        """Ratio of the typical sizes of each pair of errors."""
        sizes = self.typical.sum(axis=1)
        sizes = sizes + 1e-6 * sizes.max()
        return np.array([sizes[a] / sizes[b] for a, b in self.pairs])

    @cached_property
    def memory(self) -> int:
        """Samples after which a generator counts as old."""
        n = len(self.motion.v_d)
        speeds = np.abs(self.motion.v_d[1:, 0])
        moving = 1 + np.flatnonzero(speeds >= 0.3 * speeds.max())
        places = sorted({int(moving[round(k)]) for k in np.linspace(0, len(moving) - 1, PLACES)})
        here = self._stretch(np.array(places))
        each = zip(here.A.middle, here.push.middle, strict=True)
        return min(n, max(forgets(A, push, LEFT, LONGEST) for A, push in each))

    def _law_by(self, at: IntArray) -> Floats:
        """Variables of the law at some samples (samples, ...)."""
        loop, nz = self.loop, len(self.loop.names)
        queue = nz + COMMAND * loop.queue
        x = self.states[at]
        own, sent = x[:, queue : queue + loop.memory], x[:, nz:queue]
        return np.hstack([x[:, :ROBOT], own, sent, x[:, queue + loop.memory :]])

    def _step_by(self, at: IntArray) -> Floats:
        """Variables of each plant step of some samples (samples, steps, ...)."""
        loop, body = self.loop, self.motion.robot[at, :, :2]
        behind, rest = divmod(loop.late, loop.steps)
        u = np.vstack([np.zeros((behind + 1, COMMAND)), self.outs[:, :COMMAND]])
        age = behind + (np.arange(loop.steps) < rest)
        acts = u[at[:, None] + behind + 1 - age[None, :]]
        push = np.zeros((*acts.shape[:2], COMMAND))
        return np.concatenate([self.fine[at, :-1], acts, push, body], axis=2)

    def _residuals(self) -> tuple[Floats, Floats]:
        """Largest differences between the undisturbed run and the graphs, over all samples.

        They are for the law's outputs, and for the fast state at the end of each plant step.
        """
        loop, n = self.loop, len(self.motion.v_d)
        law, step = np.zeros(self.outs.shape[1]), np.zeros(len(loop.names))
        for first in range(0, n, PORTION):
            part = np.arange(first, min(first + PORTION, n))
            given = MidRadius(self._law_by(part))
            value = loop.law_curve.value(given, MidRadius(loop.law_numbers[part]))
            law = np.maximum(law, (value - MidRadius(self.outs[part])).most.max(axis=0))
            given = MidRadius(self._step_by(part))
            value = loop.step_curve.value(given, MidRadius(loop.step_numbers[part]))
            off = (value - MidRadius(self.fine[part, 1:])).most
            step = np.maximum(step, off.max(axis=(0, 1)))
        return law, step

    def law_range(self, first: int, last: int) -> tuple[MidRadius, MidRadius]:
        """Ranges of the law's variables and numbers over some samples."""
        by, numbers = hull(self._law_by(np.arange(first, last)), 0), self.loop.law_numbers
        return by, hull(numbers[first:last], 0)

    def step_range(self, first: int, last: int) -> tuple[MidRadius, MidRadius]:
        """Ranges of a plant step's variables and numbers over all plant steps of some samples."""
        by, numbers = self._step_by(np.arange(first, last)), self.loop.step_numbers[first:last]
        one, other = (hull(item.reshape(-1, item.shape[2]), 0) for item in (by, numbers))
        return one, other

    def steady_until(self, k: int) -> tuple[int, int]:
        """First and last of the samples around ``k`` with constant reference and robot."""
        changing = self._changing
        before, after = changing[changing <= k], changing[changing > k]
        ends = before.max(initial=0), after.min(initial=len(self.motion.v_d))
        return int(ends[0]), int(ends[1])

    @cached_property
    def _changing(self) -> IntArray:
        """Samples that differ from the one before."""
        motion, n = self.motion, len(self.motion.v_d)
        numbers = np.hstack([motion.v_d, motion.rate, motion.way[1:], motion.robot.reshape(n, -1)])
        differs = (np.abs(np.diff(numbers, axis=0)) > STEADY).any(axis=1)
        return np.flatnonzero(differs) + 1

    def held(self, first: int, last: int) -> Stretch:
        """Matrices that enclose those of several samples."""
        loop = self.loop
        law = loop.law_curve.slopes(*(item[None, :] for item in self.law_range(first, last)))
        step = loop.step_curve.slopes(*(item[None, :] for item in self.step_range(first, last)))
        return stretch(loop, law, step, self.knots)

    def _stretch(self, at: IntArray) -> Stretch:
        return stretch(self.loop, *self._slopes(at), self.knots)

    def _slopes(self, at: IntArray) -> tuple[MidRadius, MidRadius]:
        """Gradients of the law at samples, and of the plant step over all steps of each sample."""
        loop = self.loop
        by = MidRadius(self._law_by(at)), MidRadius(loop.law_numbers[at])
        steps = hull(self._step_by(at), 1), hull(loop.step_numbers[at], 1)
        return loop.law_curve.slopes(*by), loop.step_curve.slopes(*steps)

    def matrices(self, first: int, last: int) -> Stretch:
        """Matrices from cached gradients; each new entry covers more samples than the last."""
        for begin, end, law, step in self._kept:
            if begin <= first and last <= end:
                part = slice(first - begin, last - begin)
                return stretch(self.loop, law[part, ...], step[part, ...], self.knots)
        more = min(MOST_CHUNKS, 2 ** len(self._kept)) * (last - first)
        end = min(first + more, len(self.motion.v_d))
        try:
            here = self._slopes(np.arange(first, end))
        except OpenBoxError:
            end, here = last, self._slopes(np.arange(first, last))
        self._kept = [*self._kept[: KEPT - 1], (first, end, *here)]
        return self.matrices(first, last)

    @cached_property
    def brief(self) -> int:
        """Number of samples that a secant box covers."""
        return max(1, round(BRIEF / self.setup.scenario.clock.control))

    def is_slow(self, first: int, last: int, reach: Floats) -> bool:
        """True if friction may change its sign in some samples."""
        v = self.fine[first:last, :, 3]
        most = SLOW * self.setup.scenario.robot.v_s + SPREAD * reach[3]
        return bool(np.abs(v).min() < most or v.min() < 0 < v.max())

    def secant_stretch(self, first: int, last: int, wide: tuple[Floats, Floats]) -> Stretch:
        """Matrices of some samples by secants over boxes of law and plant step variables."""
        loop, at = self.loop, np.arange(first, last)
        law_by, outs = self._law_by(at), self.outs[first:last, None]
        numbers = MidRadius(loop.law_numbers[at])
        law = self._law_secants.over(MidRadius(law_by), numbers, wide[0], law_by[:, None], outs)
        step_by, after = self._step_by(at), self.fine[first:last, 1:]
        numbers = hull(loop.step_numbers[at], 1)
        step = self._step_secants.over(hull(step_by, 1), numbers, wide[1], step_by, after)
        return replace(stretch(loop, law.slopes, step.slopes, self.knots), secants=(law, step))

    @cached_property
    def _law_secants(self) -> SecantCurve:
        return SecantCurve(self.loop.law_curve)

    @cached_property
    def _step_secants(self) -> SecantCurve:
        return SecantCurve(self.loop.step_curve)

    def distance(self, off: Floats, reach: Floats) -> Floats:
        """Distances [m] from the place on the path, for ``reach`` around an `off` (J, r)."""
        directions = slice(len(self.loop.names), len(self.loop.names) + DIRECTIONS)
        most = (off[:, 1:] + reach[:, directions]).max(axis=1)
        return np.asarray((most + off[:, 0]) / cos(pi / (2 * DIRECTIONS)) * UP)

    @cached_property
    def off(self) -> Floats:
        """Offsets of the nominal trajectory (n, r): chord to path, then by direction."""
        first = len(self.loop.names)
        off = np.abs(self.fine[:, :, :2] @ self.rows[first : first + DIRECTIONS, :2].T).max(axis=1)
        return np.hstack([self.motion.aside[:, None], off])

    @cached_property
    def levels(self) -> Floats:
        """Sizes of the conditions' values (n, conditions)."""
        return np.abs(self.outs[:, -self.loop.count :])

    @cached_property
    def turned(self) -> Floats:
        """Heading offset of the nominal trajectory in each sample (n) [rad]."""
        return np.asarray(np.abs(self.fine[:, :, 2]).max(axis=1) * UP + self.motion.turned)
