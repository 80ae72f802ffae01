"""References: section, value, velocities of a path, and numbers from a reference's graph.

A kind is one file: a section of the scenario, a graph, its numbers.  It is named in `registry`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from wmr_ctrl.core.errors import ArgumentError, ScenarioError
from wmr_ctrl.core.fields.plugins import blamed
from wmr_ctrl.core.fields.section import Section, number_of, quantities, quantity
from wmr_ctrl.core.fields.unstated import Unstated
from wmr_ctrl.core.signals import REFERENCE, SAMPLE, TIME, Signal
from wmr_ctrl.core.symbolic import ca
from wmr_ctrl.world.model.evaluate import Floats, evaluated
from wmr_ctrl.world.model.system import Parameters, System, outputs, port

if TYPE_CHECKING:
    from wmr_ctrl.world.scenario import Scenario


GRID = 2001
MOST_SAMPLES = 20_000
DRIVEN = 0.5, 0.25
"""Shares of the limits of speed and turning for which a path is sized where nobody does."""
AT_ONCE = 64
"""Times at once: a function that is mapped over very many has a copy of all numbers for each."""
Numbers: TypeAlias = tuple[tuple[Signal, tuple[float, ...]], ...]
"""Signals of a reference's parameters, each with its values; their names begin with ``ref_``."""
Raw: TypeAlias = dict[str, object]
Pair: TypeAlias = tuple[float, float]
Trajectory: TypeAlias = "Callable[[ca.SX, Mapping[str, ca.SX]], ca.SX]"
"""From time [s] and the parameters' symbols by name to the reference (7, 1)."""


class Reference(Section, key="reference"):
    """Base of the sections of all kinds; theta_d is 0 along +Y, and the motion starts at t = 0."""

    keep_out: tuple[tuple[float, ...] | tuple[tuple[float, float], ...], ...] = quantity(
        (), "m", "obstacles: circles [x, y, r], polygons [[x, y], ...]", kind="shapes"
    )

    def stated(self, name: str) -> float | None:
        """Value of a field; None if it is omitted."""
        value: float = vars(self)[name]
        return None if isinstance(value, Unstated) else value

    def sized(self, limits: Pair, accel: Pair) -> Mapping[str, float]:
        """Values of omitted fields, from the limits of speeds and of their rates, SI."""
        return {}

    @property
    def cycle(self) -> float:
        """Time after which the desired velocities repeat [s]; inf if they never do."""
        return math.inf

    @property
    def arrival(self) -> float | None:
        """Time at which the desired motion comes to rest for good [s]; None if it never does."""
        return None


def driven(limits: Pair) -> Pair:
    """Default speed and turning rate [m/s, rad/s] of a path, from their limits."""
    return DRIVEN[0] * limits[0], DRIVEN[1] * limits[1]


def field_numbers(reference: Reference) -> Numbers:
    """The section's own numbers, each called ``ref_`` and the name of its field."""
    fields = quantities(type(reference))
    names = [name for name, what in fields if what.kind in ("number", "integer")]
    return tuple(number_of(reference, name, f"ref_{name}") for name in names)


def as_given(values: Raw) -> Raw:
    """The raw table itself; the argument's name is part of the interface of every ``read``."""
    return values


@dataclass(frozen=True)
class ReferenceKind:
    """One kind: its name in ``reference.kind``, its section, its graph, its numbers.

    ``build(scenario)`` gives a System from time to `signals.REFERENCE`: without state, or sampled
    with the control period. It takes its numbers from `Parameters`, by the names of ``numbers``:
    those of the section's fields, unless the graph reads a table computed from them. ``read`` turns
    a raw table into the section's fields; ``example`` is a table to start from, if the defaults
    alone are not valid.
    """

    name: str
    section: type[Reference]
    build: Callable[[Scenario], System]
    numbers: Callable[..., Numbers] = field_numbers
    read: Callable[[Raw], Raw] = as_given
    example: str = ""


def timed(trajectory: Trajectory) -> Callable[[Scenario], System]:
    """Builder of a reference that is a function of time alone."""

    def build(scenario: Scenario) -> System:
        time, p = port(TIME), Parameters(scenario)
        names = [signal.name for signal, _ in scenario.reference_kind.numbers(scenario.reference)]
        path = trajectory(time.sym, {name: p.take(name) for name in names})
        shown = outputs(REFERENCE, path)
        return System(
            "reference", "desired trajectory", inputs=(time,), params=p.ports, outputs=shown
        )

    return build


def speeds(velocity: ca.SX, acceleration: ca.SX, jerk: ca.SX) -> ca.SX:
    """Return v1_d, v2_d, v1_d_dot, v2_d_dot (4, 1) of a robot that drives forwards on a path.

    ``velocity``, ``acceleration`` and ``jerk`` are the path's derivatives (2, 1), in m/s, m/s2
    and m/s3; the velocity must not vanish.  The rates follow from v1^2 = p'.p' and
    v1^2 v2 = p' x p'', both differentiated once.
    """
    square = ca.dot(velocity, velocity)
    along = ca.dot(velocity, acceleration)
    v1 = ca.sqrt(square)
    v2 = cross(velocity, acceleration) / square
    v2_dot = (cross(velocity, jerk) - 2 * v2 * along) / square
    return ca.vertcat(v1, v2, along / v1, v2_dot)


def cross(a: ca.SX, b: ca.SX) -> ca.SX:
    """Return the third component of the cross product of two plane vectors."""
    return a[0] * b[1] - a[1] * b[0]


def reference(scenario: Scenario) -> System:
    """The desired trajectory: System from time t [s] to the seven reference signals.

    Raises ArgumentError, which names the kind, if it gives something else.
    """
    kind = scenario.reference_kind
    remedy = "Mend it, or choose another kind; --debug shows where."
    with blamed(f'reference.kind = "{kind.name}": its graph cannot be built', remedy):
        system = kind.build(scenario)
    given = [item.signal.name for item in system.outputs]
    reads = {item.signal.name for item in system.inputs} - {TIME.name, SAMPLE.name}
    if given != [signal.name for signal in REFERENCE] or reads or system.draws:
        raise ArgumentError(
            f'reference.kind = "{kind.name}": its graph must give '
            f"{', '.join(signal.name for signal in REFERENCE)} in this order, from "
            f"{TIME.name} or {SAMPLE.name} alone and without random numbers."
        )
    return system


def sample(scenario: Scenario, times: Floats) -> Floats:
    """Return the reference at ``times`` (N,) [s]: (N, 7), in the order of ``signals.REFERENCE``.

    A reference with state is held from sample to sample; its times must not fall.
    """
    system = reference(scenario)
    if not np.size(times):
        return np.empty((0, len(REFERENCE)))
    if system.x.numel():
        return _stepped(system, scenario.clock.control, np.asarray(times, dtype=float))
    graph = system.function("reference", [ca.densify(system.y)])
    count = np.size(times)
    at_once = min(count, AT_ONCE)
    every = graph.map("sampled", "serial", at_once, [1, 2], [])
    rows = np.resize(times, (-(-count // at_once), at_once))  # the last is filled up by the first
    return np.vstack([evaluated(every, row, [], system.p0)[0].T for row in rows])[:count]


def _stepped(system: System, period: float, times: Floats) -> Floats:
    graph = system.function("reference", [system.update, system.y])
    x, p, k, rows = ca.DM(system.x0), ca.DM(system.p0), 0, []
    for time in times:
        wanted = int(np.floor(time / period + 1e-9))
        for step in range(k, wanted):
            x = graph(step * period, x, p)[0]
        k = max(k, wanted)
        rows.append(np.asarray(graph(k * period, x, p)[1]).ravel())
    return np.array(rows)


_STARTS: dict[tuple[object, ...], tuple[tuple[float, ...], tuple[float, ...]]] = {}


def start_of(scenario: Scenario) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Pose (3,) [m, m, rad] and velocity (2,) [m/s, rad/s] of the desired motion at t = 0.

    Rest at the origin if the motion is not finite, which is refused elsewhere.
    """
    key = type(scenario.reference), scenario.reference, scenario.clock.control
    if key not in _STARTS:
        row = sample(scenario, np.zeros(1))[0]
        numbers = tuple(map(float, row if np.isfinite(row).all() else np.zeros(len(REFERENCE))))
        _STARTS[key] = numbers[:3], numbers[3:5]
    return _STARTS[key]


_FASTEST: dict[tuple[object, ...], float] = {}


def fastest_of(scenario: Scenario) -> float:
    """Largest |v1_d| [m/s] of the desired motion, on a grid over a cycle or the run; 0 if none."""
    reference, clock = scenario.reference, scenario.clock
    key = type(reference), reference, clock.control, clock.duration
    if key not in _FASTEST:
        times = np.linspace(0.0, min(clock.duration, reference.cycle), 201)
        speeds = np.abs(sample(scenario, times)[:, 3])
        _FASTEST[key] = float(np.max(speeds[np.isfinite(speeds)], initial=0.0))
    return _FASTEST[key]


def reference_bounds(scenario: Scenario) -> tuple[float, float, float]:
    """Return min v1_d [m/s], max v1_d [m/s] and max |v2_d| [rad/s] over the run.

    Evaluated on a fine grid over one cycle of the velocities or the run, whichever is shorter.  The
    theorems require 0 < v1_d < v_u2[1] and |v2_d| < v_u2[2].
    """
    (slowest, fastest), turning = reference_spans(scenario)
    return slowest, fastest, max(map(abs, turning))


def reference_spans(scenario: Scenario) -> tuple[tuple[float, float], tuple[float, float]]:
    """Least and largest v1_d [m/s], and v2_d [rad/s], on the grid of `reference_bounds`."""
    end = min(scenario.clock.duration, scenario.reference.cycle)
    rows = sample(scenario, np.linspace(0, end, GRID))
    linear, angular = ((float(v.min()), float(v.max())) for v in (rows[:, 3], rows[:, 4]))
    return linear, angular


def check_finite(scenario: Scenario) -> None:
    """Raise ScenarioError if the reference is not finite at samples, or on a grid between them.

    Checked over one cycle of the velocities or the run, whichever is shorter, at most MOST_SAMPLES.
    """
    end, period = min(scenario.clock.duration, scenario.reference.cycle), scenario.clock.control
    samples = np.arange(min(end / period + 1, MOST_SAMPLES)) * period
    times = np.sort(np.concatenate((samples, np.linspace(0, end, GRID))))
    bad = np.flatnonzero(~np.isfinite(sample(scenario, times)).all(axis=1))
    if bad.size:
        raise ScenarioError(
            f'reference.kind = "{scenario.reference_kind.name}": the desired motion is not finite '
            f"at t = {times[bad[0]]:.6g} s. Change the reference's numbers, or its graph."
        )
