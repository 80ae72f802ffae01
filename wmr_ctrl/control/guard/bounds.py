"""The numbers that the guard assumes: stated, or derived from the scenario and its effects."""

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import asdict, dataclass, replace

from wmr_ctrl.core.fields.section import quantity
from wmr_ctrl.results import Assumptions
from wmr_ctrl.results.settings import stopping_force
from wmr_ctrl.world.effect import Bound, Effect, mass_bounds
from wmr_ctrl.world.model.dynamics import full_thrust
from wmr_ctrl.world.scenario import Guard, Scenario
from wmr_ctrl.world.scenario.sections import Clock

from .lateness import Counting, Since, Times, lateness, since_last

Pair = tuple[float, float]

ROUNDING = 2.0**-44
"""The guard aims at v_u1 (1 - ROUNDING): more than its rounding errors can add up to.

Every command in transit adds another ROUNDING (see `rounding`).
"""

MASS_KEYS = ("guard.M_min", "guard.M_max")
"""Keys of the smallest and the largest mass and inertia that a guard assumes."""
MASS_UNITS, SPEED_UNITS = ("kg", "kg m2"), ("m/s", "rad/s")
UNITS, AXES = ("N", "N m"), (0, 1)
LATENESS = ("delay", "lag", "age", "window")
"""Fields of GuardNumbers on late velocities and drives."""


def rounding(in_flight: int) -> float:
    """Share of v_u1 reserved for rounding, for ``in_flight`` commands."""
    return ROUNDING * (1 + in_flight)


class GuardNumbers(Guard):
    """A guard's numbers as stated or implied, whether or not they can be met.

    ``age`` and ``window`` are the totals over all sensors (`Bound`).
    """

    age: tuple[float, float] = quantity(
        (0.0, 0.0), "s", "age of the velocity that is measured, per axis", minimum=0
    )
    window: tuple[float, float] = quantity(
        (0.0, 0.0), "s", "time over which it is averaged, per axis", minimum=0
    )

    def relate(self) -> None:
        """Check nothing: an unguarded run may state numbers that no guard could meet."""

    @property
    def latest(self) -> float:
        """Largest delay of a command [s]."""
        return pair_of(self.delay)[1]

    @property
    def jitter(self) -> float:
        """Largest amount by which a command can be earlier than the latest [s]."""
        return pair_of(self.delay)[1] - pair_of(self.delay)[0]

    @property
    def slowest(self) -> float:
        """Largest time constant of the drives [s]."""
        return pair_of(self.lag)[1]

    def lateness(self, clock: Clock) -> tuple[Counting, Counting]:
        """Weights of past commands, per axis."""
        first, second = (lateness(self._times(clock, axis)) for axis in AXES)
        return first, second

    def since_last(self, clock: Clock) -> tuple[Since | None, Since | None]:
        """Weights of past commands in the velocity change since the previous sample."""
        first, second = (since_last(self._times(clock, axis)) for axis in AXES)
        return first, second

    def knows_force(self, delay: float, lag: float) -> bool:
        """True if velocities have no age and the drives' delay and lag are known exactly.

        Then the mean force of a sample is known.
        """
        known = self.delay == (delay, delay) and self.lag == (lag, lag)
        return known and not (any(self.age) or any(self.window))

    def commands(self, clock: Clock, delay: float, lag: float) -> int:
        """Number of past commands that the guard or its monitor uses.

        If ``delay`` and ``lag`` determine the force, the monitor uses none.
        """
        count = max(item.commands for item in self.lateness(clock))
        if self.knows_force(delay, lag):
            return count
        back = (item.older.commands for item in self.since_last(clock) if item is not None)
        return max([count, *back])

    def _times(self, clock: Clock, axis: int) -> Times:
        delay, lag = pair_of(self.delay), pair_of(self.lag)
        return Times(clock.control, clock.plant, self.age[axis], self.window[axis], delay, lag)


def assumptions(scenario: Scenario, guard: Guard) -> Assumptions:
    """A guard's assumptions on the motion, whether it is on or off."""
    low, high = pair_of(guard.M_min), pair_of(guard.M_max)
    force = stopping_force(high, scenario.limits.v_u1, scenario.clock.control)
    dbar, nbar, alpha = pair_of(guard.dbar), guard.nbar, guard.alpha
    return Assumptions(dbar=dbar, force=force, M_min=low, M_max=high, nbar=nbar, alpha=alpha)


def derived_guard(scenario: Scenario, bound: Bound, tau_max: float) -> GuardNumbers:
    """Guard numbers as in `feasible_guard`, even if that refuses them."""
    given = GuardNumbers(**asdict(scenario.guard), age=bound.age, window=bound.window)
    (low, high), add = mass_bounds(scenario), bound.mass
    stated = replace(
        given,
        M_min=given.M_min or (low[0] - add[0], low[1] - add[1]),
        M_max=given.M_max or _sum(high, add),
        dbar=given.dbar or _sum(bound.dbar, given.d_model),
        nbar=given.nbar or bound.nbar,
        delay=given.delay or bound.takeover,
        lag=given.lag or bound.lag,
        alpha=given.alpha or 1.0 / scenario.clock.control,
    )
    return replace(stated, brake=given.brake or _derived_brake(scenario, stated, tau_max))


def _sum(a: Pair, b: Pair) -> Pair:
    return a[0] + b[0], a[1] + b[1]


def masses(scenario: Scenario, axis: int) -> list[tuple[float, float]]:
    """True mass or inertia [kg, kg m2] at the start and after each change of it, with times [s]."""
    name = ("m", "I")[axis]
    changed = [(item.t, item.values()[name]) for item in scenario.changes if name in item.values()]
    return [(0.0, scenario.value(f"robot.{name}")[0]), *changed]


def mass_range(guard: Guard, axis: int) -> Pair:
    """Smallest and largest mass or inertia of one axis [kg or kg m2]."""
    return pair_of(guard.M_min)[axis], pair_of(guard.M_max)[axis]


def slope(guard: Guard, axis: int) -> float:
    """M_min alpha of one axis: slope of the guard's ceiling against the speed [N s/m, N m s]."""
    return mass_range(guard, axis)[0] * float(guard.alpha or 0.0)


def net(guard: Guard, axis: int) -> float:
    """dbar less f_min of one axis [N or N m]."""
    return pair_of(guard.dbar)[axis] - guard.f_min[axis]


def aim(scenario: Scenario, guard: GuardNumbers, axis: int) -> float:
    """The smaller limit of both directions less the margin for rounding [m/s or rad/s]."""
    count, limits = max(i.roundings for i in guard.lateness(scenario.clock)), scenario.limits
    larger = max(limits.v_max[axis], -limits.v_min[axis])
    return limits.smaller[axis] - larger * rounding(count)


def lateness_time(scenario: Scenario, guard: GuardNumbers, axis: int) -> float:
    """Time during which sent commands matter: window, delay and lag together [s]."""
    return scenario.clock.control * guard.lateness(scenario.clock)[axis].most


def mixed_time(scenario: Scenario, guard: GuardNumbers, axis: int) -> float:
    """Time in which either of two commands may act, weighted as for the mean [s]."""
    return scenario.clock.control * guard.lateness(scenario.clock)[axis].mixed


def reach(scenario: Scenario, guard: GuardNumbers, axis: int) -> float:
    """Braking force M_min (v_u1 - f_speed)/(1/alpha + lateness) of one axis [N or N m].

    With jitter it is also at most M_min (v_u1 - 2 nbar)/mixed.
    """
    alpha, mixed = float(guard.alpha or 0.0), mixed_time(scenario, guard, axis)
    u1 = aim(scenario, guard, axis)
    slowed = 1.0 + alpha * lateness_time(scenario, guard, axis)
    braking = slope(guard, axis) * (u1 - guard.f_speed[axis]) / slowed
    if not mixed:
        return braking
    return min(braking, mass_range(guard, axis)[0] * (u1 - 2.0 * pair_of(guard.nbar)[axis]) / mixed)


def pair_of(pair: Pair | None) -> Pair:
    """The pair, which must not be None: derived numbers never are."""
    assert pair is not None
    return pair


def _derived_brake(scenario: Scenario, guard: GuardNumbers, tau_max: float) -> Pair:
    """Largest allowed brake without torque limits; else dbar plus a share of the spare torque.

    The wheels' reach is reduced by ROUNDING, so that the computed sum is within reach.
    """
    caps = tuple(max(reach(scenario, guard, i) - net(guard, i), 0.0) for i in AXES)
    if math.isinf(tau_max):
        return caps[0], caps[1]
    half_track, share = scenario.robot.l, guard.brake_share
    first, second = max(net(guard, 0), 0.0), max(net(guard, 1), 0.0)
    phi = full_thrust(scenario.robot.r, tau_max) * (1.0 - ROUNDING)
    spare = max(phi - first - second / half_track, 0.0)
    return (
        min(caps[0], first + share * spare),
        min(caps[1], second + (1.0 - share) * spare * half_track),
    )


MODEL = "model.m, model.I, widened by guard.mass_margin"
STATED = "stated"
_PARTS: Mapping[str, Callable[[Bound], Pair]] = {
    "M_min": lambda bound: bound.mass,
    "M_max": lambda bound: bound.mass,
    "dbar": lambda bound: bound.dbar,
    "nbar": lambda bound: bound.nbar,
    "delay": lambda bound: bound.takeover,
    "lag": lambda bound: bound.lag,
    "age": lambda bound: bound.age,
    "window": lambda bound: bound.window,
}
"""An effect's part in each number.  Masses are narrowed below and widened above."""


@dataclass(frozen=True)
class SourcedNumber:
    """A number that the guard assumes, per axis or as (least, most), and its sources."""

    name: str
    value: Pair
    sources: Mapping[str, Pair | None]
    """Each part, by effect or key; None where a source is no sum."""


def assumption_sources(
    scenario: Scenario, guard: GuardNumbers, effects: Iterable[Effect]
) -> dict[str, SourcedNumber]:
    """The numbers of a settled guard by name, in SI units; ``effects`` are those present."""
    bounds = {item.name: b for item in effects if (b := item.bounded(scenario)) is not None}
    return {
        name: SourcedNumber(
            name, pair_of(getattr(guard, name)), dict(_sources(scenario, name, bounds))
        )
        for name in _PARTS
    }


def _sources(
    scenario: Scenario, name: str, bounds: Mapping[str, Bound]
) -> Iterable[tuple[str, Pair | None]]:
    if getattr(scenario.guard, name, None) is not None:
        yield STATED, None
        return
    if name in ("M_min", "M_max"):
        yield MODEL, None
    yield from ((effect, _PARTS[name](b)) for effect, b in bounds.items() if any(_PARTS[name](b)))
    if name == "dbar" and any(scenario.guard.d_model):
        yield "guard.d_model", scenario.guard.d_model
