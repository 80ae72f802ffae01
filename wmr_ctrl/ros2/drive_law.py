"""The law of ``wmr_drive`` as C: an odometry message and a reference to velocities or torques.

Messages are in the frames of REP-103: x forward and yaw from +X, where the laws' theta is from +Y.
Positions, speeds and turns agree; theta = yaw - pi/2.  A pose is in the frame ``odom`` of REP-105,
which is continuous; one in ``map`` jumps by design and is no feedback.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from wmr_ctrl.control.controller import controller, unfiltered_controller
from wmr_ctrl.control.filter.channels import SENT
from wmr_ctrl.control.setup import Setup, settle
from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.core.fields.orientation import theta_of
from wmr_ctrl.core.signals import (
    POSE,
    REFERENCE,
    SAMPLE,
    SENT_BEFORE,
    TIME,
    TRACKING_ERROR,
    VELOCITY,
    Signal,
    elements,
)
from wmr_ctrl.core.symbolic import ca
from wmr_ctrl.world.model.evaluate import evaluated
from wmr_ctrl.world.model.kinematics import tracking_error
from wmr_ctrl.world.model.system import Output, System, port, stack
from wmr_ctrl.world.references.kind import reference
from wmr_ctrl.world.references.waypoints import Waypoints
from wmr_ctrl.world.scenario import Scenario, override

from .compiled_system import PAIR, CompiledSystem

QUATERNION = Signal("quaternion", "1", "orientation (x, y, z, w), REP-103", 4)
NEAR = Signal("theta_near", "rad", "orientation of the sample before")
MESSAGE = (*POSE[:2], QUATERNION, *VELOCITY)
"""Numbers of an odometry message that a law reads, in order: x, y, orientation, v, omega."""


def heading(quaternion: ca.SX, near: ca.SX) -> ca.SX:
    """Theta [rad] of an orientation ``quaternion`` (x, y, z, w), for any tilt.

    Of all equivalent angles it is the one nearest to ``near`` [rad], so that it is continuous at
    +-pi.
    """
    theta = theta_of(ca.vertsplit(quaternion), ca.atan2)
    turns = ca.floor((near - theta) / (2 * ca.pi) + 0.5)
    return theta + 2 * ca.pi * turns


def law_system(setup: Setup) -> System:
    """The law and all steps up to the gate; with torques these include guard and wheel map.

    Inputs: reference, odometry message, previous theta, and v_sent if velocities are sent. Outputs:
    v_asked, or tau_right and tau_left; theta; e.
    """
    core = unfiltered_controller(setup) if setup.takes_velocity else controller(setup)
    own = {item.signal: item for item in core.inputs}
    desired = [own.get(signal) or port(signal) for signal in REFERENCE]
    seen = [own.get(signal) or port(signal) for signal in MESSAGE]
    near, orientation = port(NEAR), seen[MESSAGE.index(QUATERNION)].sym
    theta = heading(orientation, near.sym)
    sent = [own[SENT]] if SENT in own else []
    pose = ca.vertcat(seen[0].sym, seen[1].sym, theta)
    e = tracking_error(stack(item.sym for item in desired[:3]), pose)
    old = own[POSE[2]].sym if POSE[2] in own else ca.SX(0, 1)
    given = [core.update, *(item.expr for item in core.outputs)]
    update, *y = ca.substitute(given, [old], [theta]) if old.numel() else given
    signals = [item.signal for item in core.outputs]
    return replace(
        core,
        inputs=(*desired, *seen, near, *sent),
        update=update,
        outputs=(*map(Output, signals, y), Output(POSE[2], theta), Output(TRACKING_ERROR, e)),
        diagnostics=(),
    )


@dataclass(frozen=True)
class Wish:
    """Output of a law: (v [m/s], omega [rad/s]) or wheel torques (right, left) [N m].

    ``theta`` [rad]; ``e`` the tracking error, Eq. (8) [m, m, rad].
    """

    command: tuple[float, float]
    theta: float
    e: tuple[float, float, float]


class DriveLaw:
    """A law's C function and its memory."""

    def __init__(self, setup: Setup) -> None:
        """Compile the graph, or load it from the cache.  Raises CompilerError."""
        system = law_system(setup)
        self._function = CompiledSystem(system, "drive")
        self._told = setup.takes_velocity
        names = elements(item.signal for item in system.state)
        before = elements([SENT_BEFORE])
        self._before = [names.index(name) for name in before if name in names]
        self._u: tuple[float, ...] = ()

    def start(self, sent: tuple[float, float] = PAIR) -> None:
        """Reset; ``sent`` is the last command that was sent [m/s, rad/s]."""
        self._function.start()
        if self._told:
            for place, value in zip(self._before, sent, strict=True):
                self._function.x[place] = value

    def wish(self, desired: Sequence[float], message: Sequence[float], near: float) -> Wish:
        """The law's output for a reference (7) and a message (8), in the order of `MESSAGE`."""
        self._u = (*desired, *message, near)
        first, second, theta, *e = self._function.look((*self._u, *(PAIR if self._told else ())))
        return Wish((first, second), theta, (e[0], e[1], e[2]))

    def remember(self, sent: tuple[float, float]) -> None:
        """Commit the law's next state; ``sent`` is the velocity really sent [m/s, rad/s]."""
        if self._told:
            self._function.look((*self._u, *sent))
        self._function.move()


class Interpreted:
    """A System in CasADi's virtual machine, so that nothing is compiled while a robot waits."""

    def __init__(self, system: System) -> None:
        """Set the state to its start values."""
        dense = [ca.densify(item) for item in (system.update, system.y)]
        self._function = system.function("interpreted", dense)
        self._p, self._x = np.array(system.p0), np.array(system.x0)
        self._next = self._x

    def look(self, u: Sequence[float]) -> list[float]:
        """Compute the outputs for inputs ``u``; the state changes only with `move`."""
        self._next, y = evaluated(self._function, u, self._x, self._p)
        shown: list[float] = y.ravel().tolist()
        return shown

    def move(self) -> None:
        """Commit the state of the last `look`."""
        self._x = self._next


class DesiredMotion:
    """A scenario's reference, sample by sample; ``arrival`` [s], None if it never comes to rest."""

    def __init__(self, scenario: Scenario, *, compiled: bool = True) -> None:
        """Compile the graph, or interpret it.  Raises ArgumentError, CompilerError."""
        system = reference(scenario)
        self._stepper = CompiledSystem(system, "reference") if compiled else Interpreted(system)
        self._inputs = [item.signal for item in system.inputs]
        self._stateful, self._period = bool(system.state), scenario.clock.control
        self._sample = 0
        self.arrival = scenario.reference.arrival

    def at(self, sample: int, rest: float) -> list[float]:
        """The reference (7) ``rest`` [s] after a sample; with memory, at the sample itself."""
        for passed in self._passed(sample):
            self._look(passed, 0.0)
            self._stepper.move()
        return self._look(sample, rest)

    def _passed(self, sample: int) -> Iterator[int]:
        if self._stateful:
            yield from range(self._sample, sample)
            self._sample = max(sample, self._sample)

    def _look(self, sample: int, rest: float) -> list[float]:
        known = {TIME: sample * self._period + rest, SAMPLE: float(sample)}
        return self._stepper.look([known[signal] for signal in self._inputs])


def check_follows(scenario: Scenario) -> None:
    """Raise ScenarioError if a scenario does not say how fast a path is driven."""
    if not isinstance(scenario.reference, Waypoints):
        raise ScenarioError(
            "reference:=path needs a scenario whose reference says how a path is driven: set "
            'reference.kind = "waypoints" with speed, omega_max, a_max and alpha_max. Its points '
            "are replaced by the path's."
        )


def path_motion(
    scenario: Scenario, law: str, points: Sequence[tuple[float, float]]
) -> DesiredMotion:
    """The motion along a path's points, with the limits of the scenario's waypoints.

    Raises ScenarioError if no path through the points can be driven.
    """
    followed = override(scenario, {"reference.points": [list(point) for point in points]})
    settle(followed, law)
    return DesiredMotion(followed, compiled=False)
