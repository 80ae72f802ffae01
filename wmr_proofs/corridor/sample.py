"""Matrices of one sample of the loop in balls, and rows of outputs within it."""

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from flint import arb, arb_mat
from numpy.typing import NDArray

from wmr_ctrl.theory.checks.error_coordinates import COMMAND, ROBOT, Floats

from .loop import SampledLoop

BallArray: TypeAlias = NDArray[np.object_]
"""Balls in an array, whose products are enclosures."""
EXACT, NOTHING = 2.0**-53, 1e-60
"""A ball's double is off by this share and this much at most, which is checked."""
LARGEST = 1e9
"""Largest double of a matrix."""
FLOOR = 1e-20
"""Bound of NOTHING's effect in 1e7 products of four such matrices."""
ROUNDING = 1e-13
"""Share by which a sum of up to 100 products of such doubles, each rounded, can err."""
STRIDE = 16
"""Samples whose powers are one product."""


class SlowLoopError(ArithmeticError):
    """The loop does not settle within the allowed numbers of samples and bits."""


@dataclass(frozen=True)
class OutputRows:
    """Rows of outputs: by the state, directly by each input, and by plant steps of the sample."""

    picked: Floats
    state: Floats
    push: Floats
    law: Floats
    late: Floats
    measured: Floats
    steps: Floats


class SampleMatrices:
    """Matrices of one sample in balls, in the current precision.

    The state is fast state, commands sent, memory, acting command; the law's outputs are its
    command, next memory, acting command, and the conditions' values.  ``within``: rows of the fast
    state after each number of plant steps, by state and command, pushes, and late commands.
    """

    def __init__(self, loop: SampledLoop) -> None:
        """Compose x' = free x + outputs l + push d, l = law x, for sample and plant step."""
        nz, nq, nm, na = len(loop.names), COMMAND * loop.queue, loop.memory, loop.acting
        self.n = n = nz + nq + nm + na
        slopes, step = (np.array(curve.slopes(), dtype=object) for curve in (loop.law, loop.step))
        self.law = balls(len(slopes), n)
        order = [
            *range(ROBOT),
            *range(nz + nq, nz + nq + nm),
            *range(nz, nz + nq),
            *range(n - na, n),
        ]
        self.law[:, order] = slopes
        self.seen = slopes[:, :ROBOT]
        self.step = step[:, :nz]
        ages = [np.hstack([balls(COMMAND, n), unit_matrix(COMMAND)])]
        for age in range(loop.queue):
            at = nz + COMMAND * age
            ages.append(
                np.hstack([balls(COMMAND, at), unit_matrix(COMMAND), balls(COMMAND, n - at)])
            )
        now = np.hstack([unit_matrix(nz), balls(nz, n - nz + COMMAND)])
        overlap = loop.overlap.steps
        pushed, late = balls(nz, COMMAND), balls(nz, COMMAND * overlap)
        self.within = [(now, pushed, late)]
        by_command = step[:, nz : nz + COMMAND]
        for s in range(loop.steps):
            age, share = loop.acts(s)
            acts = ages[age]
            if share:
                acts = arb(1 - share) * acts + arb(share) * ages[age + 1]
            now = self.step @ now + by_command @ acts
            pushed = self.step @ pushed + step[:, nz + COMMAND : nz + 2 * COMMAND]
            late, phase = self.step @ late, (s - loop.late) % loop.steps
            if phase < overlap:
                late[:, COMMAND * phase : COMMAND * (phase + 1)] += by_command
            self.within.append((now, pushed, late))
        sent = [row for age in ages[: loop.queue] for row in age]
        rows = np.vstack([now, *sent, balls(nm + na, n + COMMAND)])
        self.push = np.vstack([pushed, balls(n - nz, COMMAND)])
        self.late = np.vstack([late, balls(n - nz, COMMAND * overlap)])
        self.outputs = balls(n, len(slopes))
        self.outputs[:, :COMMAND] = rows[:, n:]
        self.outputs[nz + nq :, COMMAND : COMMAND + nm + na] = unit_matrix(nm + na)
        self.A = rows[:, :n] + self.outputs @ self.law

    def rows_within(self, s: int, picked: Floats) -> OutputRows:
        """Rows of the fast state after ``s`` plant steps of a sample."""
        now, push, late = self.within[s]
        command = now[:, self.n :]
        whole = now[:, : self.n] + command @ self.law[:COMMAND]
        law = np.zeros((len(picked), len(self.law)))
        law[:, :COMMAND] = sizes(picked, doubles(command))
        steps, power = np.zeros((len(picked), len(self.step))), unit_matrix(len(self.step))
        for _ in range(s):
            steps, power = steps + sizes(picked, doubles(power)), self.step @ power
        seen = command @ self.seen[:COMMAND]
        return OutputRows(
            picked, doubles(whole), sizes(picked, doubles(push)), law,
            sizes(picked, doubles(late)), sizes(picked, doubles(seen)), steps,
        )  # fmt: skip

    def reckoned_rows(self, loop: SampledLoop) -> OutputRows:
        """Rows of e at a sample's end less its value by dead reckoning from the beginning.

        Rows of direct effects keep their signs.
        """
        nz = len(loop.names)
        rows, reckoned = self.rows_within(loop.steps, np.eye(3, nz)), balls(nz, self.n)
        slopes = np.array(loop.reckoning.slopes(), dtype=object)
        reckoned[:3, :ROBOT] = slopes
        now, push, late = self.within[-1]
        command = now[:, self.n :]
        whole = now[:, : self.n] + command @ self.law[:COMMAND] - reckoned
        seen = command @ self.seen[:COMMAND]
        seen[:3, 3:] = seen[:3, 3:] - slopes[:, 3:]
        law = np.zeros_like(rows.law)
        law[:, :COMMAND] = doubles(command[:3])
        pushed, lates, measured = (doubles(item[:3]) for item in (push, late, seen))
        return OutputRows(rows.picked, doubles(whole), pushed, law, lates, measured, rows.steps)


def powers_of(matrix: BallArray, count: int) -> list[BallArray]:
    """The first powers of a matrix, from the 0th on."""
    listed = [unit_matrix(len(matrix))]
    while len(listed) < count:
        listed.append(matrix @ listed[-1])
    return listed


def powers_until(matrix: BallArray, samples: int) -> tuple[Floats, Floats, Floats]:
    """Powers of A before each sample (samples, n, n), sums of their terms' sizes, and the next
    power.

    Each is a product in doubles of a power of A below STRIDE and a power of A**STRIDE, except the
    last, which is computed in balls.
    """
    A = arb_mat(matrix.tolist())
    first = [A**0]
    for _ in range(STRIDE):
        first.append(A * first[-1])
    power, far, leap, count = first[0], [], first.pop(), samples // STRIDE
    for _ in range(count):
        far.append(power)
        power = leap * power
    near, later = (
        np.array([doubles(_entries(x)) for x in part]) for part in (first, [*far, power])
    )
    pairs = (near, later), (np.abs(near), np.abs(later))
    powers, summed = (
        (one[None] @ two[:, None]).reshape(-1, *one.shape[1:])[:samples] for one, two in pairs
    )
    return powers, summed, doubles(_entries(first[samples % STRIDE] * power))


def _entries(matrix: arb_mat) -> BallArray:
    result = np.empty(matrix.nrows() * matrix.ncols(), dtype=object)
    result[:] = matrix.entries()
    return result.reshape(matrix.nrows(), -1)


def sizes(picked: Floats, block: Floats) -> Floats:
    """Sizes of rows of a matrix, with the rounding of their sums."""
    return np.abs(picked @ block) + ROUNDING * np.abs(picked) @ np.abs(block)


def balls(rows: int, columns: int) -> BallArray:
    """Array of zero balls."""
    block = np.empty((rows, columns), dtype=object)
    block[...] = arb(0)
    return block


def unit_matrix(size: int) -> BallArray:
    """Identity matrix in balls."""
    block = balls(size, size)
    for k in range(size):
        block[k, k] = arb(1)
    return block


def doubles(matrix: BallArray) -> Floats:
    """Midpoints; SlowLoopError if a ball is wider than the sums allow for."""
    flat = matrix.ravel()
    middle = np.fromiter(map(float, flat), float, len(flat))
    wide = np.fromiter(map(float, map(arb.rad, flat)), float, len(flat))
    tight = wide <= EXACT * np.abs(middle) + NOTHING
    if not (tight & (np.abs(middle) < LARGEST)).all():
        raise SlowLoopError("its matrix takes more bits than were estimated")
    return middle.reshape(matrix.shape)
