"""PI speed loop: F = kp (u - v) + f, f' = ki (u - v), on the true mass, inertia and friction.

Source: the loop that most firmware runs, on each wheel.  Wheels that are alike make it one loop of
v and one of omega, whose moment is l^2 times as much, kp and ki being those of both wheels together
at the rim.  It overshoots: after a step the speed exceeds its command.  Behind a torque limit f
winds up; with ``antiwindup`` it rests while the wheels give another force than the loop wants and
the error would drive it further that way.
"""

from functools import partial

from wmr_ctrl.core.fields.section import Section, quantity
from wmr_ctrl.core.fields.unstated import unknown
from wmr_ctrl.core.signals import Signal
from wmr_ctrl.core.symbolic import ca

from .effect import Bound, Effect, EffectRole, Rate, Scenario
from .model.dynamics import wheel_to_force
from .model.system import System, port
from .speed_loop import Drive, Servo, has_loop, speed_loop

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


def build(scenario: Scenario) -> System:
    """System of the plant's rate: commanded and true velocity to wheel torques [N m]."""
    resting = scenario.section(PiLoopGains).antiwindup
    return speed_loop(scenario, "PI speed loop", lambda servo: _drive(servo, resting))


def _drive(servo: Servo, resting: bool) -> Drive:
    integral, take = port(INTEGRAL), servo.p.take
    half_track = take("robot.l")
    error = ca.vertcat(1, half_track**2) * (servo.u - servo.v)
    pull = take("base.ki") * error

    def following(missing: ca.SX) -> ca.SX:
        if not resting:
            return integral.sym + servo.h * pull
        held = wheel_to_force(take("robot.r"), half_track, missing) * pull < 0
        return integral.sym + servo.h * ca.if_else(held, 0, pull)

    return Drive(take("base.kp") * error + integral.sym, (integral,), following)


def bound(scenario: Scenario) -> Bound:
    """No bound on its own: the speed passes its command."""
    return Bound(overshoots='base.loop = "pi": after a step the speed exceeds its command.')


acts = partial(has_loop, loop="pi")
PI = Effect("pi-loop", EffectRole.LOOP, PiLoopGains, build, bound, acts=acts, rate=Rate.STEP)
