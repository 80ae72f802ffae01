"""Masters: who steps when, and who sees whose outputs.

Gauss-Seidel steps reference, controller and plant in this order and passes values on in between,
which is the native loop.  Jacobi steps all three with what was known before: the torque acts one
step later, as under every master that copies connections after all have stepped.  Reference and
controller step once in a control period, our plant once in each of its own steps, with the torque
held: so the monitor sees what the native one sees.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

from wmr_ctrl.fmi.cosim.parts import DESIRED, STATE, Part, limited_torque, ready
from wmr_ctrl.scenario import Change, Scenario
from wmr_ctrl.sim.native import push_torque
from wmr_ctrl.sim.oracle.actuator import Actuator
from wmr_ctrl.sim.oracle.monitor import Watch
from wmr_ctrl.sim.oracle.noise import key_of
from wmr_ctrl.sim.oracle.plant import State
from wmr_ctrl.sim.oracle.sensing import Sensor

Progress = Callable[[float], None]
_ROWS_PER_REPORT = 100


@dataclass
class Parts:
    """What a master steps."""

    reference: Part
    controller: Part
    plant: Part
    change: Callable[[Change], None]


class Master:
    """One co-simulation: rows of the log, and what was watched after each step of the plant."""

    def __init__(
        self, scenario: Scenario, parts: Parts, noise: Sequence[tuple[float, float]], seed: int
    ) -> None:
        """Everything is initialised already; the first step begins at t = 0."""
        self.scenario, self.clock, self.parts, self.noise = scenario, scenario.clock, parts, noise
        self.sensor = Sensor(scenario.sensor, scenario.clock, key_of(seed))
        self.actuator = Actuator(scenario.actuator, scenario.clock.plant)
        self.ideal = scenario.actuator.ideal
        self.stride = self.clock.substeps if parts.plant.foreign else 1
        self.push = push_torque(scenario)
        self.state: State = (*scenario.initial.pose, *scenario.initial.velocity)
        self.applied: Sequence[float] = (0.0, 0.0)
        self.changes = sorted(scenario.changes, key=lambda change: change.t)
        self.watch = Watch(scenario.limits.v_u1)
        self.rows: list[tuple[float, ...]] = []

    def run(self, progress: Progress | None) -> None:
        """All control samples, or those before the run must end."""
        ended = self.watch.see(0.0, self.state)
        for k in range(self.clock.samples):
            if ended:
                break
            ended = self.sample(k)
            if progress is not None and (k + 1) % _ROWS_PER_REPORT == 0:
                progress((k + 1) / self.clock.samples)

    def sample(self, k: int) -> bool:
        """Reference, controller, plant; True if the run must end."""
        t, h = k * self.clock.control, self.clock.control
        self.parts.reference.step(t, h)
        desired = self.parts.reference.read()
        self.parts.controller.write(self.seen(k, desired))
        self.parts.controller.step(t, h)
        given = self.parts.controller.read()
        torque, noise = self.limited(given), self.disturbance(k)
        self.log(t, desired, torque, noise, given[2:])
        return self.drive(k, torque, noise)

    def limited(self, given: Sequence[float]) -> Sequence[float]:
        """Torques within actuator.tau_max: ours keep it themselves, others by the drives."""
        if not self.parts.controller.foreign:
            return given[:2]
        return limited_torque((given[0], given[1]), self.scenario)

    def disturbance(self, k: int) -> tuple[float, float]:
        """Noise of sample k (right, left) [N m], and a push on in each axis' direction."""
        (right, left), (along, around) = self.noise[k], self.push
        along = -along if self.state[3] < 0.0 else along
        around = -around if self.state[4] < 0.0 else around
        return right + (along + around), left + (along - around)

    def seen(self, k: int, desired: Sequence[float]) -> list[float]:
        """What the controller is shown at sample k, in the order of SEEN."""
        pose, v = self.sensor.look(k, self.state)
        shown = [*desired, *pose, *v, *self.applied]
        if self.parts.controller.wants_ready:
            shown += ready((*pose, *v), self.scenario.robot)
        return shown

    def log(
        self,
        t: float,
        desired: Sequence[float],
        torque: Sequence[float],
        noise: Sequence[float],
        further: Sequence[float],
    ) -> None:
        """One row: state at t, torques over the step, what the controller published."""
        self.rows.append((t, *self.state, *desired, *torque, *noise, *further))

    def drive(self, k: int, torque: Sequence[float], noise: Sequence[float]) -> bool:
        """The plant over one control period; True if the run must end within it."""
        acted: list[Sequence[float]] = []
        ended = False
        for start, end in self.cuts(k * self.clock.substeps):
            if not self.ideal or not acted:
                acted.append(self.acting(torque))
                self.parts.plant.write(driven(acted[-1], noise))
            ended = self.move(start, end)
            if ended:
                break
        self.applied = [sum(pair[i] for pair in acted) / len(acted) for i in (0, 1)]
        return ended

    def acting(self, torque: Sequence[float]) -> Sequence[float]:
        """Torques that act over the next cut."""
        return torque if self.ideal else self.actuator.advance((torque[0], torque[1]))

    def move(self, start: int, end: int) -> bool:
        """The plant from one cut to the next, watched after each of its communication steps."""
        dt = self.clock.plant
        for reached in self.parts.plant.steps(start * dt, (end - start) * dt, end * dt):
            self.state = state_of(self.parts.plant.read())
            if self.watch.see(reached, self.state):
                return True
        return False

    def cuts(self, first: int) -> Iterator[tuple[int, int]]:
        """Plant steps (from, to) to take at once; what changes at their start is changed before."""
        last = first + self.clock.substeps
        edges = [n for change in self.changes if first < (n := self._step_of(change)) < last]
        regular = range(first, last + 1, self.stride if self.ideal else 1)
        for start, end in pairwise(sorted({*regular, *edges})):
            self._make_changes(start)
            yield start, end

    def _make_changes(self, start: int) -> None:
        while self.changes and self._step_of(self.changes[0]) <= start:
            self.parts.change(self.changes.pop(0))

    def _step_of(self, change: Change) -> int:
        near = round(change.t / self.clock.plant)
        on_grid = abs(near * self.clock.plant - change.t) <= 1e-9 * max(1.0, change.t)
        return near if on_grid else math.ceil(change.t / self.clock.plant)


class Jacobi(Master):
    """All parts step with what was known before; the first torque that acts is zero."""

    def __init__(
        self, scenario: Scenario, parts: Parts, noise: Sequence[tuple[float, float]], seed: int
    ) -> None:
        """As Master."""
        super().__init__(scenario, parts, noise, seed)
        self.desired = list(parts.reference.read())
        self.shown = self.seen(0, self.desired)
        self.given: Sequence[float] = (0.0, 0.0)

    def sample(self, k: int) -> bool:
        """Reference, controller and plant at once; True if the run must end."""
        t, h = k * self.clock.control, self.clock.control
        self.parts.controller.write(self.shown)
        self.parts.reference.step(t, h)
        self.parts.controller.step(t, h)
        given = self.parts.controller.read()
        noise = self.disturbance(k)
        self.log(t, self.desired, self.given, noise, given[2:])
        ended = self.drive(k, self.given, noise)
        self.given, self.desired = self.limited(given), list(self.parts.reference.read())
        if k + 1 < self.clock.samples:
            self.shown = self.seen(k + 1, self.desired)
        return ended


def state_of(values: Sequence[float]) -> State:
    """Pose and velocity as the oracle's parts take them."""
    x, y, theta, v1, omega = values
    return x, y, theta, v1, omega


def driven(torque: Sequence[float], noise: Sequence[float]) -> tuple[float, ...]:
    """Values of parts.DRIVEN."""
    return (*torque, *noise, torque[0] + noise[0], torque[1] + noise[1])


MASTERS = {"gauss-seidel": Master, "jacobi": Jacobi}
HEAD = ("t", *STATE, *DESIRED)
"""First columns of a row; torques, noises and the controller's diagnostics follow."""
