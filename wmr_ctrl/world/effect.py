"""Effect: a sensor, disturbance or drive of the loop, and its bound in the guard's assumptions.

An effect is one file: a section of the scenario, a graph, a bound.  It is named in `registry`.

| role | rate | inputs by name | outputs by name |
|---|---|---|---|
| sensor | sample | time, true state, ``travel``, what was measured so far | measured quantities |
| disturbance | sample or step | time, true state | wheel torque, force on the body |
| command | step | commanded velocity so far, true state | commanded velocity |
| loop | step | commanded velocity, true state | torque |
| drive | step | torque so far, true state | torque |

Commands and the speed loop are those of a base that takes velocities; a controller sends velocities
to it, and torques to any other base.

Effects of a role compose in the order of the registry: a sensor reads the measured quantities from
the sensors before it, a drive the torque from the drives before it; disturbances add up. Names that
an effect does not read or write are unchanged.
"""

import math
from collections.abc import Callable, Iterable
from dataclasses import KW_ONLY, dataclass, replace
from enum import Enum
from numbers import Real
from typing import TYPE_CHECKING, Any, TypeAlias, TypeVar

from wmr_ctrl.core.errors import ArgumentError, show
from wmr_ctrl.core.fields.plugins import blamed
from wmr_ctrl.core.fields.section import Section, quantities
from wmr_ctrl.core.signals import (
    COMMAND,
    DISTURBING,
    MEASURED,
    ODOMETRY_AGE,
    PATH,
    PLANT_STATE,
    SAMPLE,
    SKID,
    STEP,
    TIME,
    TORQUE,
    TRAVEL,
    Signal,
)

from .model.system import NORMAL, UNIFORM, System

if TYPE_CHECKING:
    from . import scenario

Scenario: TypeAlias = "scenario.Scenario"
"""Name alone: a scenario's tables are those of its effects, so it imports them."""
Pair: TypeAlias = tuple[float, float]
T = TypeVar("T")
ROUNDING = 1e-9
"""Share by which sums of times may miss each other."""
PAIRS = ("dbar", "nbar", "mass", "lag", "age", "window", "command", "dropped")
"""Fields of a Bound that have a number for each axis, or a smallest and a largest."""


class EffectRole(Enum):
    """Role of an effect in the loop."""

    SENSOR = "sensor"
    DISTURBANCE = "disturbance"
    COMMAND = "command"
    LOOP = "loop"
    DRIVE = "drive"


class Rate(Enum):
    """Rate of an effect: once in a control sample, or in each plant step."""

    SAMPLE = "sample"
    STEP = "step"


@dataclass(frozen=True, kw_only=True)
class Bound:
    """Contribution of an effect to the guard's assumptions; pairs are (linear, angular).

    ``dbar``: disturbance force [N, N m].  ``nbar``: error of the velocity [m/s, rad/s].  ``mass``:
    largest deviation of mass and inertia from the robot's [kg, kg m2].

    Late drives: a command takes over between ``delay - jitter`` and ``delay`` [s] after it was
    sent, at a time that may differ for each command.  A first-order lag follows, whose time
    constant lies within ``lag`` = (smallest, largest) [s] and may vary; both are equal if it is
    constant.

    Late sensors: the velocity is the mean over a ``window`` [s] that ended ``age`` [s] ago, to
    within nbar.

    Bases that take velocities: the command that arrives has an error of at most ``command`` [m/s,
    rad/s], and a command of at most ``dropped`` [m/s, rad/s] may act as 0.  ``hidden`` names an
    effect that the governor does not model, ``overshoots`` one that makes the base overshoot its
    command.  Each is a sentence that begins with the key at fault.

    ``void`` says which assumption the effect breaks for any numbers, in a sentence that begins with
    the key at fault.  The guard then still filters, without guarantee.
    """

    dbar: Pair = (0.0, 0.0)
    nbar: Pair = (0.0, 0.0)
    mass: Pair = (0.0, 0.0)
    delay: float = 0.0
    jitter: float = 0.0
    lag: Pair = (0.0, 0.0)
    age: Pair = (0.0, 0.0)
    window: Pair = (0.0, 0.0)
    command: Pair = (0.0, 0.0)
    dropped: Pair = (0.0, 0.0)
    losses: int = 0
    hidden: str = ""
    overshoots: str = ""
    void: str = ""

    def __post_init__(self) -> None:
        """Raise ValueError for an invalid bound; `Effect.bounded` adds the effect's name."""
        for name in PAIRS:
            pair = getattr(self, name)
            if not (isinstance(pair, tuple) and len(pair) == 2 and all(map(_is_size, pair))):
                raise ValueError(f"{name} = {show(pair)} must be two finite numbers of at least 0.")
        for name in ("delay", "jitter"):
            if not _is_size(getattr(self, name)):
                raise ValueError(f"{name} = {show(getattr(self, name))} must be a finite time.")
        if self.lag[0] > self.lag[1]:
            raise ValueError(f"lag = {self.lag!r} must be its smallest and its largest.")

    @property
    def takeover(self) -> Pair:
        """Smallest and largest delay of a command [s]."""
        return max(self.delay - self.jitter, 0.0), self.delay


def _is_size(value: object) -> bool:
    return isinstance(value, Real) and math.isfinite(value) and float(value) >= 0.0


_TRUE = (TIME, *PLANT_STATE)
READS: dict[EffectRole, tuple[Signal, ...]] = {
    EffectRole.SENSOR: (*_TRUE, SAMPLE, PATH, SKID, TRAVEL, *MEASURED),
    EffectRole.DISTURBANCE: (*_TRUE, SAMPLE, STEP),
    EffectRole.COMMAND: (*_TRUE, STEP, *COMMAND),
    EffectRole.LOOP: (*_TRUE, STEP, *COMMAND),
    EffectRole.DRIVE: (*_TRUE, STEP, *TORQUE),
}
"""Inputs that an effect of a role may have: those that every output has for it."""
WRITES: dict[EffectRole, tuple[Signal, ...]] = {
    EffectRole.SENSOR: (*MEASURED, ODOMETRY_AGE),
    EffectRole.DISTURBANCE: DISTURBING,
    EffectRole.COMMAND: COMMAND,
    EffectRole.LOOP: TORQUE,
    EffectRole.DRIVE: TORQUE,
}


@dataclass(frozen=True)
class Effect:
    """One sensor, disturbance or drive.

    ``section``: its fields, whose KEY is a table of the scenario.  ``build(scenario)`` gives its
    System, ``bound(scenario)`` its contribution to the guard's assumptions; an effect without a
    bound cannot be used with the guard on.

    The effect acts if a field of its section differs from the default: one of ``switches``, if
    these are named, or as ``acts(scenario)`` says.  A command or speed loop acts only on a base
    that takes velocities.  The System's period is that of the rate.  An effect is part of the
    loop's graph if it acts.  With ``always`` (for cheap effects) it is always part of it, and its
    numbers alone switch it off.

    ``shape`` lists the keys of numbers that decide the form of its graph, such as the length of its
    memory; all others are read as parameters.  ``check(scenario)`` raises ScenarioError if its
    numbers do not fit those of other tables.  The stability figures include its effect on the loop
    near a reference, except for rounding in its graph, which they name.

    Raises ArgumentError for an invalid effect: a drive acts in each step, a sensor in each sample.
    """

    name: str
    role: EffectRole
    section: type[Section]
    build: Callable[[Scenario], System]
    bound: Callable[[Scenario], Bound] | None = None
    _: KW_ONLY
    switches: tuple[str, ...] = ()
    acts: Callable[[Scenario], bool] | None = None
    rate: Rate = Rate.SAMPLE
    always: bool = False
    shape: tuple[str, ...] = ()
    check: Callable[[Scenario], None] | None = None

    def __post_init__(self) -> None:
        """Refuse a rate that no loop has for its role, and switches that are not fields."""
        late = (EffectRole.COMMAND, EffectRole.LOOP, EffectRole.DRIVE)
        rates = {EffectRole.SENSOR: (Rate.SAMPLE,), **dict.fromkeys(late, (Rate.STEP,))}
        if self.rate not in rates.get(self.role, tuple(Rate)):
            raise ArgumentError(
                f"the effect {self.title} has rate = {show(self.rate)}: it is SAMPLE for a sensor "
                "and STEP for a drive, a command or a speed loop."
            )
        fields = dict(quantities(self.section))
        for name in self.switches:
            if name not in fields:
                raise ArgumentError(f"the effect {self.title}: switch {show(name)} is no field.")

    @property
    def title(self) -> str:
        """Its name and its table, for messages."""
        return f"{self.name} ([{self.section.KEY}])"

    def active(self, scenario: Scenario) -> bool:
        """True if the effect changes the loop."""
        if self.role in (EffectRole.COMMAND, EffectRole.LOOP) and not scenario.takes_velocity:
            return False
        if self.acts is not None:
            return bool(self._call("acts", self.acts, scenario))
        section, defaults = scenario.section(self.section), dict(quantities(self.section))
        names = self.switches or defaults
        return any(getattr(section, name) != defaults[name].default for name in names)

    def present(self, scenario: Scenario) -> bool:
        """True if the effect is part of the loop's structure."""
        return self.always or self.active(scenario)

    def relate(self, scenario: Scenario) -> None:
        """Check its numbers against those of other tables."""
        if self.check is not None:
            self._call("check", self.check, scenario)

    def system(self, scenario: Scenario) -> System:
        """Its System; ArgumentError for one that does not fit its role and rate."""
        system = self._call("build", self.build, scenario)
        if not isinstance(system, System):
            raise ArgumentError(f"the effect {self.title} builds {show(system)}, not a System.")
        clock = SAMPLE if self.rate is Rate.STEP else STEP
        reads = [item for item in READS[self.role] if item is not clock]
        self._only("reads", (item.signal for item in system.inputs), reads)
        self._only("writes", (item.signal for item in system.outputs), WRITES[self.role])
        self._only_draws(system)
        period = scenario.clock.control if self.rate is Rate.SAMPLE else scenario.clock.plant
        return replace(system, period=period)

    def bounded(self, scenario: Scenario) -> Bound | None:
        """Its contribution to the guard's assumptions; None if it states no bound."""
        if self.bound is None:
            return None
        stated = self._call("bound", self.bound, scenario)
        if not isinstance(stated, Bound):
            raise ArgumentError(
                f"the effect {self.title} has the bound {show(stated)}, which is not a Bound."
            )
        return stated

    def _call(self, what: str, function: Callable[[Scenario], T], scenario: Scenario) -> T:
        """Call one of the effect's own functions; unclear errors get the effect's name."""
        remedy = "Mend it, or take its table out of the scenario; --debug shows where."
        with blamed(f"the effect {self.title} fails in its {what}", remedy):
            return function(scenario)

    def _only(self, verb: str, named: Iterable[Signal], allowed: Iterable[Signal]) -> None:
        known = [item.name for item in allowed]
        for name in (item.name for item in named if item.name not in known):
            raise ArgumentError(
                f"the effect {self.title} {verb} {name!r}, and a {self.role.value} that acts in "
                f"each {self.rate.value} {verb} {', '.join(known)} alone."
            )

    def _only_draws(self, system: System) -> None:
        late = (EffectRole.COMMAND, EffectRole.DRIVE)
        if system.transport is not None and self.role not in late:
            raise ArgumentError(f"the effect {self.title} has a transport, but is not a drive.")
        for item in system.draws:
            if item.kind not in (UNIFORM, NORMAL):
                raise ArgumentError(
                    f"the effect {self.title} draws {item.kind!r} numbers; only {UNIFORM!r} and "
                    f"{NORMAL!r} ones exist."
                )


def adds_nothing(_: Scenario) -> Bound:
    """Bound of an effect that the guard need not know, such as a sensor of the pose."""
    return Bound()


def on_axes(axes: tuple[int, ...], bound: Bound) -> Bound:
    """Bound of a velocity sensor that measures only these axes (0 linear, 1 angular)."""
    shown: dict[str, Any] = {
        name: tuple(float(axis in axes) * getattr(bound, name)[axis] for axis in (0, 1))
        for name in ("nbar", "age", "window")
    }
    return replace(bound, **shown)


def total(bounds: list[Bound]) -> Bound:
    """Sum of bounds, with every reason why nothing is guaranteed.

    Two lags in series are not one lag, and a mean of means is not one mean: these are such reasons.
    """
    reasons = [item.void for item in bounds if item.void]
    if sum(item.lag[1] > 0 for item in bounds) > 1:
        reasons.append("lag: two drives have a lag in series, and the guard allows only one.")
    if any(sum(item.window[i] > 0 for item in bounds) > 1 for i in (0, 1)):
        reasons.append("window: two sensors average the velocity, and the guard allows only one.")
    delay, jitter = (sum(getattr(item, name) for item in bounds) for name in ("delay", "jitter"))
    if jitter > delay * (1 + ROUNDING):
        reasons.append(
            f"jitter: a delay of at most {delay:g} s cannot vary by {jitter:g} s, or a command "
            "would act before it was given."
        )
    sums: dict[str, Any] = {
        name: tuple(sum((getattr(item, name)[i] for item in bounds), 0.0) for i in (0, 1))
        for name in PAIRS
    }
    said: dict[str, Any] = {
        name: " ".join(filter(None, (getattr(item, name) for item in bounds)))
        for name in ("hidden", "overshoots")
    }
    losses = sum(item.losses for item in bounds)
    return Bound(delay=delay, jitter=jitter, losses=losses, void=" ".join(reasons), **sums, **said)


def mass_bounds(scenario: Scenario) -> tuple[Pair, Pair]:
    """Smallest and largest mass and inertia [kg, kg m2], before effects widen them.

    They are the guard's.  Unstated ones are model.m and model.I, less or plus the share
    guard.mass_margin.  The true robot and its changes are not used.
    """
    return scenario.guard.masses(*scenario.value("model.m"), *scenario.value("model.I"))


def heaviest(scenario: Scenario) -> float:
    """Largest mass that a guard assumes [kg]."""
    return mass_bounds(scenario)[1][0]
