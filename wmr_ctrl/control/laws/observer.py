"""Momentum observer of the force that the model does not explain.

Source: the usual first-order disturbance observer, here on the force that was applied, so a torque
limit or a guard cannot wind it up.  Per sample, with the believed mass M and friction F1,

    residual = F_applied - M (v_k - v_(k-1))/T - F1((v_k + v_(k-1))/2)
    f_k      = f_(k-1) + (1 - exp(-wo T)) (residual - f_(k-1))

and f is added to the law's force; the disturbance that it stands for is -f.
"""

from collections.abc import Callable

import casadi as ca

from wmr_ctrl.core.signals import D_HAT, TAU_APPLIED, Signal
from wmr_ctrl.world.model.dynamics import wheel_to_force
from wmr_ctrl.world.model.system import Output, ports

from .context import LawContext

FORCE_HAT = Signal("f_hat", "N, N.m", "force that makes up for the disturbance", 2)
OLD_VELOCITY = Signal("v_previous", "m/s, rad/s", "measured velocity of the previous sample", 2)
STARTED = Signal("started", "1", "0 before the first sample, then 1")


class Observer:
    """State, update and force of the observer of a law's Sample.

    The law takes a further input, tau_applied (2,) [N m].
    """

    def __init__(
        self, context: LawContext, rate: ca.SX, friction: Callable[[ca.SX], ca.SX]
    ) -> None:
        """Observe with bandwidth ``rate`` [1/s]; ``friction`` gives F1 (2,) at a velocity."""
        applied, f_hat, old, started = ports((TAU_APPLIED, FORCE_HAT, OLD_VELOCITY, STARTED))
        take = context.parameters.take
        force = wheel_to_force(take("robot.r"), take("robot.l"), applied.sym)
        gained = (context.v - old.sym) / context.period
        residual = force - context.mass * gained - friction(0.5 * (context.v + old.sym))
        share = -ca.expm1(-rate * context.period)
        updated = f_hat.sym + share * (residual - f_hat.sym)
        self.force = ca.if_else(started.sym > 0, updated, f_hat.sym)
        self.input, self.started = applied, started.sym
        self.state = (f_hat, old, started)
        self.update = ca.vertcat(self.force, context.v, 1)
        self.diagnostics = (Output(D_HAT, -self.force),)
