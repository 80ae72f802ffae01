"""PI speed loop: F = kp (u - v) + f, f' = ki (u - v), on the true mass, inertia and friction.

Source: the loop of most firmware, on each wheel.  For equal wheels it is equivalent to one loop of
v and one of omega, whose moment is l^2 times as much; kp and ki are those of both wheels together
at the rim.  It overshoots: after a step the speed exceeds its command.  Behind a torque limit f
winds up.  With ``antiwindup`` f is frozen while the wheels give another force than requested and
the error would increase the difference.
"""

from __future__ import annotations

from wmr_ctrl.core.fields.section import Section, quantity
from wmr_ctrl.core.fields.unstated import unknown
from wmr_ctrl.core.signals import Signal
from wmr_ctrl.core.symbolic import ca

from .model.dynamics import wheel_to_force
from .speed_loop import Drive, Loop, Numbers, Servo

INTEGRAL = Signal("f_integral", "N, N.m", "integral force of the speed loop", 2)


class PiLoopGains(Section, key="base"):
    """Gains of the PI loop: of both wheels together, at their rim."""

    kp: float = quantity(
        unknown(3.0), "N.s/m", "gain of the PI loop, both wheels together; default: 3 m", above=0
    )
    ki: float = quantity(
        unknown(6.0),
        "N/m",
        "integral gain of the PI loop, both wheels together; default: 6 m",
        minimum=0,
    )
    antiwindup: bool = quantity(True, "1", "stop the integral while the wheels are at their limit")


def _lever(take: Numbers, axis: int) -> ca.SX:
    """Factor from a loop at both wheels' rims to the axis' own: 1 for v, l^2 [m2] for omega."""
    return take("robot.l")[0] ** 2 if axis else ca.SX(1)


def _drive(servo: Servo) -> Drive:
    take, axis, integral = servo.p.take, servo.axis, servo.own
    error = _lever(take, axis) * (servo.u - servo.v)
    pull = take("base.ki") * error

    def following(missing: ca.SX) -> ca.SX:
        if not servo.scenario.section(PiLoopGains).antiwindup:
            return integral + servo.h * pull
        given = wheel_to_force(take("robot.r"), take("robot.l"), missing)[axis]
        return integral + servo.h * ca.if_else(given * pull < 0, 0, pull)

    return Drive(take("base.kp") * error + integral, following)


def _lag(take: Numbers, axis: int, mass: ca.SX) -> ca.SX:
    return mass / (take("base.kp")[0] * _lever(take, axis))


PI = Loop((PiLoopGains,), _drive, _lag, INTEGRAL)
