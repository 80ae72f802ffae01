"""FmuModel: content of one FMU before any file is written: variables, kernels, tables."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from wmr_ctrl.codegen.emit import Kernel
from wmr_ctrl.fmi.variables import Variable
from wmr_ctrl.guard.bounds import MASS_KEYS
from wmr_ctrl.scenario import Scenario

KINDS = {"continuous": "WMR_CONTINUOUS", "sampled": "WMR_SAMPLED", "loop": "WMR_LOOP"}
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
    ``tables``: named integer or float arrays for C;
    ``dependencies``: by the row of a calculated variable the rows that it depends on (True:
    linearly, by a constant), None where all depend on all;
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

    Where the model's own numbers are not in order, nothing acts on them.
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
