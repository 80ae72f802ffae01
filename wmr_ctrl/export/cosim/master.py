"""Masters: order of the steps, and the effects between the FMUs.

Gauss-Seidel gives the controller the present outputs of reference and plant, steps it, and then the
plant with its torques, which equals the native loop. Jacobi steps all three with the previous
outputs: the torque acts one step later, as under every master that copies connections after all
have stepped. Reference and controller step once in a control period, our plant once in each of its
own steps, with the torque held: so the monitor sees the same states as the native one.

On a base that takes velocities the controller sends one in the place of torques.  Its speed loop is
one of the drives, unless the plant takes velocities itself.

Sensors, disturbances, drives and monitor are the compiled ones of the loop: they draw the same
random numbers and check the same limits.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from wmr_ctrl.codegen.build import build_outside, first_step_at
from wmr_ctrl.control.loop import PlantlessGraphs
from wmr_ctrl.control.setup import Setup
from wmr_ctrl.simulation.coupled import Coupled
from wmr_ctrl.world.scenario import Change, Scenario

from .mapping import DESIRED, STATE
from .parts import GuardedController, Part, limiter, ready, wheels_of

Progress = Callable[[float], None]
_ROWS_PER_REPORT = 100


@dataclass
class Parts:
    """FMUs that a master steps, and a function that changes the plant's parameters."""

    reference: Part
    controller: Part | GuardedController
    plant: Part
    change: Callable[[Change], None]


@dataclass(frozen=True)
class Measurement:
    """Measured pose and velocity of a sample, disturbing torque and body force.

    ``logged``: further columns of the log, see `Outside.columns`; ``age``: of the odometry [s].
    """

    pose: tuple[float, ...]
    velocity: tuple[float, ...]
    noise: tuple[float, ...]
    pushed: tuple[float, ...]
    logged: tuple[float, ...]
    age: float = 0.0


class Outside(Coupled):
    """Effects between controller and plant of one run; every call advances their counters.

    ``columns``: log signals of the effects; ``steady``: whether all inputs of the plant are
    constant over a sample; ``calm``: whether the disturbances are; ``rolling``: further plant
    outputs that sensors need; ``ended``: whether the run ends before its first step.
    """

    def __init__(self, setup: Setup, seed: int) -> None:
        """Set everything to t = 0.  Raises CompilerError or ArgumentError."""
        graphs = PlantlessGraphs(setup)
        super().__init__(build_outside(setup, graphs), seed, setup.scenario.clock.plant)
        self.columns, self.steady, self.rolling = graphs.columns, graphs.steady, graphs.rolling
        self.calm, self._dated = graphs.calm, graphs.dated

    def sample(self, state: Sequence[float]) -> Measurement:
        """The next control sample, for the plant's present state."""
        shown = tuple(self.sampled(state))
        *logged, age = shown[9:] if self._dated else (*shown[9:], 0.0)
        return Measurement(shown[0:3], shown[3:5], shown[5:7], shown[7:9], tuple(logged), age)

    def step(self, torque: Sequence[float], now: Measurement) -> tuple[float, ...]:
        """Acting torques over the next plant step, disturbing torques, force on the body."""
        return tuple(self.acting((*torque, *now.noise, *now.pushed)))


class Master:
    """One co-simulation: rows of the log, and the monitor's findings after each plant step."""

    def __init__(self, scenario: Scenario, parts: Parts, outside: Outside) -> None:
        """Prepare the master; nothing is read, so that parts may be initialised later."""
        self.scenario, self.clock, self.parts = scenario, scenario.clock, parts
        self.outside = outside
        self.steady = outside.calm if parts.plant.is_base else outside.steady
        self.stride = self.clock.substeps if parts.plant.foreign and self.steady else 1
        self.state: tuple[float, ...] = (*scenario.initial.pose, *scenario.initial.velocity)
        self.applied: Sequence[float] = (0.0, 0.0)
        step = self.clock.plant
        self.changes = [(first_step_at(item.t, step), item) for item in scenario.changes]
        self.rows: list[tuple[float, ...]] = []

    def start(self) -> None:
        """Read the outputs of initialised parts at t = 0."""
        self.state += tuple(self.parts.plant.read())[len(self.state) :]

    def run(self, progress: Progress | None) -> None:
        """Run all control samples of initialised parts, or those until the run must end."""
        self.start()
        ended = self.outside.ended
        for k in range(self.clock.samples):
            if ended:
                break
            ended = self.sample(k)
            if progress is not None and (k + 1) % _ROWS_PER_REPORT == 0:
                progress((k + 1) / self.clock.samples)

    @property
    def watched_every(self) -> float:
        """Longest time between two checks of the plant by the monitor [s]."""
        span = self.stride * self.clock.plant
        return min(span, self.parts.plant.step_size or span)

    def sample(self, k: int) -> bool:
        """Step reference, controller and plant; True if the run must end."""
        t, h = k * self.clock.control, self.clock.control
        desired, now = list(self.parts.reference.read()), self.outside.sample(self.state)
        self.parts.reference.step(t, h)
        self.parts.controller.write(self.seen(desired, now))
        self.parts.controller.step(t, h)
        given = self.parts.controller.read()
        torque = self.limited(given)
        self.log(t, desired, torque, now, given[2:])
        return self.drive(k, torque, now)

    def limited(self, given: Sequence[float]) -> Sequence[float]:
        """Torques within actuator.tau_max: our controllers keep it, others are limited here.

        A base that takes velocities limits its torques itself.
        """
        if not self.parts.controller.foreign or self.scenario.takes_velocity:
            return given[:2]
        robot, tau_max = self.scenario.robot, self.scenario.actuator.tau_max
        return np.asarray(limiter()(given[:2], robot.r, robot.l, tau_max)).ravel().tolist()

    def seen(self, desired: Sequence[float], now: Measurement) -> list[float]:
        """Inputs of the controller, in the order of SEEN."""
        shown = [*desired, *now.pose, *now.velocity, *self.applied, now.age]
        if self.parts.controller.wants_ready:
            shown += ready((*now.pose, *now.velocity), self.scenario.robot)
        return shown

    def log(
        self,
        t: float,
        desired: Sequence[float],
        torque: Sequence[float],
        now: Measurement,
        further: Sequence[float],
    ) -> None:
        """Add a row: state at t, torques over the step, outputs of effects and controller."""
        head = (t, *self.state[: len(STATE)], *desired, *torque, *now.noise, *now.logged)
        self.rows.append((*head, *further))

    def drive(self, k: int, sent: Sequence[float], now: Measurement) -> bool:
        """Step the plant over one control period; True if the run must end within it."""
        acted: list[Sequence[float]] = []
        ended, is_base = False, self.parts.plant.is_base
        for start, end in self.cuts(k * self.clock.substeps):
            for _ in range(start, end):
                acting = self.outside.step(sent, now)
            if not self.steady or not acted:
                acted.append(acting[:2])
                right, left, noise_right, noise_left, *pushed = acting
                disturbed = (right + noise_right, left + noise_left)
                commanded = (*sent, *wheels_of(sent, self.scenario.robot)) if is_base else ()
                self.parts.plant.write((*acting[:4], *pushed, *disturbed, *commanded))
            ended = self.move(start, end)
            if ended:
                break
        self.applied = [sum(pair[i] for pair in acted) / len(acted) for i in (0, 1)]
        return ended

    def move(self, start: int, end: int) -> bool:
        """Step the plant from one cut to the next, with a check after each communication step."""
        dt = self.clock.plant
        for reached in self.parts.plant.steps(start * dt, (end - start) * dt, end * dt):
            self.state = tuple(self.parts.plant.read())
            if self.outside.ends(self.state, round(reached / dt)):
                return True
        return False

    def cuts(self, first: int) -> Iterator[tuple[int, int]]:
        """Ranges (from, to) of plant steps to take together; due changes are made before each."""
        last = first + self.clock.substeps
        edges = [n for n, _ in self.changes if first < n < last]
        regular = range(first, last + 1, self.stride)
        for start, end in pairwise(sorted({*regular, *edges})):
            while self.changes and self.changes[0][0] <= start:
                self.parts.change(self.changes.pop(0)[1])
            yield start, end


class Jacobi(Master):
    """Master in which all parts step with previous outputs; the first acting torque is zero."""

    def start(self) -> None:
        """Read the outputs of all parts at t = 0."""
        super().start()
        self.desired = list(self.parts.reference.read())
        self.now = self.outside.sample(self.state)
        self.shown = self.seen(self.desired, self.now)
        self.given: Sequence[float] = (0.0, 0.0)

    def sample(self, k: int) -> bool:
        """Step reference, controller and plant together; True if the run must end."""
        t, h = k * self.clock.control, self.clock.control
        self.parts.controller.write(self.shown)
        self.parts.reference.step(t, h)
        self.parts.controller.step(t, h)
        given = self.parts.controller.read()
        self.log(t, self.desired, self.given, self.now, given[2:])
        ended = self.drive(k, self.given, self.now)
        self.given, self.desired = self.limited(given), list(self.parts.reference.read())
        if k + 1 < self.clock.samples:
            self.now = self.outside.sample(self.state)
            self.shown = self.seen(self.desired, self.now)
        return ended


MASTERS = {"gauss-seidel": Master, "jacobi": Jacobi}
HEAD = ("t", *STATE, *DESIRED)
"""First columns of a row; torques, noises and the controller's diagnostics follow."""
