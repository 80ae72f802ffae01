"""Cost of the guard: the steady speeds that it allows, compared with the reference's."""

from dataclasses import dataclass
from functools import lru_cache

from wmr_ctrl.world.phases import largest_friction
from wmr_ctrl.world.references.kind import reference_spans
from wmr_ctrl.world.scenario import Robot, Scenario

from .bounds import AXES, GuardNumbers, Pair, mass_range, net, pair_of, slope


@dataclass(frozen=True)
class SpeedPrice:
    """Speeds of both axes [m/s, rad/s], for the largest friction of the run.

    Each is for the direction, forwards or backwards, in which the reference needs the larger share
    of the usable speed.  ``usable``: largest steady speeds that the guard admits.  ``unbeatable``:
    no guard can admit more.  ``asked``: largest speeds of the reference.
    """

    usable: Pair
    unbeatable: Pair
    asked: Pair

    @property
    def short(self) -> tuple[bool, bool]:
        """True, per axis, if the reference is faster than the usable speed."""
        return self.asked[0] > self.usable[0], self.asked[1] > self.usable[1]


@lru_cache(maxsize=64)
def speed_price(scenario: Scenario, guard: GuardNumbers) -> SpeedPrice:
    """Usable speeds by `usable_speed`; friction acts on v1 and not on turning."""
    friction = (largest_friction(scenario), 0.0)
    limits, spans = scenario.limits, reference_spans(scenario)
    sizes, asked = [0.0, 0.0], [0.0, 0.0]
    for i, (low, high) in enumerate(spans):
        ways = (high, limits.v_max[i]), (-low, -limits.v_min[i])
        wanted, sizes[i] = max(ways, key=lambda way: way[0] - way[1])
        asked[i] = max(wanted, 0.0)
    most = sizes[0], sizes[1]
    return SpeedPrice(
        usable_speed(scenario, guard, friction, most),
        unbeatable_speed(scenario, guard, friction, most),
        (asked[0], asked[1]),
    )


def usable_speed(
    scenario: Scenario, guard: GuardNumbers, friction: Pair, limits: Pair | None = None
) -> Pair:
    """Largest steady speeds that the guard admits against ``friction`` [N, N m], per axis.

    ``limits``: of the directions in question, by default the smaller one of both.  See
    `usable_formula`.  The speed is negative if the guard would not let the robot move at all.  That
    is also so if the effect of the whole window, without the measured speed, exceeds v_u1 -
    f_speed.
    """
    most = limits or scenario.limits.smaller
    first, second = (_usable(scenario, guard, friction[i], i, most[i]) for i in AXES)
    return first, second


def usable_formula(guard: GuardNumbers, axis: int) -> str:
    """Formula of `usable_speed` as text, with the times that ``guard`` has."""
    late = guard.age[axis] or guard.window[axis] or guard.slowest
    time = "age + window/2 + delay + lag" if late else "delay"
    return f"v_u1 - nbar - ({('friction + ', '')[axis]}dbar - f_min) (1/alpha + {time})/M_min"


def _usable(scenario: Scenario, guard: GuardNumbers, friction: float, i: int, u1: float) -> float:
    late, force = guard.lateness(scenario.clock)[i], friction + net(guard, i)
    nbar, period = pair_of(guard.nbar)[i], scenario.clock.control
    first, least = 1.0 / float(guard.alpha or 0.0), mass_range(guard, i)[0]
    mean = u1 - nbar - force * (first + period * late.usual) / least
    rest = u1 - guard.f_speed[i] - force * (first + period * late.most) / least
    return mean if rest >= 0 else min(mean, rest)


def unbeatable_speed(
    scenario: Scenario, guard: GuardNumbers, friction: Pair, limits: Pair | None = None
) -> Pair:
    """Steady speeds that no guard can exceed; arguments as in `usable_speed`.

    v_u1 - nbar - (friction + dbar - f_min) (T + age + delay)/M. The friction that a steady force
    overcomes may vanish, and the push begin, just after a sample's velocity was measured.  That
    sample's command acts until T + delay after it.
    """
    most = limits or scenario.limits.smaller
    first, second = (
        most[i]
        - pair_of(guard.nbar)[i]
        - (friction[i] + net(guard, i))
        * (scenario.clock.control + guard.age[i] + guard.latest)
        / mass_range(guard, i)[0]
        for i in AXES
    )
    return first, second


def early_speed(guard: GuardNumbers) -> Pair:
    """Speed that a push can add before the first command acts (behind a lag: has acted).

    (delay + lag) (dbar - f_min)/M [m/s, rad/s], with M the smallest mass or inertia.
    """
    time = guard.latest + guard.slowest
    first, second = (time * max(net(guard, i), 0.0) / mass_range(guard, i)[0] for i in AXES)
    return first, second


def torque_swing(robot: Robot, guard: GuardNumbers, axis: int) -> float:
    """Swing of a wheel's torque [N m] that errors of the measured velocity cause at the limit.

    The guard's ceiling falls by M_min alpha for each m/s of measured velocity.  Errors of -nbar to
    nbar move it, and the velocity that they cause moves it by the same amount again: in total by up
    to 4 nbar M_min alpha.  The sum of the response's absolute values is 2 for alpha T <= 1.
    """
    arm = robot.r / 2 if axis == 0 else robot.r / (2 * robot.l)
    return 4 * pair_of(guard.nbar)[axis] * slope(guard, axis) * arm
