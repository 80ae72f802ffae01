"""Desired motions: where the robot should be at time t, and how fast it should go there.

Angles follow the project's convention: 0 along +Y, forward = (-sin theta, cos theta).
"""

import math
from functools import partial

from tests.oracle.target import DesiredState, target_on
from wmr_ctrl.world.scenario import Circle, Lemniscate, Line, StopAndGo


def reference_of(kind):
    """The function of time t [s] that a scenario's reference describes."""
    return partial(KINDS[type(kind)], kind)


def circle(kind, t):
    """Counter-clockwise from the origin, centre (0, R), at the angular rate ``rate``."""
    R, w = kind.radius, kind.rate
    x, y = R * math.sin(w * t), R - R * math.cos(w * t)
    return DesiredState(x, y, w * t - math.pi / 2.0, R * w, w, 0.0, 0.0)


def line(kind, t):
    """Desired state on a line from ``origin`` straight ahead at ``speed``."""
    s = kind.speed * t
    x = kind.origin[0] - s * math.sin(kind.heading)
    y = kind.origin[1] + s * math.cos(kind.heading)
    return DesiredState(x, y, kind.heading, kind.speed, 0.0, 0.0, 0.0)


def stop_and_go(kind, t):
    """The circle at the speed (speed/2) (1 - cos(2 pi t/period)), which is 0 once a period."""
    R, w = kind.radius, 2.0 * math.pi / kind.period
    half = kind.speed / 2.0
    arc = half * (t - math.sin(w * t) / w) / R
    v1, v1_dot = half * (1.0 - math.cos(w * t)), half * w * math.sin(w * t)
    x, y = R * math.sin(arc), R - R * math.cos(arc)
    return DesiredState(x, y, arc - math.pi / 2.0, v1, v1 / R, v1_dot, v1_dot / R)


def lemniscate(kind, t):
    """Gerono's figure of eight, x = a sin p, y = a sin p cos p with p = rate t."""
    a, w = kind.size, kind.rate
    s, c = math.sin(w * t), math.cos(w * t)
    s2, c2 = 2.0 * s * c, c * c - s * s
    rate = (a * w * c, a * w * c2)
    # The direction never leaves 3/4 pi about -Y, so measured from there its angle has no jump.
    theta = math.atan2(rate[0], -rate[1]) - math.pi
    rate2 = (-a * w**2 * s, -2.0 * a * w**2 * s2)
    rate3 = (-a * w**3 * c, -4.0 * a * w**3 * c2)
    return target_on((a * s, a * s * c), theta, rate, rate2, rate3)


KINDS = {Circle: circle, Line: line, Lemniscate: lemniscate, StopAndGo: stop_and_go}
