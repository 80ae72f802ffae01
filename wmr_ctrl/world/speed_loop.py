"""Common parts of all kinds of speed loops, for bases that take velocities.

Source: commercial bases, whose firmware runs its own loop.  The loop acts in every plant step on
the true robot, so friction, mass and pushes act as elsewhere; each wheel gives at most
actuator.tau_max.  A kind of loop is one file, such as `speed_loop_pi`, and drives one axis;
`speed_loops` joins both axes and turns their forces into torques.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias

from wmr_ctrl.core.fields.section import Section, quantity
from wmr_ctrl.core.signals import Signal
from wmr_ctrl.core.symbolic import ca

from .model.system import Parameters

if TYPE_CHECKING:
    from .scenario import Scenario

KINDS = ("torque", "velocity")
LOOPS = ("first-order", "second-order", "pi")
EXERTED = Signal("tau_exerted", "N.m", "torque of the speed loop (right, left)", 2)
"""State of every speed loop: what it exerted over the plant step that has ended."""


class BaseKind(Section, key="base"):
    """Input of the base, and the speed loops of one that takes velocities."""

    kind: str = quantity("torque", "1", "input of the base", options=KINDS)
    loop: tuple[str, str] = quantity(
        ("first-order", "first-order"), "1", "speed loop of v and of omega", kind="text", size=2,
        options=LOOPS, alike=True,
    )  # fmt: skip


def has_loop(scenario: Scenario, loop: str, axes: Sequence[int] = (0, 1)) -> bool:
    """True if this kind of speed loop drives all of these axes of the base."""
    loops = scenario.section(BaseKind).loop
    return scenario.takes_velocity and all(loops[axis] == loop for axis in axes)


Numbers: TypeAlias = "Callable[[str], ca.SX]"
"""Values of a scenario's keys, as symbols or as numbers."""


@dataclass(frozen=True)
class Drive:
    """Force [N, N m] that the speed loop of an axis requests.

    ``following(given)``: the loop's next state, for the force (2,) [N, N m] by which the wheels
    exceed both loops' request.
    """

    force: ca.SX
    following: Callable[[ca.SX], ca.SX] = lambda _: ca.SX(0)


@dataclass(frozen=True)
class Servo:
    """Quantities of a plant step that the speed loop of an axis may use.

    ``u`` command and ``v`` true velocity [m/s, rad/s], ``mass`` [kg, kg m2], ``F1`` the friction at
    v [N, N m], ``h`` the step [s], ``own`` the loop's own state.
    """

    scenario: Scenario
    p: Parameters
    axis: int
    u: ca.SX
    v: ca.SX
    mass: ca.SX
    F1: ca.SX
    h: ca.SX
    own: ca.SX


@dataclass(frozen=True)
class Loop:
    """A kind of speed loop: its gains, the drive of an axis, and its own state, if it has one.

    ``lag(take, axis, mass)``: the time constant [s] that laws assume.
    """

    gains: tuple[type[Section], ...]
    drive: Callable[[Servo], Drive]
    lag: Callable[[Numbers, int, ca.SX], ca.SX]
    state: Signal | None = None
    overshoots: bool = True
