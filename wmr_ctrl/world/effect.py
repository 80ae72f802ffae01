"""Effect: what a sensor, a disturbance or a drive adds to the loop, and to what a guard assumes.

An effect is one file: a section of the scenario, a graph, a bound.  It is named in `registry`.

| role | rate | inputs by name | outputs by name |
|---|---|---|---|
| sensor | sample | time, true state, ``travel``, what was measured so far | measured quantities |
| disturbance | sample or step | time, true state | wheel torque, force on the body |
| drive | step | torque so far, true state | torque |

Effects of a role compose in the order of the registry: a sensor reads what those before it made of
the measured quantities, a drive the torque that those before it let through; disturbances add up.
Names that an effect does not read or write stay as they are.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import Enum
from typing import TYPE_CHECKING, TypeAlias

from wmr_ctrl.fields.section import Section
from wmr_ctrl.model.system import System

if TYPE_CHECKING:
    from wmr_ctrl.scenario import Scenario

Pair: TypeAlias = tuple[float, float]
ROUNDING = 1e-9
"""Share by which sums of times may miss each other."""


class EffectRole(Enum):
    """What an effect stands for in the loop."""

    SENSOR = "sensor"
    DISTURBANCE = "disturbance"
    DRIVE = "drive"


class Rate(Enum):
    """How often an effect acts: once in a control sample, or in each plant step."""

    SAMPLE = "sample"
    STEP = "step"


@dataclass(frozen=True, kw_only=True)
class Bound:
    """What an effect adds to what the guard assumes; pairs are (linear, angular).

    ``dbar`` disturbance force [N, N m]; ``nbar`` error of the velocity [m/s, rad/s]; ``mass`` by
    which mass and inertia may differ from the robot's [kg, kg m2].

    Late drives: a command takes over between ``delay - jitter`` and ``delay`` [s] after it was
    given, anew for each command, and is followed by a first order whose time constant lies within
    ``lag`` = (smallest, largest) [s] and may vary in between; a constant one has both the same.

    Late sensors: the velocity is the mean over a ``window`` [s] that ended ``age`` [s] ago, to
    within nbar.

    ``void`` says what assumption the effect breaks whatever the numbers are, in a sentence that
    begins with the key at fault: then the guard filters but promises nothing.
    """

    dbar: Pair = (0.0, 0.0)
    nbar: Pair = (0.0, 0.0)
    mass: Pair = (0.0, 0.0)
    delay: float = 0.0
    jitter: float = 0.0
    lag: Pair = (0.0, 0.0)
    age: Pair = (0.0, 0.0)
    window: Pair = (0.0, 0.0)
    void: str = ""

    @property
    def takeover(self) -> Pair:
        """Smallest and largest delay of a command [s]."""
        return max(self.delay - self.jitter, 0.0), self.delay


@dataclass(frozen=True, kw_only=True)
class Effect:
    """One sensor, disturbance or drive.

    ``section``: its fields, whose KEY is a table of the scenario.  ``build(scenario)`` gives its
    System.  ``acts(scenario)`` tells whether it makes a difference, ``present(scenario)`` whether
    it is part of the loop's structure: where it acts, unless it is so cheap that it is always
    there and its numbers decide.  ``bound(scenario)`` is what it adds to the guard's assumptions;
    without a bound the guard refuses to be switched on.

    ``shape`` lists the keys of numbers that decide the form of its graph, such as how much it
    remembers; all others it reads as parameters.  ``check(scenario)`` raises ScenarioError where
    its numbers do not go with those of other tables.
    """

    name: str
    role: EffectRole
    section: type[Section]
    build: Callable[[Scenario], System]
    acts: Callable[[Scenario], bool]
    bound: Callable[[Scenario], Bound] | None = None
    rate: Rate = Rate.SAMPLE
    always: bool = False
    shape: tuple[str, ...] = ()
    check: Callable[[Scenario], None] | None = None

    def present(self, scenario: Scenario) -> bool:
        """Whether it is part of the loop's structure."""
        return self.always or self.acts(scenario)


def on_axes(axes: tuple[int, ...], bound: Bound) -> Bound:
    """What a sensor of the velocity adds where it makes only these axes' (0 linear, 1 angular)."""
    linear, angular = (float(axis in axes) for axis in (0, 1))

    def kept(pair: Pair) -> Pair:
        return linear * pair[0], angular * pair[1]

    return replace(bound, nbar=kept(bound.nbar), age=kept(bound.age), window=kept(bound.window))


def total(bounds: list[Bound]) -> Bound:
    """The sum of bounds, and every reason why there is no promise.

    Two lags in a row are no lag, and a mean of means is no mean: those are reasons too.
    """
    reasons = [item.void for item in bounds if item.void]
    if sum(item.lag[1] > 0 for item in bounds) > 1:
        reasons.append("lag: two drives lag one behind the other, and the guard knows one lag.")
    if any(sum(item.window[i] > 0 for item in bounds) > 1 for i in (0, 1)):
        reasons.append("window: two sensors average the velocity, and the guard knows one window.")
    delay, jitter = (sum(getattr(item, name) for item in bounds) for name in ("delay", "jitter"))
    if jitter > delay * (1 + ROUNDING):
        reasons.append(
            f"jitter: a delay of at most {delay:g} s cannot vary by {jitter:g} s, or a command "
            "would act before it was given."
        )
    return Bound(
        dbar=_sum([item.dbar for item in bounds]),
        nbar=_sum([item.nbar for item in bounds]),
        mass=_sum([item.mass for item in bounds]),
        delay=delay,
        jitter=jitter,
        lag=_sum([item.lag for item in bounds]),
        age=_sum([item.age for item in bounds]),
        window=_sum([item.window for item in bounds]),
        void=" ".join(reasons),
    )


def _sum(pairs: list[Pair]) -> Pair:
    return sum(pair[0] for pair in pairs), sum(pair[1] for pair in pairs)
