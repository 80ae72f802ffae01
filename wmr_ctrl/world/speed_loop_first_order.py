"""First-order speed loop: tau v' = K u - v on each axis, pushes coming on top as force over mass.

Source: the usual model of a velocity-controlled base.  The loop knows the robot's true mass and
friction; held over a plant step h, its force takes the speed to where a first order takes it,

    F = M (K u - v)/s + F1(v),      s = h/(1 - exp(-h/tau)),

but for the change of the friction within the step, which pulls against every change of the speed.
A push f ends at the speed d = s f/M.
"""

from functools import partial

from wmr_ctrl.core.fields.section import Section, quantity
from wmr_ctrl.core.fields.unstated import derived
from wmr_ctrl.core.symbolic import ca

from .effect import Bound, Effect, EffectRole, Rate, Scenario
from .model.system import System
from .speed_loop import Drive, Servo, has_loop, speed_loop


class FirstOrderGains(Section, key="base"):
    """Time constants and gains of the first-order loop, per axis."""

    tau: tuple[float, float] = quantity(
        derived((0.2, 0.2)), "s", "time constants of the first-order loop", above=0, usual=(0, 5)
    )
    gain: tuple[float, float] = quantity(
        (1.0, 1.0),
        "1",
        "steady-state speed divided by the command, of the first-order loop",
        above=0,
        usual=(0.1, 10),
    )


def build(scenario: Scenario) -> System:
    """System of the plant's rate: commanded and true velocity to wheel torques [N m]."""
    return speed_loop(scenario, "first-order speed loop", _loop)


def _loop(servo: Servo) -> Drive:
    tau, gain = servo.p.take("base.tau"), servo.p.take("base.gain")
    return Drive(servo.mass * (gain * servo.u - servo.v) / reach(servo.h, tau) + servo.F1)


def reach(period: "ca.SX", tau: "ca.SX") -> "ca.SX":
    """s [s]: over a ``period`` [s] a first order changes by period/s of the way to its input."""
    return period / -ca.expm1(-period / tau)


def bound(scenario: Scenario) -> Bound:
    """The loop that the governor knows, unless a torque limit holds it back."""
    if scenario.actuator.tau_max < float("inf"):
        return Bound(hidden="actuator.tau_max: the speed is slower than first order at the limit.")
    return Bound()


acts = partial(has_loop, loop="first-order")
FIRST_ORDER = Effect(
    "first-order-loop", EffectRole.LOOP, FirstOrderGains, build, bound, acts=acts, rate=Rate.STEP
)
