"""First-order speed loop: tau v' = K u - v on each axis, with pushes added as force over mass.

Source: the usual model of a velocity-controlled base.  The loop knows the robot's true mass and
friction.  Held over a plant step h, its force changes the speed as a first-order lag would:

    F = M (K u - v)/s + F1(v),      s = h/(1 - exp(-h/tau)),

except for the change of friction within the step, which opposes every change of the speed.  Under a
push f the speed ends at d = s f/M.
"""

from __future__ import annotations

from wmr_ctrl.core.fields.section import Section, quantity
from wmr_ctrl.core.fields.unstated import derived
from wmr_ctrl.core.symbolic import ca

from .speed_loop import Drive, Loop, Servo


class FirstOrderGains(Section, key="base"):
    """Time constants of the first-order loop, per axis."""

    tau: tuple[float, float] = quantity(
        derived((0.2, 0.2)), "s", "time constants of the first-order loop", above=0, usual=(0, 5),
        alike=True,
    )  # fmt: skip


class LoopGain(Section, key="base"):
    """Gains of the loops without an integral, per axis."""

    gain: tuple[float, float] = quantity(
        (1.0, 1.0), "1", "steady-state speed divided by the command, but of PI loops", above=0,
        usual=(0.1, 10), alike=True,
    )  # fmt: skip


def _drive(servo: Servo) -> Drive:
    tau, gain = (servo.p.take(key)[servo.axis] for key in ("base.tau", "base.gain"))
    return Drive(servo.mass * (gain * servo.u - servo.v) / reach(servo.h, tau) + servo.F1)


def reach(period: ca.SX, tau: ca.SX) -> ca.SX:
    """s [s]: in a ``period`` [s] a first-order lag covers the share period/s of the distance."""
    return period / -ca.expm1(-period / tau)


FIRST_ORDER = Loop(
    (FirstOrderGains, LoopGain),
    _drive,
    lambda take, axis, _: take("base.tau")[axis],
    overshoots=False,
)
