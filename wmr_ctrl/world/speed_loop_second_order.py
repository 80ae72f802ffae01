"""Second-order speed loop: v' = a, a' = w^2 (K u - v) - 2 z w a on each axis.

Source: the usual fit of a step response that overshoots; a first-order loop behind a lag of the
drives. w is the frequency, z the damping, K the gain (`speed_loop_first_order`).  The loop knows
the robot's true mass and friction.  Held over a plant step h, its force moves v to the loop's exact
value at the end, where its rate is a.  With E = exp(-z w h), e = K u - v, q = w sqrt(z^2 - 1) and
S, C = sinh(q h)/q, cosh(q h), with sine and cosine below z = 1,

    v+ = v + e - E ((C + z w S) e - S a),       a+ = E ((C - z w S) a + w^2 S e).

A push f is added as force over mass; under it the speed ends at 2 z/w f/M.
"""

from wmr_ctrl.core.fields.section import Section, quantity
from wmr_ctrl.core.fields.unstated import derived
from wmr_ctrl.core.signals import Signal
from wmr_ctrl.core.symbolic import ca

from .speed_loop import Drive, Loop, Servo
from .speed_loop_first_order import LoopGain

REACHED = Signal("a_reached", "m/s2, rad/s2", "acceleration that the speed loop has reached", 2)
NEAR = 1e-12
"""Least |1 - z^2| that is told from 0."""


class SecondOrderGains(Section, key="base"):
    """Frequencies and damping ratios of the second-order loop, per axis."""

    frequency: tuple[float, float] = quantity(
        derived((10.0, 10.0)), "rad/s", "natural frequencies of the second-order loop", above=0,
        alike=True, usual=(0.1, 500),
    )  # fmt: skip
    damping: tuple[float, float] = quantity(
        derived((1.0, 1.0)), "1", "damping ratios of the second-order loop", above=0, alike=True
    )


def _drive(servo: Servo) -> Drive:
    keys = ("base.frequency", "base.damping", "base.gain")
    w, z, gain = (servo.p.take(key)[servo.axis] for key in keys)
    h, e, a = servo.h, gain * servo.u - servo.v, servo.own
    swings, q = z < 1, w * ca.sqrt(ca.fmax(ca.fabs(1 - z**2), NEAR))
    fades, slow = ca.exp(-z * w * h), ca.exp((q - z * w) * h)
    S = ca.if_else(swings, fades * ca.sin(q * h) / q, slow * -ca.expm1(-2 * q * h) / (2 * q))
    C = ca.if_else(swings, fades * ca.cos(q * h), slow - q * S)
    change = e - (C + z * w * S) * e + S * a
    reached = (C - z * w * S) * a + w**2 * S * e
    return Drive(servo.mass * change / h + servo.F1, lambda _: reached)


SECOND_ORDER = Loop(
    (SecondOrderGains, LoopGain),
    _drive,
    lambda take, axis, _: 2 * take("base.damping")[axis] / take("base.frequency")[axis],
    REACHED,
)
