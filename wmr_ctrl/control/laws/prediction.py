"""Prediction to the time when a command acts, for drives with a delay.

Source: the usual predictor of a delayed input, with the law's own model.  A command that is
computed at a sample acts one delay later.  Until then the commands F_j in transit act; the one sent
j periods ago acts for

    tau_j = max(delay - (j-1) T, 0) - max(delay - j T, 0),    together the delay.

From the oldest on, with the believed mass M and friction F1, and the observer's force f,

    u  = v + tau_j (F_j - f)/M,     v+ = u - cut(tau_j F1(u)/M, |u|)
    q+ = q + tau_j H(theta + tau_j omega'/2) v',                   v' = (v + v+)/2

so friction stops the robot and never reverses it.  The reference is extrapolated in the same way by
its v_d'. The law is evaluated for that later instant, as if the drives had no delay.  Noise until
then remains unknown.  The stated delay must not exceed the true one: a law that predicts with
commands that have already acted oscillates.  The guard's rule is the reverse, so this is a separate
field, ``delay`` of the law's gains.
"""

import casadi as ca

from wmr_ctrl.core.signals import tau_sent
from wmr_ctrl.world.model.dynamics import wheel_to_force
from wmr_ctrl.world.model.kinematics import pose_rate
from wmr_ctrl.world.model.system import Port, ports

from .context import LawContext


def ahead(context: LawContext, made_up: ca.SX) -> tuple[LawContext, tuple[Port, ...]]:
    """The sample one delay later, and the inputs that hold the commands in transit.

    ``made_up`` (2,) [N, N m] is the observer's force f.  Without delay it is the sample itself.
    """
    if not context.in_flight:
        return context, ()
    delay = ca.fmin(context.gain("delay"), context.in_flight * context.period)
    take = context.parameters.take
    sent = ports(map(tau_sent, range(1, context.in_flight + 1)))
    pose, v = context.pose, context.v
    for age in range(context.in_flight, 0, -1):
        force = wheel_to_force(take("robot.r"), take("robot.l"), sent[age - 1].sym)
        time = acts_for(age, delay, context.period)
        after = pushed(context, v, force - made_up, time)
        pose, v = carried(pose, v, after, time), after
    v_d = context.v_d + delay * context.v_d_dot
    pose_d = carried(context.pose_d, context.v_d, v_d, delay)
    return context.at((pose_d, v_d, context.v_d_dot), pose, v), sent


def acts_for(age: int, delay: ca.SX, period: ca.SX) -> ca.SX:
    """tau_j [s]: time for which a command sent ``age`` periods ago still acts, within the delay."""
    return ca.fmax(delay - (age - 1) * period, 0) - ca.fmax(delay - age * period, 0)


def pushed(context: LawContext, v: ca.SX, force: ca.SX, time: ca.SX) -> ca.SX:
    """v+ (2,) after a ``force`` (2,) [N, N m] that is held for ``time`` [s], reduced by
    friction.
    """
    free = v + time * force / context.mass
    return slowed(free, time * context.friction_at(free) / context.mass)


def slowed(free: ca.SX, taken: ca.SX) -> ca.SX:
    """A velocity reduced by friction, at most to 0."""
    most = ca.fabs(free)
    return free - ca.fmax(-most, ca.fmin(most, taken))


def carried(pose: ca.SX, v: ca.SX, after: ca.SX, time: ca.SX) -> ca.SX:
    """Pose (3,) after ``time`` [s] in which the velocity (2,) changes from v to ``after``."""
    mean = v / 2 + after / 2
    return pose + time * pose_rate(pose[2] + time * mean[1] / 2, mean)
