"""Gyro: measures omega directly, without delay, with a constant bias and noise.

Source: a gyro's data sheet; its bias is assumed constant over a run.  Its output replaces the omega
of other sensors.
"""

from wmr_ctrl.core.fields.section import Section, quantity
from wmr_ctrl.core.signals import MEASURED_VELOCITY, VELOCITY, Signal

from .effect import Bound, Effect, EffectRole, Scenario
from .model.system import UNIFORM, Number, Output, Parameters, System, draw, port

NUMBERS = Signal("gyro", "1", "uniform numbers on [-1, 1)", 2)


class Gyro(Section, key="gyro"):
    """Presence of a gyro, and its errors."""

    enabled: bool = quantity(False, "1", "whether omega is measured by a gyro")
    bias: float = quantity(0.0, "rad/s", "what it shows at rest")
    noise: float = quantity(0.0, "rad/s", "half-width of the uniform error", minimum=0)


def build(scenario: Scenario) -> System:
    """Sampled System: true omega to measured omega."""
    omega, p = port(VELOCITY[1]), Parameters(scenario)
    noise = p.take("gyro.noise")
    error = draw(NUMBERS, UNIFORM, noise > 0)
    shown = omega.sym + p.take("gyro.bias") + noise * error.port.sym[0]
    given = (Output(MEASURED_VELOCITY[1], shown),)
    return System("gyro", "gyro", inputs=(omega,), params=p.ports, outputs=given, draws=(error,))


def axes_without_gyro(scenario: Scenario) -> tuple[int, ...]:
    """Axes (0 linear, 1 angular) whose velocity is measured by other sensors."""
    return (0,) if scenario.section(Gyro).enabled else (0, 1)


def bound(scenario: Scenario) -> Bound:
    """The largest error of omega (ledger: world.gyro)."""
    gyro = scenario.section(Gyro)
    return Bound(nbar=(0.0, off_by(gyro.bias, gyro.noise)))


def off_by(bias: Number, noise: Number) -> Number:
    """Largest error [rad/s], for numbers or symbols."""
    return abs(bias) + noise


GYRO = Effect("gyro", EffectRole.SENSOR, Gyro, build, bound, switches=("enabled",))
