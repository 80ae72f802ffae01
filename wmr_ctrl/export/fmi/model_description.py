"""FmuModel: content of one FMU before any file is written: variables, kernels, tables.

The variables are one row per scalar, from which C and both XML dialects are written.
"""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import Enum
from typing import Any

from wmr_ctrl.codegen.emit import Kernel
from wmr_ctrl.control.guard.bounds import MASS_KEYS
from wmr_ctrl.control.numbers import Range
from wmr_ctrl.core.fields.named_units import per_second
from wmr_ctrl.core.signals import LARGEST, Signal
from wmr_ctrl.world.model.system import Port
from wmr_ctrl.world.scenario import Scenario

ARRAY_FROM = 8
"""Vectors of one unit with at least so many elements are arrays in FMI 3."""


class Role(Enum):
    """Role of a variable for its user; the values are the names in C."""

    INDEPENDENT = "WMR_INDEPENDENT"
    INPUT = "WMR_INPUT"
    FIXED = "WMR_FIXED"
    TUNABLE = "WMR_TUNABLE"
    START = "WMR_START"
    CALCULATED = "WMR_CALCULATED"


@dataclass(frozen=True)
class Variable:
    """One scalar: name, unit, meaning, role, start value and range.

    ``output``: published as an output (else local); ``discrete``: changes at samples only;
    ``rate_of``: name of the state whose rate this is; ``array``, ``index``, ``size``: the vector
    that it is an element of.
    """

    name: str
    unit: str
    meaning: str
    role: Role
    start: float = 0.0
    low: float = -math.inf
    high: float = math.inf
    integer: bool = False
    discrete: bool = False
    output: bool = False
    rate_of: str = ""
    array: str = ""
    index: int = 0
    size: int = 1

    @property
    def parameter(self) -> bool:
        """True for a parameter, fixed or tunable."""
        return self.role in (Role.FIXED, Role.TUNABLE)

    @property
    def known(self) -> bool:
        """True if outputs at a communication point may depend on it: time, inputs, states."""
        return self.role in (Role.INDEPENDENT, Role.INPUT) or (
            self.role is Role.START and not self.discrete
        )


TIME = Variable("time", "s", "time", Role.INDEPENDENT)


def finite(value: float) -> float:
    """A number that XML and solvers accept; infinity becomes the largest quantity."""
    return math.copysign(LARGEST, value) if math.isinf(value) else float(value)


def parameter_rows(
    ports: Iterable[Port], ranges: Mapping[str, Range], tunable: Iterable[str] = ()
) -> Iterator[Variable]:
    """Rows of parameters, with the ranges of their scenario fields."""
    changing = set(tunable)
    for port in ports:
        role = Role.TUNABLE if port.signal.name in changing else Role.FIXED
        low, high = ranges.get(port.signal.name, (-LARGEST, LARGEST))
        yield from _rows(port.signal, role, map(finite, port.value), low=low, high=high)


def input_rows(ports: Iterable[Port], starts: Mapping[str, float]) -> Iterator[Variable]:
    """Rows of inputs, limited to LARGEST; start values by the elements' names."""
    for port in ports:
        pairs = zip(port.signal.elements, port.value, strict=True)
        values = (starts.get(name, value) for name, value in pairs)
        yield from _rows(port.signal, Role.INPUT, values, low=-LARGEST, high=LARGEST)


def state_rows(
    ports: Iterable[Port], outputs: set[str], taken: set[str], *, discrete: bool
) -> Iterator[Variable]:
    """Rows of states; they are outputs if the System outputs them under their own names."""
    for port in ports:
        signal, name, shown = port.signal, port.signal.name, port.signal.name in outputs
        if name in taken - outputs:
            signal = replace(signal, name=f"state.{name}")
        yield from _rows(signal, Role.START, port.value, output=shown, discrete=discrete)


def rate_rows(states: Iterable[Variable]) -> Iterator[Variable]:
    """Rows of the states' rates, der(x)."""
    for state in states:
        name, unit = state.name, per_second(state.unit)
        meaning = f"rate of {name}"
        yield Variable(f"der({name})", unit, meaning, Role.CALCULATED, rate_of=name)


def output_rows(
    signals: Iterable[Signal], *, discrete: bool, integer: bool = False
) -> Iterator[Variable]:
    """Rows of calculated outputs."""
    for signal in signals:
        marks = {"output": True, "discrete": discrete, "integer": integer}
        yield from _rows(signal, Role.CALCULATED, (0.0,) * signal.size, **marks)


def _rows(signal: Signal, role: Role, values: Iterable[float], **marks: Any) -> Iterator[Variable]:
    """Rows of a signal's elements; ``marks``: further fields of all of them."""
    if signal.size >= ARRAY_FROM and len(set(signal.units)) == 1:
        marks |= {"array": signal.name, "size": signal.size}
    elements = zip(signal.elements, signal.units, values, strict=True)
    for i, (name, unit, value) in enumerate(elements):
        place = f", element {i + 1} of {signal.size}" if signal.size > 1 else ""
        yield Variable(name, unit, signal.meaning + place, role, float(value), index=i, **marks)


RUNTIME = {
    "continuous": (),
    "sampled": (),
    "loop": ("loop.c", "loop.h", "noise.c", "noise.h", "seed.c", "seed.h"),
}
"""Files of fmu/runtime that a kind of model needs besides arithmetic.h."""
ORDERS = {("limits.v_u2", "limits.v_u1"): True, MASS_KEYS: False}
"""Parameters of which the first must be below the second in each element, or (False) not above."""


@dataclass(frozen=True)
class FmuModel:
    """One FMU's content before any file is written.

    ``constants`` and ``layout``: names and numbers for the kernels and for the FMI layer;
    ``tables``: named integer or float arrays for C; ``dependencies``: by the row of a calculated
    variable the rows that it depends on (True: linearly, with a constant factor), None if all
    depend on all; ``graph``: the CasADi function, as a file that `casadi.Function.load` reads.
    """

    what: str
    title: str
    kind: str
    scenario: Scenario
    variables: tuple[Variable, ...]
    constants: Mapping[str, int | str]
    kernels: tuple[Kernel, ...]
    derivatives: tuple[Kernel, ...]
    layout: Mapping[str, int]
    tables: Mapping[str, Sequence[Sequence[float]]] = field(default_factory=dict)
    dependencies: Mapping[int, Sequence[tuple[int, bool]]] | None = None
    graph: str = ""

    @property
    def identifier(self) -> str:
        """Model identifier: a C name."""
        return f"wmr_{self.what.replace('-', '_')}"

    def row(self, name: str) -> int:
        """Row of the variable called ``name``."""
        return next(i for i, item in enumerate(self.variables) if item.name == name)


def orders(model: FmuModel) -> list[tuple[int, int, bool]]:
    """Rows of parameters that initialisation keeps in order, and whether they must differ.

    Pairs that are out of order in the model itself have no effect, and are omitted.
    """
    at = {row.name: i for i, row in enumerate(model.variables) if row.parameter}
    pairs = [
        (row, at[name.replace(low, high, 1)], apart)
        for (low, high), apart in ORDERS.items()
        for name, row in at.items()
        if name.partition("[")[0] == low and name.replace(low, high, 1) in at
    ]
    start = [row.start for row in model.variables]
    return [
        (i, k, apart)
        for i, k, apart in pairs
        if start[i] < start[k] or (start[i] == start[k] and not apart)
    ]
