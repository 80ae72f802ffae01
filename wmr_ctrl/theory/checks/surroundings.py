"""Robot, drives and sensors around a scenario's laws, linearised at any control period."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import pairwise, product

import casadi as ca
import numpy as np

from wmr_ctrl.control.applied import followed
from wmr_ctrl.control.setup import Setup
from wmr_ctrl.core.data import data
from wmr_ctrl.core.signals import SAMPLE, STEP, TIME
from wmr_ctrl.world.model.dynamics import force_to_wheel
from wmr_ctrl.world.model.graph import rounds
from wmr_ctrl.world.phases import drag
from wmr_ctrl.world.pose_delay import PoseDelay
from wmr_ctrl.world.pose_sensor import PoseSensor, samples_a_pose
from wmr_ctrl.world.registry import EFFECTS, OURS
from wmr_ctrl.world.scenario import Robot, Scenario, override
from wmr_ctrl.world.velocity_loss import VelocityLoss

from .error_coordinates import COMMAND, Floats, World, world_of
from .sampled_plant import (
    GRID,
    Assembly,
    Motion,
    SampledPlant,
    by_age,
    divided,
    steps_in,
)

IDLE = data(__package__, "idle.toml")
"""Numbers of a base that leaves every command as it is, and gives every torque."""

MANY = 16.0
"""Number of samples above which a time is rounded to whole samples."""


@dataclass(frozen=True)
class DriveTimes:
    """Delay until a command acts [s], the part of it that the law knows, and the known lag."""

    delay: float
    known: float
    lag: float


@dataclass(frozen=True)
class KnownDrives:
    """A controller's memory of the forces that it sent, as its own model of the drives updates it.

    Next memory as a function of memory and sent force.  ``known``: the part of the memory that a
    law reads, the mean force of the last period, then commands.  The last ``sent`` elements are
    commands, latest first.
    """

    moved: Floats
    forced: Floats
    known: Floats
    sent: int


@lru_cache(maxsize=64)
def idle_base(scenario: Scenario) -> Scenario:
    """The scenario without filter, on a base that limits, rounds and drops nothing."""
    return override(scenario, IDLE)


class Surroundings:
    """Robot, drives and sensors at any control period; a base that takes velocities is ideal.

    Drives that vary are at their slowest, and every due pose arrives.  Numbers of samples in
    sensors are rounded to the nearest integer; if few samples delay a velocity, the results for the
    integers below and above are interpolated.  No window is shorter than a sample.
    """

    def __init__(self, scenario: Scenario) -> None:
        """Prepare the scenario; nothing is differentiated yet."""
        self._sends = sends = scenario.takes_velocity
        scenario = idle_base(scenario) if sends else scenario
        self.scenario = scenario
        present = [item for item in EFFECTS.present(scenario) if "clock.control" in item.shape]
        self._foreign = any(item not in OURS for item in present)
        bounds = ((item, item.bounded(scenario)) for item in present)
        shown = ((item, bound is not None and any((*bound.age, *bound.window)))
                 for item, bound in bounds)  # fmt: skip
        self._counted = {key: (scenario.value(key)[0], late)
                         for item, late in shown for key in item.shape
                         if not key.startswith(("clock.", "actuator."))}  # fmt: skip
        actuator = scenario.actuator
        known = scenario.base.delay if sends else actuator.delay
        late = known + actuator.unmodelled_delay + actuator.jitter
        self.drives = DriveTimes(late, known, actuator.lag)
        self._lag = actuator.lag * (1 + actuator.lag_spread)
        self._wheels = wheels(scenario.robot.r, scenario.robot.l)
        self._sent = np.eye(COMMAND) if sends else self._wheels
        self._world = lru_cache(maxsize=256)(self._world_of)
        self.known_of_drives = lru_cache(maxsize=64)(self._known_of_drives)
        self._assembly = lru_cache(maxsize=64)(self._assembled)
        # Kept for the next law, which is tried at the same periods, delays and masses.
        self._plant = lru_cache(maxsize=1024)(
            lambda motion, period, delay, robot, sample: self._assembly(
                motion, period, robot
            ).plant(delay, sample)
        )

    def worlds(self, period: float) -> list[tuple[float, World]]:
        """The graphs at a control period [s], with weights that sum to 1."""
        own = period if self._foreign else self.scenario.clock.control
        ways = [_counts(key, time / period, late) for key, (time, late) in self._counted.items()]
        return [(math.prod(w for w, _ in way), self._world(own, tuple(n for _, n in way)))
                for way in product(*ways)]  # fmt: skip

    def _world_of(self, own: float, counts: tuple[int, ...]) -> World:
        times = {key: n * own for key, n in zip(self._counted, counts, strict=True)}
        return world_of(_still(self.scenario, own, times))

    @cached_property
    def headings(self) -> tuple[float, ...]:
        """Orientations [rad] to linearise at: a single one, unless the plant depends on it."""
        clock = self.scenario.clock.control
        thetas = (0.0, 1.0, 2.0)  # a slope has the same gradient at two of them, not at three
        motions = (Motion((0.0, 0.0, 0.0), (0.2, 0.1), (0.2, 0.1), theta) for theta in thetas)
        here, *there = (self._assembly(motion, clock).flow(clock)[0] for motion in motions)
        alike = np.abs(there - here).max() < GRID
        return (0.0,) if alike else tuple(np.arange(8) * math.pi / 4)

    def samples_a_pose(self, period: float) -> int:
        """Samples from one pose to the next, at a control period [s]."""
        return _samples(self.scenario.sensor.pose_period, period)

    def numbers(self, world: World, period: float, step: float, robot: Robot | None) -> list[float]:
        """Parameters of graphs at a control period and a plant step [s], for a robot."""
        own = self.scenario.robot if robot is None else robot
        body = {f"robot.{key}": value for key, value in vars(own).items()}
        sensor = {"sensor.pose_period": self.scenario.sensor.pose_period}
        clock = {"clock.control": period, "clock.plant": step, "actuator.lag": self._lag}
        return world.numbers({**clock, **sensor, **body})

    def plant(
        self,
        motion: Motion,
        period: float,
        *,
        drives: DriveTimes | None = None,
        robot: Robot | None = None,
        sample: int | None = None,
    ) -> SampledPlant:
        """Robot, drives and sensors over a ``sample``; by default one with a pose.

        ``drives`` and ``robot`` default to the scenario's.
        """
        late = self.drives if drives is None else drives
        return self._plant(motion, period, late.delay, robot, sample)

    def rates(self, motion: Motion) -> tuple[Floats, Floats, Floats, tuple[str, ...]]:
        """Gradients of the rates of robot and drives, without delay, by their state, force and
        push.

        The names are those of a SampledPlant.
        """
        return self._assembly(motion, self.scenario.clock.control).rates()

    def rate(self, z: ca.SX, force: ca.SX, v_d: Floats | tuple[float, ...]) -> ca.SX:
        """Rate of the fast state z, with tracking error in place of the pose, under a force (2)."""
        clock = self.scenario.clock
        world = self.worlds(clock.control)[0][1]
        numbers, torque = self.numbers(world, clock.control, 0.0, None), self.torque(world, force)
        rate: ca.SX = world.rates(0, z, 0.0, torque, ca.DM(numbers), ca.DM(v_d))
        return rate

    def step(self, z: ca.SX, force: ca.SX, v_d: Floats, step: float, push: ca.SX) -> ca.SX:
        """Fast state after a plant step of ``step`` [s], under a force and a disturbance (2)."""
        world = self.worlds(self.scenario.clock.control)[0][1]
        numbers = self.numbers(world, self.scenario.clock.control, step, None)
        held = self.torque(world, force, push)
        after: ca.SX = world.step(0, z, 0.0, held, ca.DM(numbers), ca.DM(v_d))
        return after

    def torque(self, world: World, *forces: ca.SX) -> ca.SX:
        """Inputs held over a sample that give a force and a disturbance (2) [N, N m]."""
        by = (self._sent, self._wheels)
        given = [ca.DM(rows) @ force for rows, force in zip(by, forces, strict=False)]
        return ca.vertcat(*given, ca.SX.zeros(world.held - COMMAND * len(given)))

    def _known_of_drives(
        self, period: float, late: DriveTimes, applied: bool, commands: int
    ) -> KnownDrives:
        """Memory of ``applied`` forces, if the law uses them, and of ``commands``."""
        whole, rest = divided(late.known, period)
        queue = max(applied * (whole + (rest > 0)), commands)
        sizes = (COMMAND * (applied and late.lag > 0), COMMAND * applied, COMMAND * queue)
        ends = np.cumsum([0, *sizes]).tolist()
        acting, mean, sent = (slice(a, b) for a, b in pairwise(ends))
        unit, rows = np.eye(ends[-1] + COMMAND), np.zeros((ends[-1], ends[-1] + COMMAND))
        ages = by_age(unit, ends[-1], sent)
        rows[sent] = np.vstack(ages)[: COMMAND * queue]
        if applied:
            steps = steps_in(period, self.scenario.clock.plant)
            step = period / steps
            decay = math.exp(-step / late.lag) if late.lag else 0.0
            lag = unit[acting] if late.lag else np.zeros((COMMAND, len(unit)))
            rows[mean], end = followed(ages, (whole, rest / step, steps), lag, decay)
            rows[acting] = end[: acting.stop - acting.start]
        known = np.vstack((unit[mean], unit[sent][: COMMAND * commands]))
        n = ends[-1]
        return KnownDrives(rows[:, :n], rows[:, n:], known[:, :n], COMMAND * queue)

    def _assembled(self, motion: Motion, period: float, robot: Robot | None = None) -> Assembly:
        own = self.scenario.robot if robot is None else robot
        steady: Floats = wheels(own.r, own.l) @ drag(own, np.array(motion.v))[:, 0]
        return Assembly(
            self.worlds(period), motion, period, self.samples_a_pose(period),
            self.scenario.clock.plant,
            lambda world, step: self.numbers(world, period, step, robot),
            self._sent, self._wheels, steady, self._sends,
        )  # fmt: skip


def _still(scenario: Scenario, period: float, times: Mapping[str, float]) -> Scenario:
    """The scenario at a control period [s], with constant, punctual drives and guard off."""
    none = ("actuator.delay", "actuator.unmodelled_delay", "actuator.jitter", "actuator.lag_spread")
    changed: dict[str, object] = {**dict.fromkeys((*none, "sensor.pose_dropout"), 0.0), **times}
    changed |= {"guard.enabled": False, "base.rest": math.inf}
    clock = scenario.clock
    if period != clock.control:
        changed |= {"clock.control": period, "clock.plant": period / steps_in(period, clock.plant)}
        changed["clock.duration"] = period * math.ceil(clock.duration / period)
        changed["sensor.pose_period"] = period * round(scenario.sensor.pose_period / period)
    return override(scenario, changed)


def _counts(key: str, ratio: float, late: bool) -> list[tuple[float, int]]:
    """Integers that represent a non-integer ``ratio`` of samples, with weights.

    ``late``: an effect that delays or averages a velocity.
    """
    if key.endswith("window") and ratio > 0:
        ratio = max(ratio, 1.0)
    if not late or ratio > MANY or abs(ratio - round(ratio)) < GRID * max(ratio, 1.0):
        return [(1.0, round(ratio))]
    below = math.floor(ratio)
    return [(below + 1 - ratio, below), (ratio - below, below + 1)]


@lru_cache(maxsize=256)
def _samples(every: float, period: float) -> int:
    return int(ca.evalf(samples_a_pose(ca.SX(every), ca.SX(period))))


@lru_cache(maxsize=64)
def wheels(r: float, l: float) -> Floats:
    """Matrix (2, 2) from generalised force to torques (right, left) [N m], for r and l [m]."""
    force = ca.SX.sym("force", 2)
    torque = force_to_wheel(ca.SX(r), ca.SX(l), force)
    return np.asarray(ca.evalf(ca.jacobian(torque, force)))


@lru_cache(maxsize=64)
def surroundings(scenario: Scenario) -> Surroundings:
    """The Surroundings of a scenario, built once."""
    return Surroundings(scenario)


def delays_by_name(setup: Setup) -> dict[str, float]:
    """Delays [s] by name; a window of about one sample is part of the period itself."""
    bound, late = setup.bound, setup.scenario.section(PoseDelay).pose_delay
    window = max(bound.window)
    parts = {
        "delay": bound.delay, "lag": bound.lag[1], "velocity's age": max(bound.age),
        "velocity's window": window if window >= 1.5 * setup.scenario.clock.control else 0.0,
        "pose's age": late,
    }  # fmt: skip
    return {word: value for word, value in parts.items() if value}


def oldest_shown(setup: Setup) -> float:
    """Age of the oldest velocity or pose in a sensor's output [s]."""
    bound = setup.bound
    ages = [age + window for age, window in zip(bound.age, bound.window, strict=True)]
    return max(*ages, setup.scenario.section(PoseDelay).pose_delay)


def is_sampled(setup: Setup) -> bool:
    """True if there is more than a lag, so that only a sampled model applies."""
    sensor = setup.scenario.section(PoseSensor)
    filtered = sensor.correction < 1 or sensor.pose_period > 0
    return setup.bound.delay > 0 or oldest_shown(setup) > 0 or filtered


def lost_samples(scenario: Scenario) -> str:
    """Remark on lost poses, velocities and commands, which the linear loop neglects; "" if none."""
    poses, base = scenario.section(PoseSensor).pose_dropout, scenario.base
    counts = {"velocities": scenario.section(VelocityLoss).velocity_losses}
    counts |= {"commands": base.losses} if scenario.takes_velocity else {}
    lost = [f"{poses:.0%} of the poses"] * (poses > 0)
    lost += [f"{name} up to {count} in a row" for name, count in counts.items() if count]
    return f"as if nothing were lost, though {' and '.join(lost)} may be" if lost else ""


def rounded_effects(scenario: Scenario) -> str:
    """Remark on rounding effects and dead bands, which have no derivative; empty if none."""
    rounding = []
    for item in EFFECTS.present(scenario):
        system = item.system(scenario)
        seen = (p.sym for p in system.inputs if p.signal not in (TIME, SAMPLE, STEP))
        if rounds(ca.vertcat(system.update, system.y), ca.vertcat(*seen, system.x)):
            rounding.append(f"[{item.section.KEY}]")
    texts = [f"as if there were no rounding in {' and '.join(rounding)}"] if rounding else []
    for name in ("deadband", "wheel_deadband"):
        if scenario.takes_velocity and np.any(getattr(scenario.base, name)):
            texts.append(f"as if base.{name} let every command pass")
    return " and ".join(texts)


def rare_poses(scenario: Scenario) -> str:
    """Remark on rare poses, which a time-invariant loop neglects; empty if none."""
    every = scenario.section(PoseSensor).pose_period
    said = f"as if a pose came at every sample, though one comes every {every:g} s"
    return said if every > scenario.clock.control else ""
