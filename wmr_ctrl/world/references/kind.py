"""What every kind of reference shares: its section, its value, velocities of a path.

A kind is one file: a section of the scenario, its numbers, a graph.  It is named in `registry`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias, TypeVar

from wmr_ctrl.fields.section import Section, number_of, quantities
from wmr_ctrl.model.system import Output, Parameters, System, port
from wmr_ctrl.signals import REFERENCE, TIME, Signal
from wmr_ctrl.symbolic import ca

if TYPE_CHECKING:
    from wmr_ctrl.scenario import Scenario

Numbers: TypeAlias = tuple[tuple[Signal, tuple[float, ...]], ...]
"""Signals of a reference's parameters, each with its values; their names begin with ``ref_``."""
Raw: TypeAlias = dict[str, object]


class Reference(Section, key="reference"):
    """Base of the sections of all kinds; theta_d is 0 along +Y, and the motion starts at t = 0."""

    @property
    def cycle(self) -> float:
        """Time after which the desired velocities repeat [s]; inf if they never do."""
        return math.inf

    @property
    def arrival(self) -> float | None:
        """Time at which the desired motion comes to rest for good [s]; None if it never does."""
        return None


R = TypeVar("R", bound=Reference)
Trajectory: TypeAlias = "Callable[[ca.SX, Mapping[str, ca.SX]], ca.SX]"
"""From time [s] and the parameters' symbols by name to the reference (7, 1)."""


def field_numbers(reference: Reference) -> Numbers:
    """The section's own numbers, each called ``ref_`` and the name of its field."""
    fields = quantities(type(reference))
    names = [name for name, what in fields if what.kind in ("number", "integer")]
    return tuple(number_of(reference, name, f"ref_{name}") for name in names)


def as_given(values: Raw) -> Raw:
    """Return a raw table as it is."""
    return values


@dataclass(frozen=True)
class ReferenceKind:
    """One kind: its name in ``reference.kind``, its section, its graph, its numbers.

    ``build(scenario)`` gives a System from time to `signals.REFERENCE`: without state, or sampled
    with the control period.  It takes its numbers from `Parameters`, by the names of ``numbers``:
    those of the section's fields, unless the graph reads a table that is made of them.
    ``read`` turns a raw table into the section's fields; ``example`` is a table to begin with,
    where the defaults alone are none.
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
        return System(
            "reference",
            "desired trajectory",
            inputs=(time,),
            params=p.ports,
            outputs=outputs(path),
        )

    return build


def outputs(path: ca.SX) -> tuple[Output, ...]:
    """The seven signals of a reference (7, 1)."""
    return tuple(Output(signal, path[i]) for i, signal in enumerate(REFERENCE))


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
