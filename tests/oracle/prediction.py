"""View of a law that knows its delay: the robot and its target one delay later."""

import math
from dataclasses import astuple, replace

from tests.oracle.auxiliary import (
    auxiliary_rate,
    auxiliary_velocity,
    reference_rate,
    tracking_error,
)
from tests.oracle.observer import ForceObserver
from tests.oracle.target import DesiredState


class LawWithObserver:
    """A law that compensates its observer's disturbance and predicts over its delay."""

    def __init__(self, gains, scenario):
        self.gains, self.limits = gains, scenario.limits
        self.T, self.bot = scenario.clock.control, scenario.believed
        self.observer = ForceObserver(gains["wo"], scenario)
        self.predictor = Predictor(gains["delay"], scenario)

    def look(self, sight):
        """The observer's updated force and moment, and the predicted sight."""
        force = self.observer.look(sight)
        return force, self.predictor.ahead(sight, force)

    def memory(self):
        """The disturbance that the observer compensates."""
        return self.observer.memory()


class Predictor:
    """Prediction of a sight by ``delay`` [s] through the commands in transit."""

    def __init__(self, delay, scenario):
        self.delay, self.T, self.bot = delay, scenario.clock.control, scenario.believed
        self.count = math.ceil(delay / self.T - 1e-9)

    def ahead(self, sight, made_up):
        """The sight one delay later; ``made_up`` is the observer's force."""
        if not self.count:
            return sight
        pose, v = sight.pose, sight.v
        left = self.delay - (self.count - 1) * self.T
        waiting = [*sight.sent, *((0.0, 0.0),) * self.count]
        for age in reversed(range(self.count)):
            after = self._pushed(v, waiting[age], made_up, left)
            pose, v, left = _carried(pose, v, after, left), after, self.T
        return self._seen(sight, pose, v)

    def _seen(self, sight, pose, v):
        target = _later(sight.target, self.delay)
        e = tracking_error(target, pose)
        return replace(
            sight, v=v, pose=pose, target=target, e=e,
            v_c0=auxiliary_velocity(e, target, sight.k),
            v_c0_dot=auxiliary_rate(e, v, target, sight.k),
            v_c0_dot_reference=reference_rate(e, target, sight.k),
        )  # fmt: skip

    def _pushed(self, v, torque, made_up, time):
        """The velocity after a torque that acts for ``time``; friction can only stop it."""
        right, left = torque
        force, moment = (right + left) / self.bot.r, self.bot.l * (right - left) / self.bot.r
        free = v[0] + time * (force - made_up[0]) / self.bot.m
        drag = self.bot.mu * self.bot.g * math.tanh(abs(free) / self.bot.v_s)
        slowed = math.copysign(max(abs(free) - time * drag, 0.0), free)
        return slowed, v[1] + time * (moment - made_up[1]) / self.bot.I


def _carried(pose, v, after, time):
    x, y, theta = pose
    speed, turning = ((v[i] + after[i]) / 2.0 for i in (0, 1))
    middle = theta + time * turning / 2.0
    return (
        x - time * speed * math.sin(middle),
        y + time * speed * math.cos(middle),
        theta + time * turning,
    )


def _later(target, time):
    """The reference, extrapolated by its accelerations."""
    *pose, v1, v2, a1, a2 = astuple(target)
    then = (v1 + time * a1, v2 + time * a2)
    place = _carried((pose[0], pose[1], pose[2]), (v1, v2), then, time)
    return DesiredState(*place, *then, a1, a2)
