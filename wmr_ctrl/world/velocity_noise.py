"""Velocity noise: a uniform error of each measured velocity, drawn at every sample."""

from wmr_ctrl.core.fields.section import Section, quantity
from wmr_ctrl.core.signals import MEASURED_VELOCITY, Signal
from wmr_ctrl.core.symbolic import ca

from .effect import Bound, Effect, EffectRole, Scenario
from .model.system import UNIFORM, Parameters, System, draw, outputs, ports, stack

NUMBERS = Signal("velocity", "1", "uniform numbers on [-1, 1)", 2)


class VelocityNoise(Section, key="sensor"):
    """Half-widths of the error."""

    velocity_noise: tuple[float, float] = quantity(
        (0.0, 0.0), "m/s, rad/s", "half-widths of the uniform error in v1, omega", minimum=0
    )


def build(scenario: Scenario) -> System:
    """Sampled System: measured velocity to measured velocity."""
    velocity, p = ports(MEASURED_VELOCITY), Parameters(scenario)
    v, half = stack(item.sym for item in velocity), p.take("sensor.velocity_noise")
    error = draw(NUMBERS, UNIFORM, ca.logic_or(half[0] > 0, half[1] > 0))
    shown = outputs(MEASURED_VELOCITY, v + half * error.port.sym)
    title = "noise of the measured velocity"
    return System(
        "velocity_noise", title, inputs=velocity, params=p.ports, outputs=shown, draws=(error,)
    )


def bound(scenario: Scenario) -> Bound:
    """The half-widths: the error never exceeds them (ledger: world.velocity-noise)."""
    return Bound(nbar=scenario.section(VelocityNoise).velocity_noise)


VELOCITY_NOISE = Effect(
    "velocity noise", EffectRole.SENSOR, VelocityNoise, build, bound, always=True
)
