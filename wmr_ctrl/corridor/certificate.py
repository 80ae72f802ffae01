"""The corridor: a box that the loop cannot leave, closed by a fixed point that is checked.

With g the peak gains of the linear loop, dbar the inputs and nu(X) what the linear part leaves of
the graphs on the box |x| <= X,

    g(inputs) dbar + g(remainders) nu(X) + start <= X      in every component             (*)

and nothing cuts on that box: then a loop that starts on its reference, but for what ``start``
allows, has |x| <= X at all plant steps (ledger: corridor.induction).  The left side without start,
taken of X and then of itself, bounds what is left of x in the long run.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from math import cos, pi

import numpy as np

from wmr_ctrl.checks.world import COMMAND, ROBOT, Floats
from wmr_ctrl.control.setup import Setup, settle
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
from wmr_ctrl.corridor.loop import BODY, UP, SampledLoop
from wmr_ctrl.guard.bounds import mass_range
from wmr_ctrl.laws.registry import LAWS
from wmr_ctrl.scenario import override

ROUNDS, CLOSE, INFLATED, LEAST = 60, 1e-7, 1e-6, 1e-15
"""Rounds of the fixed point, the change at which they end, and what is added before the check."""
SETTLING = 20
"""Rounds by which the long run's box comes down; each one is a bound."""
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

    def times(self, factor: float, more: float = LEAST) -> Peaks:
        """So many times as large, and some more."""
        return Peaks(*(part * factor + more for part in (self.fast, self.state, self.law)))

    def within(self, other: Peaks) -> bool:
        """True where no element is larger than another's."""
        return bool((self.every <= other.every).all())


@dataclass(frozen=True)
class Tube:
    """A closed box: ``position`` [m], ``heading`` [rad], and the condition that is used most.

    ``position_late`` [m]: what the position comes down to in the long run.
    """

    peaks: Peaks
    position: float
    position_late: float
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
            self.gains = loop_gains(loop, np.array(setup.scenario.corridor.start))
        except SlowLoopError as error:
            raise NoCorridorError(f"the loop is unstable, or takes too long: {error}") from error
        shown, moved = loop.law.value(), loop.step.value()
        self.level = np.array([upper(item) for item in shown[-loop.count :]])
        self.most = np.array([float(item.lower()) * (1 - 2**-50) for item in loop.most])
        stays = [(a - x) for a, x in zip(shown, loop.remains, strict=False)]
        self.law_rest = np.array([*map(upper, stays), *np.zeros(loop.count)])
        self.step_rest = np.array([upper(a - x) for a, x in zip(moved, loop.step.at, strict=False)])
        self.by_body = np.array([[upper(x) for x in row[-COMMAND:]] for row in loop.step.slopes()])
        self.step_rest[:2] += reference_gap(v_d, setup.scenario.clock.plant)
        self.begun = self._reckoning_gap()

    def _reckoning_gap(self) -> float:
        """Distance [m] by which dead reckoning over a sample misses the reference."""
        share, loop = self.loop.setup.scenario.sensor.correction, self.loop
        if not loop.filter:
            return 0.0
        place = COMMAND + loop.memory - loop.filter
        period = self.loop.setup.scenario.clock.control
        gap = reference_gap(loop.step.at[3:ROBOT], period)
        self.law_rest[place : place + 2] += gap
        return float(self.law_rest[place : place + 2].sum() / (1 - share) * UP)

    def tube(self, inputs: Inputs) -> Tube:
        """The closed box for some inputs; NoCorridorError where none closes or something cuts."""
        self._check(self._tube(self.linear(inputs)), ", which is so for the linear loop already")
        try:
            tube = self._closed(inputs)
        except OpenBoxError as error:
            raise NoCorridorError(f"the box that it needs grows without end ({error})") from error
        self._check(tube)
        return tube

    def _check(self, tube: Tube, more: str = "") -> None:
        """NoCorridorError where a condition is broken."""
        if tube.share > 1:
            place = [item.name for item in self.loop.conditions].index(tube.binding)
            reach = self.level[place] + tube.peaks.law[-self.loop.count :][place]
            text = f"{tube.binding} may reach {reach:.3g} of {self.most[place]:.3g}{more}"
            raise NoCorridorError(text)

    def linear(self, inputs: Inputs) -> Peaks:
        """Peaks of the linear loop, with what does not vanish on the reference."""
        return self._peaks(inputs, self._rest(inputs), self.law_rest)

    def _rest(self, inputs: Inputs) -> Floats:
        """What a plant step adds on the reference, with what another mass makes of its forces."""
        return np.asarray((self.step_rest + self.by_body @ inputs.body) * UP)

    @property
    def linear_position(self) -> float:
        """Distance [m] that the linear loop alone can be brought to."""
        return self._tube(self.linear(self.inputs)).position

    def _closed(self, inputs: Inputs) -> Tube:
        peaks = first = self.linear(inputs)
        for _ in range(ROUNDS):
            following = self.image(inputs, peaks)
            change = np.abs(following.every - peaks.every) <= CLOSE * following.every + LEAST
            peaks = following
            if change.all():
                break
            if (peaks.fast[:ROBOT] > FAR * first.fast[:ROBOT]).any():
                raise NoCorridorError(self._blamed(inputs, first))
        grown = peaks.times(1 + INFLATED)
        if not self.image(inputs, grown).within(grown):
            raise NoCorridorError(self._blamed(inputs, first))
        late = grown
        off = self.gains.fast.start.any() or self.gains.fast.misled.any()
        for _ in range(SETTLING if off else 0):
            late = self.image(inputs, late, started=False)
        return replace(self._tube(grown), position_late=self.position(late))

    def position(self, peaks: Peaks) -> float:
        """Distance [m] from the place on the path of anything within these deviations."""
        nz = len(self.loop.names)
        ahead = peaks.fast[nz : nz + DIRECTIONS].max()
        return float(ahead / cos(pi / (2 * DIRECTIONS)) * UP)

    def _tube(self, peaks: Peaks) -> Tube:
        shares = (self.level + peaks.law[-self.loop.count :]) / self.most * UP
        worst = int(np.where(self.most > 0, shares, np.inf).argmax())
        position = self.position(peaks)
        share = float(shares[worst]) if self.most[worst] > 0 else float("inf")
        name = self.loop.conditions[worst].name
        return Tube(peaks, position, position, float(peaks.fast[2]), name, share)

    def image(self, inputs: Inputs, peaks: Peaks, *, started: bool = True) -> Peaks:
        """Left side of (*), with the start or after it has been forgotten."""
        return self._peaks(inputs, *self._added(inputs, peaks), started)

    def settled(self, inputs: Inputs, peaks: Peaks) -> Peaks:
        """What follows K samples within ``peaks``, K as in `LoopGains` (ledger: corridor.latch)."""
        forced, gains = self.image(inputs, peaks, started=False), self.gains
        norm = float((peaks.state / gains.scale).max()) * UP
        parts = zip((forced.fast, forced.state, forced.law), self._three, strict=True)
        return Peaks(*((part + item.left * norm) * UP for part, item in parts))

    def next_sample(self, inputs: Inputs, state: Floats, peaks: Peaks) -> Peaks:
        """From a state within ``state``, over one sample in which nothing leaves ``peaks``."""
        step, law = self._added(inputs, peaks)
        given = self._given(inputs, law)

        def of(gains: Gains) -> Floats:
            held, direct, own = gains.first
            return np.asarray((held @ state + direct @ given + own @ step) * UP)

        return Peaks(*map(of, self._three))

    def share(self, peaks: Peaks) -> float:
        """Of the condition that is used most within these deviations, 1 where it is broken."""
        return self._tube(peaks).share

    @property
    def _three(self) -> tuple[Gains, Gains, Gains]:
        return self.gains.fast, self.gains.state, self.gains.law

    def _added(self, inputs: Inputs, peaks: Peaks) -> tuple[Floats, Floats]:
        """What a plant step and the law add to their linear parts within these deviations."""
        step, law = self._remainders(inputs, peaks)
        return (
            (self._rest(inputs) + step.sum(axis=(1, 2))) * UP,
            (self.law_rest + law.sum(axis=(1, 2))) * UP,
        )

    @staticmethod
    def _given(inputs: Inputs, law: Floats) -> Floats:
        """Inputs and what the law adds, in the order of the gains' columns."""
        error = np.array([inputs.pose, 0.0, 0.0, *inputs.velocity])
        return np.concatenate((inputs.push, law, error))

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
        moved = np.concatenate((peaks.fast[:nz], peaks.law[:COMMAND], inputs.push, inputs.body))
        state = np.split(peaks.state, [nz, nz + queue, nz + queue + memory])
        seen = np.concatenate((peaks.fast[:ROBOT] + error, state[2], state[1], state[3]))
        by_step, by_law = np.outer(moved, moved), np.outer(seen, seen)
        by_step[:ROBOT, :ROBOT] = pairs
        mixed = np.outer(peaks.fast[:ROBOT], error)
        by_law[:ROBOT, :ROBOT] = pairs + mixed + mixed.T + np.outer(error, error)
        return loop.step.remainders(by_step * UP), loop.law.remainders(by_law * UP)

    def _peaks(self, inputs: Inputs, step: Floats, law: Floats, started: bool = True) -> Peaks:
        given = self._given(inputs, law)

        def of(gains: Gains) -> Floats:
            forced = gains.by @ given + gains.steps @ step
            start = gains.start + gains.misled * (inputs.pose + self.begun)
            return np.asarray((forced + started * start) * UP)

        return Peaks(*map(of, self._three))

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


def certified(setup: Setup, *, closing: bool = True) -> Corridor:
    """The Corridor of a setup, or why it has none; with cells, of all masses in them.

    ``closing``: where there is none, search for the share of inputs with which there is one.
    """
    until = min((item.t for item in setup.scenario.changes), default=None)
    known = Corridor(setup.name, until=until, mass=setup.scenario.robot.m)
    tubes, linear, cells = list[Tube](), 0.0, mass_cells(setup)
    try:
        for cell, widths in cells:
            certifier = Certifier(cell)
            inputs = replace(certifier.inputs, body=widths)
            if tubes and float(max(inputs.push)) != known.push:
                raise NoCorridorError("an effect's bound changes with the mass: take cells = 0")
            first, second = map(float, inputs.velocity)
            known = replace(
                known, push=float(max(inputs.push)), pose=inputs.pose, velocity=(first, second)
            )
            linear = max(linear, certifier.linear_position)
            known = replace(known, linear=linear)
            tubes.append(_certified_tube(certifier, inputs, closing))
    except NoCorridorError as error:
        here = f"with M = {cell.scenario.robot.m:.3g} kg " if len(cells) > 1 else ""
        return replace(known, refused=f"{here}{error}", closes=error.closes)
    worst = max(tubes, key=lambda tube: tube.share)
    return replace(
        known,
        position=max(tube.position for tube in tubes),
        position_late=max(tube.position_late for tube in tubes),
        start=setup.scenario.corridor.start,
        heading=max(tube.heading for tube in tubes),
        binding=worst.binding,
        share=worst.share,
        masses=tuple(mass_range(setup.guard, i) for i in (0, 1)) if len(cells) > 1 else None,
    )


def mass_cells(setup: Setup) -> list[tuple[Setup, Floats]]:
    """The setup by cells of mass and inertia, each with its half-widths [kg, kg m2].

    One of no width without ``corridor.cells``, else the guard's intervals cut up alike.
    """
    scenario, count = setup.scenario, setup.scenario.corridor.cells
    if not count or not scenario.guard.enabled:
        return [(setup, np.zeros(COMMAND))]
    ranges = np.array([mass_range(setup.guard, i) for i in (0, 1)])
    widths = (ranges[:, 1] - ranges[:, 0]) / (2 * count)
    middles = ranges[:, :1] + widths[:, None] * (2 * np.arange(count) + 1)
    believed = {f"model.{key}": getattr(scenario.believed, key) for key in ("m", "I", "mu")}
    return [
        (settle(override(scenario, {**believed, BODY[0]: m, BODY[1]: I}), setup.name),
         widths * (1 + 1e-12))
        for m in middles[0].tolist() for I in middles[1].tolist()
    ]  # fmt: skip


def _certified_tube(certifier: Certifier, inputs: Inputs, closing: bool) -> Tube:
    try:
        return certifier.tube(inputs)
    except NoCorridorError as error:
        closes = _closing(certifier, inputs) if closing else None
        raise NoCorridorError(str(error), closes) from error


def _closing(certifier: Certifier, inputs: Inputs) -> float | None:
    """Largest share of the inputs, of those tried, with which there is a corridor."""
    low, high = 0.0, 1.0
    for _ in range(SHARES):
        middle = (low + high) / 2
        try:
            certifier.tube(inputs.scaled(middle))
            low = middle
        except NoCorridorError:
            high = middle
    return low or None
