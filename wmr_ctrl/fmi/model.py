"""Model: what goes into one FMU, from a scenario: table of variables, C sources, structure."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from wmr_ctrl.codegen.emit import Kernel
from wmr_ctrl.fmi.variables import Role, Variable
from wmr_ctrl.scenario import Scenario

KINDS = {"continuous": "WMR_CONTINUOUS", "sampled": "WMR_SAMPLED", "loop": "WMR_LOOP"}
RUNTIME = {
    "continuous": (),
    "sampled": (),
    "loop": ("loop.c", "loop.h", "noise.c", "noise.h", "seed.c", "seed.h"),
}
"""Files of fmu/runtime that a kind of model needs besides arithmetic.h."""


@dataclass(frozen=True)
class Dependency:
    """A calculated variable, by row, with the rows that it depends on; True: linearly, constant."""

    row: int
    on: tuple[tuple[int, bool], ...]


@dataclass(frozen=True)
class FmuModel:
    """One FMU's content before any file is written.

    ``constants`` and ``layout``: names and numbers for the kernels and for the FMI layer;
    ``tables``: named integer or float arrays for C;
    ``dependencies``: Jacobian structure of calculated variables, None where they depend on all;
    ``graph``: the serialised CasADi function.
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
    tables: Mapping[str, Sequence[Sequence[float]]]
    dependencies: tuple[Dependency, ...] | None
    model_exchange: bool
    step: float
    graph: str

    @property
    def identifier(self) -> str:
        """Model identifier: a C name."""
        return f"wmr_{self.what.replace('-', '_')}"

    @property
    def states(self) -> tuple[int, ...]:
        """Rows of the continuous states."""
        return tuple(
            i
            for i, v in enumerate(self.variables)
            if self.kind == "continuous" and v.role is Role.START
        )

    def row(self, name: str) -> int:
        """Row of the variable called ``name``."""
        return next(i for i, item in enumerate(self.variables) if item.name == name)
