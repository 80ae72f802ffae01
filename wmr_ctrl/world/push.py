"""Push: an adversary that pushes each axis in its direction of motion, and forward at rest.

Source: none in the paper; the worst disturbance of a given size for a limit on the velocity.  It
acts as torque at the wheels and is held over a control period.
"""

from wmr_ctrl.core.fields.section import Section, quantity
from wmr_ctrl.core.signals import TORQUE_NOISE, VELOCITY
from wmr_ctrl.core.symbolic import ca

from .effect import Bound, Effect, EffectRole, Scenario
from .model.dynamics import force_to_wheel
from .model.system import Parameters, System, outputs, ports, stack


class Push(Section, key="disturbance"):
    """Size of the push."""

    push: tuple[float, float] = quantity(
        (0.0, 0.0), "N, N.m", "force that always pushes away from rest", minimum=0
    )


def build(scenario: Scenario) -> System:
    """Sampled System: true velocity to wheel torques [N m]."""
    velocity, p = ports(VELOCITY), Parameters(scenario)
    v, size = stack(item.sym for item in velocity), p.take("disturbance.push")
    force = ca.if_else(v < 0, -size, size)
    torque = force_to_wheel(p.take("robot.r"), p.take("robot.l"), force)
    shown = outputs(TORQUE_NOISE, torque)
    return System(
        "push", "push in the direction of motion", inputs=velocity, params=p.ports, outputs=shown
    )


def bound(scenario: Scenario) -> Bound:
    """Its own size: it is a force [N, N m] (ledger: world.push)."""
    return Bound(dbar=scenario.section(Push).push)


PUSH = Effect("push", EffectRole.DISTURBANCE, Push, build, bound, always=True)
