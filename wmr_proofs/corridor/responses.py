"""Responses of the sampled loop to a unit of each input, and the resulting gains of rows of
outputs.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property

import numpy as np

from wmr_ctrl.theory.checks.error_coordinates import COMMAND, ROBOT, Floats
from wmr_ctrl.theory.checks.loop import IntArray

from .loop import UP
from .sample import FLOOR, ROUNDING, OutputRows


@dataclass(frozen=True)
class Gains:
    """Largest values of rows for inputs of size 1 in every sample, with any signs.

    ``by``: columns push (2), errors of the law's outputs, errors of the acting command in each
    plant step of the overlap (2 each), a disc of measured (e1, e2), errors of measured e1, e2, e3,
    v1 and omega.  ``steps``: for increments in every plant step.  ``start``: largest values at any
    time after an initial deviation by shares of the requested columns.  ``misled``: after an
    initial estimate whose position alone is off by 1 m in any direction.  ``before`` (2 columns):
    after a start at which only an observer's remembered velocity is off by 1.  ``first``: gains
    within one sample, from the state at its beginning and then as ``by`` and ``steps``.  ``left``:
    remainder after ``samples``, per unit of the state's largest deviation in units of ``scale``.
    ``constant``: largest values under equal increments of every plant step, alone.
    """

    by: Floats
    steps: Floats
    start: Floats
    misled: Floats
    before: Floats
    first: tuple[Floats, Floats, Floats]
    left: Floats
    constant: Floats


@dataclass
class Responses:
    """The loop's response to a unit of each input, (samples, n, courses), and sums over it.

    ``which`` (inputs): index of each input's course, as many inputs share one.  ``powers``: sizes
    of the terms of the powers.  ``norms`` (samples, inputs): weighted norms of the course;
    ``steady_norm``: the sum of those of ``steady``.
    """

    course: Floats
    powers: Floats
    inputs: Floats
    norms: Floats
    scale: Floats
    damping: float
    n: int
    steps: Floats
    start: Floats
    estimate: int | None
    old: int | None
    steady: Floats
    steady_size: Floats
    steady_norm: float
    which: IntArray

    @cached_property
    def _in_rows(self) -> Floats:
        """The courses as one matrix (n, courses samples)."""
        return np.ascontiguousarray(self.course.transpose(1, 2, 0)).reshape(self.n, -1)

    def gains(self, rows: OutputRows, added: Floats | None = None) -> Gains:
        """Gains of some rows: sums of absolute values, the shares of rounding and tail, and the
        direct part.

        ``added``: contribution of the present sample so far, of its constant increment, to the
        state that ``rows`` select from; None: nothing.
        """
        size = np.abs(rows.picked) @ np.abs(rows.state)
        direct, constant = np.hstack(_direct(rows)), self._constant(rows, size, added)
        gains = self._summed(self._ways(rows), self.which, direct, rows.steps, size, constant)
        held = (np.abs(rows.picked @ rows.state) + ROUNDING * size + FLOOR) * UP
        return replace(gains, first=(held, *gains.first[1:]))

    def carried(
        self, rows: OutputRows, turned: Floats, added: Floats, count: int
    ) -> Iterator[Gains]:
        """Gains of y with y' = ``turned`` y + ``rows``, from 0, after 1, 2, ... ``count`` samples.

        Direct rows have signs, so contributions of successive samples may cancel.  There is no
        ``first``.
        """
        size = np.abs(rows.picked) @ np.abs(rows.state)
        ways, constant = self._ways(rows)[:, self.which], self._constant(rows, size, added)
        ways, every = ways.transpose(0, 2, 1), np.arange(len(self.which))
        direct = np.hstack([np.zeros((len(ways), self.n)), *_direct(rows)])
        total, times, power = ways, np.eye(len(ways)), np.eye(len(ways))
        spent = np.zeros(direct.shape)
        for _ in range(count):
            spent += np.abs(total).sum(axis=1)
            steps, parts = times @ rows.steps, (times @ size, times @ constant)
            seen = total.transpose(0, 2, 1)
            yield self._summed(seen, every, direct[:, self.n :], steps, *parts, (UP - 1) * spent)
            total = np.tensordot(turned, np.concatenate([direct[:, None], total], axis=1), 1)
            total[:, : ways.shape[1]] += ways
            power = turned @ power
            times = (times + np.abs(power)) * UP

    def _ways(self, rows: OutputRows) -> Floats:
        """Response of each row to each course, (rows, courses, samples)."""
        ways = rows.picked @ rows.state @ self._in_rows
        return np.asarray(ways.reshape(len(rows.picked), -1, len(self.course)))

    def _summed(
        self,
        ways: Floats,
        which: IntArray,
        direct: Floats,
        own: Floats,
        size: Floats,
        constant: Floats,
        more: Floats | float = 0.0,
    ) -> Gains:
        """Gains of responses, including ``direct`` ones and responses to the ``own`` sample's plant
        steps.

        ``which`` of the ``ways`` (rows, any, samples) belongs to each column; ``size`` (rows, n):
        sizes of the rows that the responses are sums of; ``more``: further rounding.
        """
        n, seen = self.n, np.abs(ways)
        slack = ROUNDING * size @ (self.powers @ self.inputs) + FLOOR + more
        reach = size @ self.scale
        tail = np.outer(reach, self.norms.sum(axis=0)) * self.damping / (1 - self.damping)
        start = self._started(ways, which, slack, reach)
        misled, before = (of(seen, which, slack, reach) for of in (self._misled, self._before))
        every, direct = (seen.sum(axis=2)[:, which] + slack + tail) * UP, np.abs(direct)
        steps = (every[:, :n] @ self.steps + own) * UP
        disc = np.hypot(seen[:, which[-ROBOT]], seen[:, which[1 - ROBOT]]).sum(axis=1)
        disc += (slack + tail)[:, -ROBOT : 2 - ROBOT].sum(axis=1)
        given = _with_disc(direct, np.hypot(direct[:, -ROBOT], direct[:, 1 - ROBOT]))
        by = (_with_disc(every[:, n:], disc * UP) + given) * UP
        first = np.full((len(ways), n), np.inf), given, own
        left = reach * self.damping * UP
        return Gains(by, steps, start, misled, before, first, left, constant)

    def _started(self, ways: Floats, which: IntArray, slack: Floats, reach: Floats) -> Floats:
        """Largest values after an initial sum of shares of the columns ``start``."""
        size = np.abs(self.start).sum(axis=1)
        if not size.any():
            return np.zeros(len(reach))
        rest = (
            slack[:, : self.n] + np.outer(reach, self.norms[:, : self.n].max(axis=0)) * self.damping
        )
        ways = ways[:, which[: self.n]].transpose(0, 2, 1)
        most = np.abs(ways @ self.start).sum(axis=2).max(axis=1)
        return np.asarray((most + rest @ size) * UP)

    def _constant(self, rows: OutputRows, size: Floats, added: Floats | None) -> Floats:
        """Largest values of the signed sums of equal increments in every sample."""
        now = np.zeros(rows.picked.shape[1]) if added is None else added
        each = rows.picked @ rows.state @ self.steady.T
        course = np.cumsum(np.hstack([(rows.picked @ now)[:, None], each]), axis=1)
        picked = np.abs(rows.picked) @ np.abs(now)
        slack = (UP - 1) * (np.abs(each).sum(axis=1) + picked) + FLOOR
        slack += ROUNDING * size @ self.steady_size
        rest = size @ self.scale * self.steady_norm * self.damping / (1 - self.damping)
        return np.asarray((np.abs(course).max(axis=1) + slack + rest) * UP)

    def _misled(self, seen: Floats, which: IntArray, slack: Floats, reach: Floats) -> Floats:
        """Largest values after a start at which only the estimated position is off."""
        if self.estimate is None:
            return np.zeros(len(reach))
        e = slice(self.estimate, self.estimate + 2)
        rest = slack[:, e] + np.outer(reach, self.norms[:, e].max(axis=0)) * self.damping
        size = np.hypot(*(seen[:, which[k]] for k in (e.start, e.stop - 1))).max(axis=1)
        return np.asarray((size + rest.sum(axis=1)) * UP)

    def _before(self, seen: Floats, which: IntArray, slack: Floats, reach: Floats) -> Floats:
        """Largest values after a start at which only one remembered velocity is off (2 columns)."""
        if self.old is None:
            return np.zeros((len(reach), COMMAND))
        v = slice(self.old, self.old + COMMAND)
        rest = slack[:, v] + np.outer(reach, self.norms[:, v].max(axis=0)) * self.damping
        return np.asarray((seen[:, which[v]].max(axis=2) + rest) * UP)


def _direct(rows: OutputRows) -> tuple[Floats, Floats, Floats, Floats]:
    """Direct effect of the inputs on rows, in the order of columns."""
    return rows.push, rows.law, rows.late, rows.measured


def _with_disc(columns: Floats, disc: Floats) -> Floats:
    """Columns with the disc's column inserted before that of measured e1."""
    return np.insert(columns, columns.shape[1] - ROBOT, disc, axis=1)


def stacked(each: Sequence[Gains]) -> Gains:
    """The rows of all, one below the other."""
    held, direct, own = map(np.concatenate, zip(*(item.first for item in each), strict=True))
    names = [item.name for item in fields(Gains) if item.name != "first"]
    rows = {name: np.concatenate([getattr(item, name) for item in each]) for name in names}
    return Gains(first=(held, direct, own), **rows)


def largest(each: Sequence[Gains]) -> Gains:
    """Entry-wise maximum."""
    by, steps, start, misled, before, left, constant = (
        np.max([getattr(item, name) for item in each], axis=0)
        for name in ("by", "steps", "start", "misled", "before", "left", "constant")
    )
    held, direct, own = (
        np.max(parts, axis=0) for parts in zip(*(item.first for item in each), strict=True)
    )
    return Gains(by, steps, start, misled, before, (held, direct, own), left, constant)
