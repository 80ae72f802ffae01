"""The corridor: a box that the loop cannot leave, from a verified fixed point.

With g the peak gains of the linear loop, dbar the inputs and nu(X) the linearisation remainder on
the box |x| <= X,

    g(inputs) dbar + g(remainders) nu(X) + start <= X      in every component             (*)

and no limit acts on that box: then a loop that starts within ``start`` of its reference has |x| <=
X at all plant steps (ledger: corridor.induction).  The left side without start, evaluated at X and
then at its own result, bounds x in the long run.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from math import cos, pi

import numpy as np

from wmr_ctrl.control.setup import Setup
from wmr_ctrl.core.fields.units import length
from wmr_ctrl.theory.checks.error_coordinates import COMMAND, ROBOT, Floats

from .enclosure import OpenBoxError, upper
from .gains import DIRECTIONS, PAIRS, loop_gains
from .inputs import (
    Inputs,
    NoCorridorError,
    bounded_inputs,
    check_covered,
    check_size,
    conditions,
    steady_motion,
)
from .late_guard import counts_late, sizes_of_forces
from .loop import NOTHING, UP, SampledLoop
from .overlap import ALONE, Overlap, jitter_overlap, ramp_overlap, ramps
from .peaks import Peaks, Tube, reference_gap
from .reckoning import Reckoning
from .responses import Gains
from .sample import SlowLoopError

ROUNDS = 60
"""Rounds of the fixed point."""
CLOSE = 1e-7
"""Relative change at which they end."""
INFLATED = 1e-6
"""Share that each round adds."""
LEAP = 20
"""Rounds after which their limit is guessed."""
SETTLING = 20
"""Rounds by which the long run's box comes down; each one is a bound."""
FAR = 30.0
"""Growth over the linear loop at which the search ends."""
MORE = 10.0
"""Multiple of FAR with jitter."""
NEAR = 1e-3
"""Share of the largest deviation from which on FAR counts."""
DUST = 1e-9
"""Deviation that is allowed to any component."""


class Certifier:
    """A law's loop on its reference with its gains, for inputs of any size."""

    def __init__(
        self, setup: Setup, overlap: Overlap | None = None, sizes: Floats | None = None
    ) -> None:
        """Build it; raises NoCorridorError if the loop is not covered.

        ``overlap``, and ``sizes`` of forces for a guard that takes late commands into account, are
        given if known.
        """
        check_covered(setup)
        if overlap is None:
            overlap = _overlap(setup)
        if sizes is None:
            sizes = _force_sizes(setup, overlap)
        self.inputs, v_d = bounded_inputs(setup), steady_motion(setup)
        self.loop = loop = SampledLoop(setup, v_d, partial(conditions, setup), overlap, sizes)
        check_size(loop)
        self.reckoning = Reckoning(loop, self.inputs.missing)
        shown, moved = loop.law.value(), loop.step.value()
        self.added = np.array(
            [float((a - x).mid()) for a, x in zip(moved, loop.step.at, strict=False)]
        )
        try:
            self.start = np.diag((*setup.scenario.corridor.start, *[0.0] * (len(loop.at) - 3)))
            self.gains = loop_gains(loop, self.start, self.added, self.reckoning)
        except SlowLoopError as error:
            raise NoCorridorError(f"the loop is unstable, or takes too long: {error}") from error
        self.level = np.array([upper(item) for item in shown[-loop.count :]])
        self.most = np.array([float(item.lower()) * (1 - 2**-50) for item in loop.most])
        for place, item in enumerate(loop.conditions):
            off = 0.0 if item.measured is None else float(self.inputs.velocity[item.measured])
            if off >= self.most[place]:
                most = f"{item.name} may be {self.most[place]:.3g} at most"
                raise NoCorridorError(f"{most}, and the measured velocity is off by {off:.3g}")
            self.most[place] = (self.most[place] - off * UP) * (1 - 2**-50)
        stays = [(a - x) for a, x in zip(shown, loop.remains, strict=False)]
        self.law_rest = np.array([*map(upper, stays), *np.zeros(loop.count)])
        steady = zip(moved, loop.step.at, self.added.tolist(), strict=False)
        self.step_rest = np.array([upper(a - x - more) for a, x, more in steady])
        self.by_body = np.array([[upper(x) for x in row[-COMMAND:]] for row in loop.step.slopes()])
        self.step_rest[:2] += reference_gap(v_d, setup.scenario.clock.plant)
        self.begun, self.old = self._reckoning_gap(), self._old_velocity()

    def _reckoning_gap(self) -> float:
        """Error [m] of dead reckoning over a sample on the reference."""
        share, loop = self.loop.setup.scenario.sensor.correction, self.loop
        if not loop.filter:
            return 0.0
        place = COMMAND + loop.memory - loop.filter
        period = self.loop.setup.scenario.clock.control
        gap = reference_gap(loop.step.at[3:ROBOT], period)
        self.law_rest[place : place + 2] += gap
        return float(self.law_rest[place : place + 2].sum() / (1 - share) * UP)

    def _old_velocity(self) -> tuple[Floats, Floats]:
        """Errors (2) of an observer's remembered velocity for which its force estimate is 0.

        The first is for a measured velocity with error 1, the second for a force estimate of 1.
        """
        if self.loop.observed is None:
            return np.zeros(COMMAND), np.zeros(COMMAND)
        force, old = self.loop.observed
        slopes = self.loop.law.slopes()
        rows = [(slopes[COMMAND + force + i], i) for i in range(COMMAND)]
        measured = np.array([upper(row[ROBOT - COMMAND + i]) for row, i in rows])
        own = [float(abs(row[ROBOT + old + i]).lower()) * (1 - 2**-50) for row, i in rows]
        share = np.array([1 / item * UP if item > 0 else 0.0 for item in own])
        return measured * share * UP, share

    def _before(self, inputs: Inputs, law: Floats) -> Floats:
        """Effective error of the velocity (2) that an observer remembers at the start.

        Its first force estimate is 0 for any error of the measured velocity.
        """
        if self.loop.observed is None or not inputs.velocity.any():
            return np.zeros(COMMAND)
        by_measured, by_force = self.old
        place = COMMAND + self.loop.observed[0]
        rest = law[place : place + COMMAND]
        return np.asarray((by_measured * inputs.velocity + by_force * rest) * UP)

    def tube(self, inputs: Inputs) -> Tube:
        """The closed box for some inputs; NoCorridorError if none closes or a limit acts."""
        linear = self._tube(self.linear(inputs))
        self._check(linear, ", which is so for the linear loop already")
        try:
            tube = self._closed(inputs)
        except OpenBoxError as error:
            text = f"the box that it needs grows without end from {length(linear.position)} on"
            raise NoCorridorError(f"{text} ({error})") from error
        self._check(tube)
        return tube

    def _check(self, tube: Tube, more: str = "") -> None:
        """Raise NoCorridorError if a condition is violated."""
        if not tube.share <= 1:
            place = [item.name for item in self.loop.conditions].index(tube.binding)
            reach = self.level[place] + tube.peaks.law[-self.loop.count :][place]
            text = f"{tube.binding} may reach {reach:.3g} of {self.most[place]:.3g}{more}"
            raise NoCorridorError(text)

    def linear(self, inputs: Inputs) -> Peaks:
        """Peaks of the linear loop, including the residuals on the reference."""
        rest, nothing = self._rest(inputs), np.zeros(COMMAND)
        return self._peaks(inputs, rest, self._law_rest(inputs, nothing), nothing)

    def _law_rest(self, inputs: Inputs, commands: Floats) -> Floats:
        """Errors of the law's outputs on the reference, if commands with deviations up to
        ``commands`` (2) act differently than sent.
        """
        rest, level = self.law_rest.copy(), np.abs(self.loop.remains[:COMMAND])
        rest[:COMMAND] += inputs.misheard(level - commands)
        return rest

    def _rest(self, inputs: Inputs) -> Floats:
        """Increment of a plant step on the reference, including the effect of another mass."""
        return np.asarray((self.step_rest + self.by_body @ inputs.body) * UP)

    @property
    def linear_position(self) -> float:
        """Largest distance [m] for the linear loop alone."""
        return self._tube(self.linear(self.inputs)).position

    def _closed(self, inputs: Inputs) -> Tube:
        peaks = first = self.linear(inputs)
        begun, scale = self.image(inputs, first) if inputs.missing else first, self.gains.scale
        near = NEAR * scale[:ROBOT] * float((begun.fast[:ROBOT] / scale[:ROBOT]).max())
        far = FAR * (MORE if self.loop.overlap.steps else 1) * np.maximum(begun.fast[:ROBOT], near)
        for k in range(ROUNDS):
            before, peaks = peaks, self.image(inputs, peaks).times(1 + INFLATED)
            if (np.abs(peaks.every - before.every) <= CLOSE * peaks.every).all():
                break
            if k % LEAP == LEAP - 1:
                peaks = self.image(inputs, peaks).limit(before, peaks).times(1 + INFLATED)
            if (peaks.fast[:ROBOT] > far + DUST).any():
                raise self._grows(first)
        if not self.image(inputs, peaks).within(peaks):
            raise self._grows(first)
        late = peaks
        starts = self.gains.fast.start, self.gains.fast.misled, inputs.velocity
        off = any(part.any() for part in starts)
        for _ in range(SETTLING if off else 0):
            late = self.image(inputs, late, started=False)
        return replace(self._tube(peaks), position_late=self.position(late))

    def position(self, peaks: Peaks) -> float:
        """Distance [m] of the robot's place on the path, within these deviations."""
        nz = len(self.loop.names)
        ahead = peaks.fast[nz : nz + DIRECTIONS].max()
        return float(ahead / cos(pi / (2 * DIRECTIONS)) * UP)

    def _tube(self, peaks: Peaks) -> Tube:
        shares = (self.level + peaks.law[-self.loop.count :]) / self.most * UP
        shares = np.where(self.most > 0, shares, np.inf)
        inner = np.array([item.inner for item in self.loop.conditions])
        broken = (shares[inner] > 1).any()
        worst = int(np.where(inner == broken, shares, -1.0).argmax())
        position = self.position(peaks)
        share = float(shares[worst]) if self.most[worst] > 0 else float("inf")
        name = self.loop.conditions[worst].name
        return Tube(peaks, position, position, float(peaks.fast[2]), name, share)

    def image(self, inputs: Inputs, peaks: Peaks, *, started: bool = True) -> Peaks:
        """Left side of (*), with the start or after its effect has decayed."""
        inputs = self._reckoned(inputs, peaks)
        return self._peaks(
            inputs, *self._added(inputs, peaks), self._changes(inputs, peaks), started
        )

    def _reckoned(self, inputs: Inputs, peaks: Peaks) -> Inputs:
        """Inputs, enlarged by the dead-reckoning errors of the samples without a pose."""
        measured = peaks.fast[:ROBOT] + np.array([0.0, 0.0, 0.0, *inputs.velocity])
        return self.reckoning.added(inputs, measured, peaks.fast) if inputs.missing else inputs

    def _changes(self, inputs: Inputs, peaks: Peaks) -> Floats:
        """Largest changes (2) from one acting command to the next."""
        if not self.loop.overlap.steps:
            return np.zeros(COMMAND)
        heard = 2 * inputs.misheard(np.zeros(COMMAND))
        return np.asarray((self.level[-COMMAND:] + peaks.law[-COMMAND:] + heard) * UP)

    def settled(self, inputs: Inputs, peaks: Peaks) -> Peaks:
        """States after K samples within ``peaks``, K as in `LoopGains` (ledger: corridor.latch)."""
        forced, gains = self.image(inputs, peaks, started=False), self.gains
        norm = float((peaks.state / gains.scale).max()) * UP
        parts = zip((forced.fast, forced.state, forced.law), self._three, strict=True)
        return Peaks(*((part + item.left * norm) * UP for part, item in parts))

    def next_sample(self, inputs: Inputs, state: Floats, peaks: Peaks) -> Peaks:
        """Sizes over one sample from a state within ``state``, while all deviations are within
        ``peaks``.
        """
        inputs = self._reckoned(inputs, peaks)
        step, law = self._added(inputs, peaks)
        given = self._given(inputs, law, self._changes(inputs, peaks))
        step = step + np.abs(self.added)

        def of(gains: Gains) -> Floats:
            held, direct, own = gains.first
            return np.asarray((held @ state + direct @ given + own @ step) * UP)

        return Peaks(*map(of, self._three))

    def share(self, peaks: Peaks) -> float:
        """Largest use of a condition within these deviations; beyond 1 it is violated."""
        return self._tube(peaks).share

    @property
    def _three(self) -> tuple[Gains, Gains, Gains]:
        return self.gains.fast, self.gains.state, self.gains.law

    def _added(self, inputs: Inputs, peaks: Peaks) -> tuple[Floats, Floats]:
        """Remainders of a plant step and of the law within these deviations."""
        step, law = self._remainders(inputs, peaks)
        return (
            (self._rest(inputs) + step.sum(axis=(1, 2))) * UP,
            (self._law_rest(inputs, peaks.law[:COMMAND]) + law.sum(axis=(1, 2))) * UP,
        )

    def _given(self, inputs: Inputs, law: Floats, changes: Floats) -> Floats:
        """Inputs of the gains, in the order of their columns.

        These are pushes, the law's remainders, overlap errors of commands that change by
        ``changes``, and measurement errors.
        """
        error = np.array([inputs.pose, *inputs.reckoned, *inputs.velocity])
        late = (self.loop.overlap.off * changes * UP).ravel()
        return np.concatenate((inputs.push, law, late, error))

    def _remainders(self, inputs: Inputs, peaks: Peaks) -> tuple[Floats, Floats]:
        """Remainders of the robot's step and of the law, by pairs of variables."""
        loop, nz = self.loop, len(self.loop.names)
        queue, memory = COMMAND * loop.queue, loop.memory
        pairs = np.outer(peaks.fast[:ROBOT], peaks.fast[:ROBOT])
        sums = slice(nz + DIRECTIONS, nz + DIRECTIONS + 2 * len(PAIRS))
        both = peaks.fast[sums].reshape(-1, 2).max(axis=1) ** 2 / (4 * self.gains.ratios)
        for (a, b), most in zip(PAIRS, both, strict=True):
            pairs[a, b] = pairs[b, a] = min(pairs[a, b], most)
        error = inputs.measured
        moved = np.concatenate((peaks.fast[:nz], peaks.law[:COMMAND], inputs.push, inputs.body))
        state = np.split(peaks.state, [nz, nz + queue, nz + queue + memory])
        seen = np.concatenate((peaks.fast[:ROBOT] + error, state[2], state[1], state[3]))
        by_step, by_law = np.outer(moved, moved), np.outer(seen, seen)
        by_step[:ROBOT, :ROBOT] = pairs
        mixed = np.outer(peaks.fast[:ROBOT], error)
        by_law[:ROBOT, :ROBOT] = pairs + mixed + mixed.T + np.outer(error, error)
        return loop.step.remainders(by_step * UP), loop.law.remainders(by_law * UP)

    def _peaks(
        self, inputs: Inputs, step: Floats, law: Floats, changes: Floats, started: bool = True
    ) -> Peaks:
        given, before = self._given(inputs, law, changes), self._before(inputs, law)

        def of(gains: Gains) -> Floats:
            forced = gains.by @ given + gains.steps @ step + gains.constant
            start = gains.start + gains.misled * (inputs.pose + self.begun) + gains.before @ before
            return np.asarray((forced + started * start) * UP)

        return Peaks(*map(of, self._three))

    def _grows(self, peaks: Peaks) -> NoCorridorError:
        """Error to raise if products of deviations outgrow the loop's corrections."""
        return NoCorridorError(
            "products of deviations may grow as large as what the loop corrects, beyond the "
            f"{length(self.position(peaks))} that the linear loop leaves"
        )


def _overlap(setup: Setup) -> Overlap:
    """The overlap of a setup's commands; for a ramp, slightly larger than the linear loop needs."""
    scenario = setup.scenario
    if not setup.takes_velocity:
        return jitter_overlap(scenario)
    if not ramps(scenario):
        return ALONE
    watched = Overlap(np.zeros(1), np.zeros((1, COMMAND)), ALONE.most)
    free = Certifier(setup, watched)
    return ramp_overlap(scenario, free.linear(free.inputs).law[-COMMAND:])


def _force_sizes(setup: Setup, overlap: Overlap) -> Floats:
    """Force sizes (2) for a guard with late commands, slightly above those of the linear loop."""
    if not counts_late(setup):
        return NOTHING
    free = Certifier(setup, overlap, NOTHING)
    most = np.abs(free.loop.remains[:COMMAND]) + free.linear(free.inputs).law[:COMMAND]
    return sizes_of_forces(setup, most)
