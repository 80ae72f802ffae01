"""Dead reckoning between poses: its error bound.

Let e be the tracking error and e + y that of the pose that the law receives.  A sample without a
pose changes both by one map f of error and measured velocity, except for the error r of f on the
robot's true motion:

    y' = f(e + y, v) - e' = Phi y - r + terms of second order,    Phi = df/de on the reference.

So y is the error of the last pose, which keeps its size (ledger: corridor.reckoning), plus a sum of
products Phi^i r, whose peak gain is a row of the loop. r is mostly the change of velocity within a
sample, and contributions of successive samples cancel.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from flint import ctx

from wmr_ctrl.theory.checks.error_coordinates import Floats

from .enclosure import upper
from .inputs import Inputs, NoCorridorError
from .loop import UP, SampledLoop
from .peaks import reference_gap
from .sample import doubles

MOST_ROW_SAMPLES = 400
"""Samples at most that are summed up with their signs; of more, such sums are added up.  The sums
over more and more samples cost as much as they are long."""
BITS = 320
"""Bits of precision for Phi."""
ROUNDS = 30
"""Rounds in which an error is found."""
MORE = 1.001
"""Growth of a guess over the last error."""
LOST = 1e3
"""Error [m, rad] that is not looked for any more."""


@dataclass(frozen=True)
class Reckoning:
    """Dead reckoning over up to ``count`` samples of a loop."""

    loop: SampledLoop
    count: int

    @property
    def row_samples(self) -> int:
        """Number of samples whose sums are separate rows of the loop."""
        return min(self.count, MOST_ROW_SAMPLES)

    @cached_property
    def turning(self) -> Floats:
        """Phi (3, 3): propagation of a pose error by dead reckoning over a sample."""
        with ctx.workprec(BITS):
            slopes = self.loop.reckoning.slopes()
            return doubles(np.array([row[:3] for row in slopes], dtype=object))

    @cached_property
    def _powers(self) -> Floats:
        """Sizes of Phi^j (row_samples + 1, 3, 3)."""
        powers = [np.eye(3)]
        for _ in range(self.row_samples):
            powers.append(self.turning @ powers[-1])
        return np.abs(powers) * UP

    @cached_property
    def _rest(self) -> Floats:
        """Remainder of f on the reference (3), for all orientations of the frame."""
        curve, period = self.loop.reckoning, self.loop.setup.scenario.clock.control
        rest = np.array([upper(item) for item in curve.value()])
        rest[:2] += 3 * reference_gap(curve.at[3:], period)
        return rest

    def added(self, inputs: Inputs, measured: Floats, fast: Floats) -> Inputs:
        """The inputs, enlarged by the errors of a pose after up to ``inputs.missing`` samples
        without one.

        ``measured``: sizes of e and v as measured (5); the last rows of ``fast`` are those of the
        linear part, (row_samples, 3).  Raises NoCorridorError if an error amplifies itself without
        bound.
        """
        rows = fast[-3 * self.row_samples :].reshape(-1, 3)
        linear, pose = self._summed(rows, inputs.missing), np.array([inputs.pose, inputs.pose, 0.0])
        guess = linear.max(axis=0) + pose
        for _ in range(ROUNDS):
            shown = measured + np.array([*guess, 0.0, 0.0])
            each = self.loop.reckoning.remainders(np.outer(shown, shown) * UP).sum(axis=(1, 2))
            bent = self._gathered((each + self._rest) * UP, inputs.missing)
            off = (linear + bent) * UP
            if (off.max(axis=0) + pose <= guess).all():
                return replace(inputs, reckoned=off.max(axis=0) * UP)
            guess = (off.max(axis=0) + pose) * MORE
            if not (guess < LOST).all():
                break
        raise NoCorridorError(
            f"the error of a pose that is reckoned for {inputs.missing} samples may grow by "
            "itself, by its turn as the robot goes on"
        )

    def _summed(self, rows: Floats, count: int) -> Floats:
        """Sizes (count, 3) of sums over 1, 2, ... samples."""
        sums = [rows[:count]]
        for _ in range(-(-count // len(rows)) - 1):
            sums.append((sums[-1] @ self._powers[-1].T + rows[-1]) * UP)
        return np.concatenate(sums)[:count]

    def _gathered(self, each: Floats, count: int) -> Floats:
        """Sizes (count, 3) of sums of errors with either sign in every sample."""
        ways = np.cumsum(self._powers[:-1], axis=0) @ each * UP
        return self._summed(ways, count)
