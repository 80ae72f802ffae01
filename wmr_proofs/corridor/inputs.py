"""Bounded inputs and conditions of the certified loop, from the scenario's effects and guard.

An effect without a bound, or one that the certified loop does not model, is refused by name.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import casadi as ca
import numpy as np

from wmr_ctrl.control.guard.bounds import aim, net, pair_of, slope
from wmr_ctrl.control.laws.registry import LAWS
from wmr_ctrl.control.setup import Setup
from wmr_ctrl.core.errors import show
from wmr_ctrl.core.fields.section import quantities
from wmr_ctrl.core.signals import PLANT_STATE
from wmr_ctrl.theory.checks.error_coordinates import COMMAND, Floats
from wmr_ctrl.theory.checks.surroundings import surroundings
from wmr_ctrl.world.command_dead_band import COMMAND_DEAD_BAND
from wmr_ctrl.world.command_delay import COMMAND_DELAY
from wmr_ctrl.world.command_quantum import COMMAND_QUANTUM
from wmr_ctrl.world.command_ramp import COMMAND_RAMP
from wmr_ctrl.world.delay import DELAY
from wmr_ctrl.world.effect import Effect, EffectRole, Rate
from wmr_ctrl.world.jitter import JITTER
from wmr_ctrl.world.lag import LAG, Lag
from wmr_ctrl.world.model.dynamics import force_to_wheel
from wmr_ctrl.world.pose_sensor import POSE_SENSOR, PoseSensor
from wmr_ctrl.world.references.kind import reference
from wmr_ctrl.world.scenario import Scenario
from wmr_ctrl.world.speed_loop import has_loop
from wmr_ctrl.world.speed_loops import SPEED_LOOP
from wmr_ctrl.world.torque_noise import TORQUE_NOISE_EFFECT, TorqueNoise
from wmr_ctrl.world.velocity_noise import VELOCITY_NOISE, VelocityNoise
from wmr_ctrl.world.wheel_speed_limit import WHEEL_SPEED_LIMIT

from .condition import AXES, Condition
from .late_guard import counts_late, is_plain
from .loop import MOST_NUMBERS, LawLoop, punctual
from .overlap import ramps

OF_BASE = (
    COMMAND_DELAY, COMMAND_QUANTUM, COMMAND_DEAD_BAND, WHEEL_SPEED_LIMIT, COMMAND_RAMP, SPEED_LOOP,
)  # fmt: skip
"""Effects of a base that takes velocities which are counted."""


class NoCorridorError(ArithmeticError):
    """No certificate: the reason as a clause, and the shares of inputs and start for which one
    exists.
    """

    def __init__(self, text: str, closes: float | None = None, near: float = 1.0) -> None:
        super().__init__(text)
        self.closes, self.near = closes, near


@dataclass(frozen=True)
class Inputs:
    """Bounds of the inputs.

    ``push``: torque on each wheel (2) [N m], held over a sample.  ``pose``: error of the measured
    position [m].  ``velocity``: error of each measured velocity (2).  ``body``: deviation of mass
    and inertia from the scenario's (2) [kg, kg m2].  ``command``: difference of an acting velocity
    from the one sent (2).  ``dead``: size below which the firmware may treat it as 0 (2).
    ``missing``: consecutive samples without a pose.  ``reckoned``: additional error of the
    dead-reckoned pose (3) [m, m, rad].
    """

    push: Floats
    pose: float
    velocity: Floats
    body: Floats = field(default_factory=lambda: np.zeros(2))
    command: Floats = field(default_factory=lambda: np.zeros(2))
    dead: Floats = field(default_factory=lambda: np.zeros(2))
    missing: int = 0
    reckoned: Floats = field(default_factory=lambda: np.zeros(3))

    def scaled(self, share: float) -> Inputs:
        """The inputs with push and errors scaled."""
        return replace(
            self, push=share * self.push, pose=share * self.pose, velocity=share * self.velocity
        )

    def misheard(self, least: Floats) -> Floats:
        """Error (2) of an acting command whose size is at least ``least`` (2)."""
        acts = least - self.command > self.dead
        return np.asarray((self.command + np.where(acts, 0.0, self.dead)) * (1 + 1e-15))

    @property
    def measured(self) -> Floats:
        """Measurement errors of pose and velocity (5)."""
        place = (self.pose + self.reckoned[:2]) * (1 + 1e-15)
        return np.array([*place, self.reckoned[2], *self.velocity])

    @property
    def any(self) -> bool:
        """True if there is any disturbance."""
        return bool(self.push.any() or self.pose or self.velocity.any())


def bounded_inputs(setup: Setup) -> Inputs:
    """Inputs of a setup; NoCorridorError for an effect without a bound or outside the model."""
    scenario = setup.scenario
    push, acting = np.zeros(2), [item for item in setup.effects if item.active(scenario)]
    covered = (
        VELOCITY_NOISE,
        POSE_SENSOR,
        *(OF_BASE if setup.takes_velocity else (DELAY, JITTER, LAG)),
    )
    for effect in acting:
        if effect.role is EffectRole.DISTURBANCE and effect.rate is Rate.SAMPLE:
            push = push + _push(effect, setup)
        elif effect not in covered and not _in_the_step(effect, scenario):
            raise NoCorridorError(
                f"the loop with the effect {effect.title} is not covered: leave out "
                f"{_told_by(effect, scenario)}"
            )
    if scenario.section(Lag).lag_spread > 0:
        raise NoCorridorError("actuator.lag_spread > 0: a lag that varies is not covered")
    if len(surroundings(punctual(scenario)).headings) > 1:
        raise NoCorridorError(
            "an effect that depends on the heading, such as a slope, is not covered: leave it out"
        )
    sensor = scenario.section(PoseSensor)
    pose = math.sqrt(2.0) * sensor.pose_noise * (1 + 1e-15)
    noise = np.array(scenario.section(VelocityNoise).velocity_noise)
    missing = _missing(scenario)
    if not setup.takes_velocity:
        return Inputs(push, pose, noise, missing=missing)
    rounded, dead = np.array(scenario.base.quantum) / 2, np.array(scenario.base.deadband)
    return Inputs(push, pose, noise, command=rounded * (1 + 1e-15), dead=dead, missing=missing)


def _told_by(effect: Effect, scenario: Scenario) -> str:
    """The keys that switch an effect on, with their values."""
    section, defaults = scenario.section(effect.section), dict(quantities(effect.section))
    names = effect.switches or tuple(defaults)
    numbers = {name: getattr(section, name) for name in names}
    keys = [f"{section.KEY}.{name} = {show(value)}" for name, value in numbers.items()
            if value != defaults[name].default]  # fmt: skip
    return ", ".join(keys) or f"[{section.KEY}]"


def _missing(scenario: Scenario) -> int:
    """Largest number of consecutive samples without a pose; NoCorridorError for too many."""
    sensor = scenario.section(PoseSensor)
    losses = scenario.corridor.losses
    if sensor.pose_dropout > 0 and not losses:
        raise NoCorridorError(
            "sensor.pose_dropout: poses may be lost any number of times in a row; state "
            "corridor.losses, the most that are"
        )
    count = without_pose(scenario, losses * (sensor.pose_dropout > 0))
    if count and sensor.correction < 1:
        raise NoCorridorError(
            "[sensor]: poses that are rare or lost and corrected in part (correction < 1) are not "
            "covered"
        )
    return count


def without_pose(scenario: Scenario, losses: int) -> int:
    """Number of consecutive samples without a pose, if ``losses`` consecutive poses are lost."""
    period = scenario.section(PoseSensor).pose_period
    return max(1, round(period / scenario.clock.control)) * (1 + losses) - 1


def check_covered(setup: Setup) -> None:
    """Raise NoCorridorError for a base or a law that the certificate does not cover."""
    if setup.control_law.inside is None:
        able = ", ".join(name for name, law in LAWS.items() if law.inside is not None)
        raise NoCorridorError(f"only {able} have one, away from their limits")
    if setup.takes_velocity:
        _check_base(setup.scenario)
    if setup.predicted:
        raise NoCorridorError("a law that predicts (its gain delay) is not covered")


def at_first(setup: Setup, *, run: bool) -> str:
    """Text on the initial state of drives, base and law: for a ``run``, or for all time."""
    scenario = setup.scenario
    if not setup.takes_velocity:
        if scenario.actuator.ideal:
            return ""
        asked = "the torque that friction takes in its drives and a law that has asked for it"
        return "no torque in its drives" if run else asked
    parts, late = [], scenario.base.delay > 0
    if late:
        parts.append("no command in transit" if run else "commands of that speed in transit")
    if ramps(scenario):
        parts.append("its ramp at that speed")
    if has_loop(scenario, "pi"):
        parts.append(f"{'no force' if run else 'the force that friction takes'} in its own loop")
    if parts and not run:
        parts.append(f"a law that has sent {'them' if late else 'commands of that speed'}")
    *first, last = parts or [""]
    return f"{', '.join(first)} and {last}" if first else last


def _check_base(scenario: Scenario) -> None:
    """Raise NoCorridorError for a base or filter that treats commands differently from the
    model.
    """
    stated = scenario.filter
    if stated.kind == "band":
        raise NoCorridorError(
            'filter.kind = "band": what it lets pass depends on all commands before, and is not '
            "covered; a clip or a governor is"
        )
    if stated.slew is not None:
        raise NoCorridorError(
            "filter.slew: from a run's first command on, the clip brings it up from 0 at that "
            "rate, which is not covered"
        )
    if not (has_loop(scenario, "first-order") or has_loop(scenario, "pi")):
        raise NoCorridorError(
            f"base.loop = {show(list(scenario.base.loop))} is not covered: both axes with "
            "first-order loops, or both with PI loops, are"
        )
    if math.isfinite(scenario.actuator.tau_max):
        raise NoCorridorError(
            "actuator.tau_max behind the base's own loop is not covered: leave it out if the "
            "motors are never at their limit"
        )


def check_size(loop: LawLoop) -> None:
    """Raise NoCorridorError for a loop larger than the sums' rounding bounds assume."""
    count = len(loop.names) + COMMAND * loop.queue + loop.memory + loop.acting
    if count > MOST_NUMBERS:
        raise NoCorridorError(
            f"the loop's state has {count} numbers, as a long delay makes it, and rounding is "
            f"counted for {MOST_NUMBERS} at most"
        )


def _in_the_step(effect: Effect, scenario: Scenario) -> bool:
    """True for an effect in the plant step's graph: a force due to heading and velocity alone.

    That graph is evaluated at one place and time, with random numbers 0.
    """
    if effect.role is not EffectRole.DISTURBANCE or effect.rate is not Rate.STEP:
        return False
    system = effect.system(scenario)
    read = {item.signal for item in system.inputs}
    return not (system.draws or system.state) and read <= set(PLANT_STATE[2:])


def _push(effect: Effect, setup: Setup) -> Floats:
    """Largest torque of an effect on each wheel (2) [N m]."""
    scenario, robot = setup.scenario, setup.scenario.robot
    if effect is TORQUE_NOISE_EFFECT:
        noise = scenario.section(TorqueNoise)
        if math.isinf(noise.truncate):
            raise NoCorridorError(
                "disturbance.truncate = inf: the push has no bound; cut it at 3, say"
            )
        return np.full(2, noise.std * noise.truncate)
    bound = effect.bounded(scenario)
    if bound is None or bound.void:
        why = "no bound is known of it" if bound is None else bound.void.rstrip(".")
        raise NoCorridorError(f"the effect {effect.title}: {why}")
    wheel = force_to_wheel(ca.SX(robot.r), ca.SX(robot.l), ca.SX(ca.DM(bound.dbar)))
    return np.full(2, float(ca.evalf(wheel[0]))) * (1 + 1e-15)


def is_steady(setup: Setup) -> bool:
    """True on a circle or a line, where the desired velocity is constant."""
    system = reference(setup.scenario)
    v_d, rates = (ca.vertcat(*(item.expr for item in part))
                  for part in (system.outputs[3:5], system.outputs[5:]))  # fmt: skip
    return not ca.depends_on(v_d, ca.vertcat(system.u, system.x)) and rates.is_zero()


def steady_motion(setup: Setup) -> Floats:
    """Desired velocity (2) of a circle or a line; NoCorridorError for a path that changes it."""
    system = reference(setup.scenario)
    v_d = ca.vertcat(*(item.expr for item in system.outputs[3:5]))
    if not is_steady(setup):
        raise NoCorridorError(
            "the desired velocity changes along the path: circles and lines alone are covered for "
            "good, other paths over a whole run (`check` with one law)"
        )
    return np.asarray(system.function("v_d", [v_d])([0.0] * system.u.numel(), system.x0, system.p0)
                      ).ravel()  # fmt: skip


def conditions(setup: Setup, force: ca.SX, v: ca.SX) -> list[Condition]:
    """Conditions under which neither the wheels' limit nor the guard changes a ``force`` (2)."""
    return [*_within_torque(setup, force), *_within_guard(setup, force, v)]


def _within_torque(setup: Setup, force: ca.SX) -> Iterator[Condition]:
    robot = setup.scenario.robot
    torque = force_to_wheel(ca.SX(robot.r), ca.SX(robot.l), force)
    if math.isfinite(setup.tau_max):
        for i, side in enumerate(("right", "left")):
            yield Condition(f"the torque of the {side} wheel", torque[i], ca.SX(setup.tau_max))


def _within_guard(setup: Setup, force: ca.SX, v: ca.SX) -> Iterator[Condition]:
    """The guard's own ceiling and floor, see `guard.ceiling` (ledger: corridor.guard)."""
    scenario, guard = setup.scenario, setup.guard
    if not scenario.guard.enabled:
        return
    for i, axis in enumerate(AXES):
        if net(guard, i) < 0:
            raise NoCorridorError(f"guard.f_min ({axis}) above guard.dbar is not covered")
    if counts_late(setup):
        if not is_plain(setup):
            raise NoCorridorError(
                "the guard counts a lag or late velocities, and whether it acts then is not "
                "covered: leave out what makes them late, or set guard.enabled = false"
            )
        return
    errors = pair_of(guard.nbar)
    for i, axis in enumerate(AXES):
        steep, top, left = slope(guard, i), aim(scenario, guard, i), net(guard, i)
        sizes = {
            f"the guard's ceiling ({axis})": (force[i] + steep * v[i], top - errors[i]),
            f"the guard's largest force ({axis})": (force[i], top - guard.f_speed[i]),
            f"the guard's safe point ({axis})": (steep * v[i], top - errors[i]),
        }
        for name, (value, room) in sizes.items():
            yield Condition(name, value, ca.SX(steep * room - left))
