"""The corridor: a box that the loop cannot leave, closed by a fixed point that is checked.

With g the peak gains of the linear loop, dbar the inputs and nu(X) what the linear part leaves of
the graphs on the box |x| <= X,

    g(inputs) dbar + g(remainders) nu(X) <= X      in every component                     (*)

and nothing cuts on that box: then a loop that starts on its reference has |x| <= X at all plant
steps (ledger: corridor.induction).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from math import cos, pi

import numpy as np

from wmr_ctrl.checks.world import COMMAND, ROBOT, Floats
from wmr_ctrl.control.setup import Setup
from wmr_ctrl.corridor.answer import Corridor
from wmr_ctrl.corridor.enclosure import OpenBoxError, upper
from wmr_ctrl.corridor.gains import DIRECTIONS, PAIRS, Gains, SlowLoopError, loop_gains
from wmr_ctrl.corridor.inputs import (
    Inputs,
    NoCorridorError,
    bounded_inputs,
    conditions,
    steady_motion,
)
from wmr_ctrl.corridor.loop import UP, SampledLoop
from wmr_ctrl.laws.registry import LAWS

ROUNDS, CLOSE, INFLATED, LEAST = 60, 1e-7, 1e-6, 1e-15
"""Rounds of the fixed point, the change at which they end, and what is added before the check."""
FAR = 30.0
"""Growth over the linear loop with which the fixed point counts as lost."""
SHARES = 12
"""Halvings in the search for the inputs with which a corridor closes."""
WORDS = ("e1", "e2", "e3", "(v1 - v1_d)", "(w - w_d)")


@dataclass(frozen=True)
class Peaks:
    """Largest deviations: fast state with all its rows, state at samples, outputs of the law."""

    fast: Floats
    state: Floats
    law: Floats

    @property
    def every(self) -> Floats:
        """All in one vector."""
        return np.concatenate((self.fast, self.state, self.law))


@dataclass(frozen=True)
class Tube:
    """A closed box: ``position`` [m], ``heading`` [rad], and the condition that is used most."""

    peaks: Peaks
    position: float
    heading: float
    binding: str
    share: float


class Certifier:
    """A law's loop on its reference with its gains, for inputs of any size."""

    def __init__(self, setup: Setup) -> None:
        """NoCorridorError where the loop is not covered."""
        if setup.takes_velocity:
            raise NoCorridorError("a base that takes velocities is not covered")
        if setup.control_law.inside is None:
            able = " and ".join(name for name, law in LAWS.items() if law.inside is not None)
            raise NoCorridorError(f"of the laws {able} have one, away from their limits")
        self.inputs, v_d = bounded_inputs(setup), steady_motion(setup)
        self.loop = loop = SampledLoop(setup, v_d, partial(conditions, setup))
        try:
            self.gains = loop_gains(loop)
        except SlowLoopError as error:
            raise NoCorridorError(f"the loop is unstable, or takes too long: {error}") from error
        shown, moved = loop.law.value(), loop.step.value()
        self.level = np.array([upper(item) for item in shown[-loop.count :]])
        self.most = np.array([float(item.lower()) * (1 - 2**-50) for item in loop.most])
        stays = [(a - x) for a, x in zip(shown, loop.remains, strict=False)]
        self.law_rest = np.array([*map(upper, stays), *np.zeros(loop.count)])
        self.step_rest = np.array([upper(a - x) for a, x in zip(moved, loop.step.at, strict=False)])
        self.step_rest[:2] += reference_gap(v_d, setup.scenario.clock.plant)

    def tube(self, inputs: Inputs) -> Tube:
        """The closed box for some inputs; NoCorridorError where none closes or something cuts."""
        try:
            tube = self._closed(inputs)
        except OpenBoxError as error:
            raise NoCorridorError(f"the box that it needs is too large: {error}") from error
        if tube.share > 1:
            name = tube.binding
            place = [item.name for item in self.loop.conditions].index(name)
            reach = self.level[place] + tube.peaks.law[-self.loop.count :][place]
            raise NoCorridorError(f"{name} may reach {reach:.3g} of {self.most[place]:.3g}")
        return tube

    def linear(self, inputs: Inputs) -> Peaks:
        """Peaks of the linear loop, with what does not vanish on the reference."""
        return self._peaks(inputs, self.step_rest, self.law_rest)

    @property
    def linear_position(self) -> float:
        """Distance [m] that the linear loop alone can be brought to."""
        return self._tube(self.linear(self.inputs)).position

    def _closed(self, inputs: Inputs) -> Tube:
        peaks = first = self.linear(inputs)
        for _ in range(ROUNDS):
            following = self._image(inputs, peaks)
            change = np.abs(following.every - peaks.every) <= CLOSE * following.every + LEAST
            peaks = following
            if change.all():
                break
            if (peaks.fast[:ROBOT] > FAR * first.fast[:ROBOT]).any():
                raise NoCorridorError(self._blamed(inputs, first))
        grown = Peaks(
            *(part * (1 + INFLATED) + LEAST for part in (peaks.fast, peaks.state, peaks.law))
        )
        if not (self._image(inputs, grown).every <= grown.every).all():
            raise NoCorridorError(self._blamed(inputs, first))
        return self._tube(grown)

    def _tube(self, peaks: Peaks) -> Tube:
        shares = (self.level + peaks.law[-self.loop.count :]) / self.most * UP
        worst = int(np.where(self.most > 0, shares, np.inf).argmax())
        nz = len(self.loop.names)
        position = peaks.fast[nz : nz + DIRECTIONS].max() / cos(pi / (2 * DIRECTIONS)) * UP
        share = float(shares[worst]) if self.most[worst] > 0 else float("inf")
        name = self.loop.conditions[worst].name
        return Tube(peaks, float(position), float(peaks.fast[2]), name, share)

    def _image(self, inputs: Inputs, peaks: Peaks) -> Peaks:
        """Left side of (*)."""
        step, law = self._remainders(inputs, peaks)
        return self._peaks(
            inputs,
            (self.step_rest + step.sum(axis=(1, 2))) * UP,
            (self.law_rest + law.sum(axis=(1, 2))) * UP,
        )

    def _remainders(self, inputs: Inputs, peaks: Peaks) -> tuple[Floats, Floats]:
        """What the linear part leaves of the robot's step and of the law, by pairs of variables."""
        loop, nz = self.loop, len(self.loop.names)
        queue, memory = COMMAND * loop.queue, loop.memory
        pairs = np.outer(peaks.fast[:ROBOT], peaks.fast[:ROBOT])
        both = peaks.fast[nz + DIRECTIONS :].reshape(-1, 2).max(axis=1) ** 2 / (
            4 * self.gains.ratios
        )
        for (a, b), most in zip(PAIRS, both, strict=True):
            pairs[a, b] = pairs[b, a] = min(pairs[a, b], most)
        error = np.array([inputs.pose, inputs.pose, 0.0, *inputs.velocity])
        moved = np.concatenate((peaks.fast[:nz], peaks.law[:COMMAND], inputs.push))
        state = np.split(peaks.state, [nz, nz + queue, nz + queue + memory])
        seen = np.concatenate((peaks.fast[:ROBOT] + error, state[2], state[1], state[3]))
        by_step, by_law = np.outer(moved, moved), np.outer(seen, seen)
        by_step[:ROBOT, :ROBOT] = pairs
        mixed = np.outer(peaks.fast[:ROBOT], error)
        by_law[:ROBOT, :ROBOT] = pairs + mixed + mixed.T + np.outer(error, error)
        return loop.step.remainders(by_step * UP), loop.law.remainders(by_law * UP)

    def _peaks(self, inputs: Inputs, step: Floats, law: Floats) -> Peaks:
        error = np.array([inputs.pose, 0.0, 0.0, *inputs.velocity])
        given = np.concatenate((inputs.push, law, error))

        def of(gains: Gains) -> Floats:
            return np.asarray((gains.by @ given + gains.steps @ step) * UP)

        return Peaks(of(self.gains.fast), of(self.gains.state), of(self.gains.law))

    def _blamed(self, inputs: Inputs, peaks: Peaks) -> str:
        """The product of two deviations that adds most to the distance, in words."""
        step, law = self._remainders(inputs, peaks)
        rows = slice(len(self.loop.names), len(self.loop.names) + DIRECTIONS)
        by = self.gains.fast.by[rows, COMMAND : COMMAND + len(law)].max(axis=0)
        own = self.gains.fast.steps[rows].max(axis=0)
        added = np.einsum("i,ijk->jk", own, step)[:ROBOT, :ROBOT]
        added = added + np.einsum("i,ijk->jk", by, law)[:ROBOT, :ROBOT]
        a, b = np.unravel_index((added + added.T).argmax(), added.shape)
        term = f"{WORDS[a]}^2" if a == b else f"{WORDS[min(a, b)]} {WORDS[max(a, b)]}"
        return f"{term} may grow as large as what the loop corrects"


def reference_gap(v_d: Floats, step: float) -> float:
    """Distance [m] between a circle's arc of one plant step and its sum by Simpson's rule."""
    return abs(float(v_d[0])) * float(v_d[1]) ** 4 * step**5 / 1000


def certified(setup: Setup) -> Corridor:
    """The Corridor of a setup, or why it has none."""
    until = min((item.t for item in setup.scenario.changes), default=None)
    try:
        certifier = Certifier(setup)
    except NoCorridorError as error:
        return Corridor(setup.name, until=until, refused=str(error))
    inputs = certifier.inputs
    first, second = map(float, inputs.velocity)
    known = partial(
        Corridor, setup.name, until=until, push=float(max(inputs.push)), pose=inputs.pose,
        velocity=(first, second), mass=setup.scenario.robot.m,
    )  # fmt: skip
    try:
        tube = certifier.tube(inputs)
    except NoCorridorError as error:
        return known(refused=str(error), closes=_closing(certifier))
    return known(
        position=tube.position, heading=tube.heading, binding=tube.binding, share=tube.share,
        linear=certifier.linear_position,
    )  # fmt: skip


def _closing(certifier: Certifier) -> float | None:
    """Largest share of the inputs, of those tried, with which there is a corridor."""
    low, high = 0.0, 1.0
    for _ in range(SHARES):
        middle = (low + high) / 2
        try:
            certifier.tube(certifier.inputs.scaled(middle))
            low = middle
        except NoCorridorError:
            high = middle
    return low or None
