"""Desired motions: where the robot should be at time t, and how fast it should go there.

Angles follow the project's convention: 0 along +Y, forward = (-sin theta, cos theta).
"""

import math
from bisect import bisect_right

from tests.oracle.target import DesiredState, target_on
from wmr_ctrl.world.references.rounded_square import square_path
from wmr_ctrl.world.references.waypoints import LOOP, profile_of, waypoint_path
from wmr_ctrl.world.scenario import Circle, Lemniscate, Line, RoundedSquare, StopAndGo, Waypoints


def reference_of(kind):
    """The function of time t [s] that a scenario's reference describes."""
    if isinstance(kind, Circle):
        return lambda t: circle(kind, t)
    if isinstance(kind, Line):
        return lambda t: line(kind, t)
    if isinstance(kind, Lemniscate):
        return lambda t: lemniscate(kind, t)
    if isinstance(kind, StopAndGo):
        return lambda t: stop_and_go(kind, t)
    if isinstance(kind, RoundedSquare):
        return splined(square_path(kind))
    if isinstance(kind, Waypoints):
        path, profile = waypoint_path(kind), profile_of(kind)
        return lambda t: timed(path, profile, kind.at_end == LOOP, t)
    raise ValueError(f"the reference {type(kind).__name__} has no twin")


def circle(kind, t):
    """Counter-clockwise from the origin, centre (0, R), at the angular rate ``rate``."""
    R, w = kind.radius, kind.rate
    x, y = R * math.sin(w * t), R - R * math.cos(w * t)
    return DesiredState(x, y, w * t - math.pi / 2.0, R * w, w, 0.0, 0.0)


def line(kind, t):
    """From ``origin`` straight ahead at ``speed``."""
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


def splined(path):
    """The function of time t [s] that follows a spline path."""
    return lambda t: along(path, t)


def along(path, t):
    """A closed path is repeated; an open one goes on straight ahead after its end."""
    if path.closed:
        lap = math.floor(t / path.duration)
        return _on_path(path, t - lap * path.duration, lap * path.turn)
    return _on_path(path, t, 0.0) if t <= path.duration else _beyond(path, t - path.duration)


def timed(path, profile, laps, t):
    """Along a path whose parameter has its own, piecewise quadratic law of time."""
    lap = math.floor(t / profile.duration) if laps else 0
    inside = t - lap * profile.duration
    k = min(max(bisect_right(profile.starts, inside) - 1, 0), len(profile.starts) - 1)
    late, push = inside - float(profile.starts[k]), float(profile.accelerations[k])
    before = float(profile.rates[k])
    rate = max(before + push * late, 0.0)
    place = float(profile.places[k]) + late * (before + push * late / 2.0)
    here = _on_path(path, min(place, path.duration), lap * path.turn)
    beyond = max(place - path.duration, 0.0)
    return DesiredState(
        here.x - beyond * here.v1 * math.sin(here.theta),
        here.y + beyond * here.v1 * math.cos(here.theta),
        here.theta,
        here.v1 * rate,
        here.v2 * rate,
        here.v1_dot * rate**2 + here.v1 * push,
        here.v2_dot * rate**2 + here.v2 * push,
    )


def _on_path(path, t, turned):
    """Target at time ``t`` of the first lap, its orientation increased by ``turned``."""
    knots = path.knots
    i = min(max(bisect_right(knots, t) - 1, 0), len(knots) - 2)
    length = float(knots[i + 1] - knots[i])
    s = (t - float(knots[i])) / length
    place, rate, rate2, rate3 = (_derivative(path, i, s, n, length) for n in range(4))
    middle = float(path.headings[i])
    theta = math.atan2(rate[1], rate[0]) - math.pi / 2.0
    theta = middle + math.remainder(theta - middle, 2.0 * math.pi)  # the branch of the segment
    return target_on(place, theta + turned, rate, rate2, rate3)


def _derivative(path, i, s, order, length):
    """Derivative by time of segment ``i`` at its local parameter ``s``."""
    x = y = 0.0
    for power in range(path.coefficients.shape[1] - 1, order - 1, -1):
        factor = math.perm(power, order)
        x = x * s + factor * float(path.coefficients[i, power, 0])
        y = y * s + factor * float(path.coefficients[i, power, 1])
    return x / length**order, y / length**order


def _beyond(path, late):
    """Straight on at the last velocity, ``late`` seconds after the end of an open path."""
    end = _on_path(path, path.duration, 0.0)
    x = end.x - late * end.v1 * math.sin(end.theta)
    y = end.y + late * end.v1 * math.cos(end.theta)
    return DesiredState(x, y, end.theta, end.v1, 0.0, 0.0, 0.0)
