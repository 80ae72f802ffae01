"""Torque noise: Gaussian torque on each wheel, drawn once per control period and held over it.

Source: Section V of the paper adds such noise without saying more.
"""

import math

from wmr_ctrl.core.fields.section import Section, quantity
from wmr_ctrl.core.signals import TORQUE_NOISE, Signal

from .effect import Bound, Effect, EffectRole, Scenario
from .model.system import NORMAL, Number, Parameters, System, draw, outputs

SIGMAS = 3.0
"""Bound of noise without truncation, in standard deviations: it holds with a probability only."""
NUMBERS = Signal("torque", "1", "standard normal numbers (right, left)", 2)
_UNBOUNDED = (
    "disturbance.truncate = inf: torque noise beyond 3 std (or guard.dbar) can break the limits, "
    "since the guard assumes no more."
)


class TorqueNoise(Section, key="disturbance"):
    """Standard deviation and truncation of the noise."""

    std: float = quantity(0.0, "N.m", "standard deviation of the torque on each wheel", minimum=0)
    truncate: float = quantity(
        math.inf,
        "1",
        "noise beyond this many std is drawn again; inf: never",
        above=0,
        infinite=True,
    )


def build(scenario: Scenario) -> System:
    """Sampled System without inputs: std times standard normal numbers [N m]."""
    p = Parameters(scenario)
    std, truncate = p.take("disturbance.std"), p.take("disturbance.truncate")
    normal = draw(NUMBERS, NORMAL, std > 0, truncate)
    torque = std * normal.port.sym
    title, shown = "Gaussian torque on the wheels", outputs(TORQUE_NOISE, torque)
    return System("torque_noise", title, params=p.ports, outputs=shown, draws=(normal,))


def acts(scenario: Scenario) -> bool:
    """True if there is noise."""
    return scenario.section(TorqueNoise).std > 0


def bound(scenario: Scenario) -> Bound:
    """Both wheels at their largest, n std each; n is the truncation, or SIGMAS without one."""
    section, robot = scenario.section(TorqueNoise), scenario.robot
    sigmas = SIGMAS if math.isinf(section.truncate) else section.truncate
    most = noise_at_most(section.std, sigmas, (robot.r, robot.l))
    return Bound(dbar=most, void=_UNBOUNDED if unbounded(scenario) else "")


def unbounded(scenario: Scenario) -> bool:
    """True if there is noise without truncation."""
    return math.isinf(scenario.section(TorqueNoise).truncate) and acts(scenario)


def noise_at_most(
    std: Number, truncate: Number, believed: tuple[Number, Number]
) -> tuple[Number, Number]:
    """Thrust 2 n std/r [N] and l times that [N m] for n = ``truncate`` (ledger: world.noise.*).

    ``believed`` (r, l) [m]; numbers or symbols.
    """
    r, half_track = believed
    thrust = 2.0 * std * truncate / r
    return thrust, thrust * half_track


TORQUE_NOISE_EFFECT = Effect(
    "torque noise", EffectRole.DISTURBANCE, TorqueNoise, build, bound, acts=acts, always=True
)
