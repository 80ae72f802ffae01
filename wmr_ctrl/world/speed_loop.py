"""Speed loop of a base that takes velocities: wheel torques from a command and the true speed.

Source: bases as they are sold, whose firmware runs a loop of its own.  The loop acts in every plant
step on the true robot, so friction, mass and pushes are what they are elsewhere; each wheel gives
at most actuator.tau_max.  A kind of loop is one file: `speed_loop_first_order`, `speed_loop_pi`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from wmr_ctrl.core.fields.section import Section, quantity
from wmr_ctrl.core.signals import COMMAND, TORQUE, VELOCITY, Signal
from wmr_ctrl.core.symbolic import ca

from .model.dynamics import KEYS, force_to_wheel, reduced_mass
from .model.friction import friction
from .model.system import Parameters, Port, System, outputs, port, ports, stack

if TYPE_CHECKING:
    from .scenario import Scenario

KINDS = ("torque", "velocity")
LOOPS = ("first-order", "pi")
EXERTED = Signal("tau_exerted", "N.m", "torque of the speed loop (right, left)", 2)
"""State of every speed loop: what it exerted over the plant step that has ended."""


class BaseKind(Section, key="base"):
    """Input of the base, and the speed loop of one that takes velocities."""

    kind: str = quantity("torque", "1", "input of the base", options=KINDS)
    loop: str = quantity("first-order", "1", "speed loop of the base", options=LOOPS)


def has_loop(scenario: Scenario, loop: str) -> bool:
    """True where this kind of speed loop drives the base."""
    return scenario.takes_velocity and scenario.section(BaseKind).loop == loop


@dataclass(frozen=True)
class Drive:
    """Force (2,) [N, N m] that a speed loop wants, and its own state.

    ``update(given)``: the next state for the force that the wheels really give.
    """

    force: ca.SX
    state: tuple[Port, ...] = ()
    update: Callable[[ca.SX], ca.SX] = lambda _: ca.SX(0, 1)


@dataclass(frozen=True)
class Servo:
    """Quantities of a plant step that a speed loop may use.

    ``u`` command and ``v`` true velocity (2,) [m/s, rad/s], ``mass`` (2,) [kg, kg m2], ``F1`` the
    friction at v (2,) [N, N m], ``h`` the step [s].
    """

    p: Parameters
    u: ca.SX
    v: ca.SX
    mass: ca.SX
    F1: ca.SX
    h: ca.SX


def speed_loop(scenario: Scenario, title: str, loop: Callable[[Servo], Drive]) -> System:
    """System of the plant's rate: commanded and true velocity to wheel torques [N m]."""
    command, velocity, p = ports(COMMAND), ports(VELOCITY), Parameters(scenario)
    u, v = (stack(item.sym for item in side) for side in (command, velocity))
    m, inertia, mu, r, half_track, g, v_s = map(p.take, KEYS)
    F1 = friction(mu, m, g, v_s, v)
    own = loop(Servo(p, u, v, reduced_mass(m, inertia), F1, p.take("clock.plant")))
    most = p.take("actuator.tau_max")
    wanted = force_to_wheel(r, half_track, own.force)
    torque = ca.fmax(-most, ca.fmin(most, wanted))
    exerted = port(EXERTED)
    return System(
        "speed_loop",
        title,
        inputs=(*command, *velocity),
        state=(exerted, *own.state),
        params=p.ports,
        update=ca.vertcat(torque, own.update(torque - wanted)),
        outputs=outputs(TORQUE, torque),
    )
