"""SX graph to C99: one function a kernel, with branches, loops over arrays and `restrict` pointers.

CasADi's own generator reads each operand through a pointer that may be null and may alias the
results, evaluates both sides of every choice, and knows no loops.  This one reads the same graph
(`graph`), makes branches of expensive choices (`branches`) and loops of runs of like operations
(`rolls`, `fold`), and writes them (`body`) in one of two dialects; a test holds all of it to
CasADi's virtual machine.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import casadi as ca

from wmr_ctrl.codegen.body import body
from wmr_ctrl.codegen.dialect import SCALAR, Dialect
from wmr_ctrl.model.graph import Graph, read


@dataclass(frozen=True)
class Kernel:
    """One C function: its name, what it does, its graph, and the C names of its vectors."""

    name: str
    meaning: str
    function: ca.Function
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]

    @cached_property
    def graph(self) -> Graph:
        """Values in single assignment."""
        return read(self.function, self.inputs, self.outputs)

    @property
    def operations(self) -> int:
        """Number of operations, both sides of every choice counted."""
        return sum(not node.leaf for node in self.graph.nodes)


def kernel(name: str, meaning: str, inputs: dict[str, ca.SX], outputs: dict[str, ca.SX]) -> Kernel:
    """Kernel of named SX vectors; common subexpressions are merged when the graph is read."""
    function = ca.Function(
        name,
        list(inputs.values()),
        list(outputs.values()),
        list(inputs),
        list(outputs),
        {"allow_free": False},
    )
    return Kernel(name, meaning, function, tuple(inputs), tuple(outputs))


def prototype(item: Kernel, dialect: Dialect = SCALAR) -> str:
    """C signature: inputs, then outputs, all pointers to numbers."""
    given = [f"const {dialect.real} *restrict {name}" for name in item.inputs]
    wanted = [f"{dialect.real} *restrict {name}" for name in item.outputs]
    return f"WMR_KERNEL void wmr_{item.name}({', '.join(given + wanted)})"


def definition(item: Kernel, dialect: Dialect = SCALAR) -> str:
    """The whole C function with its comment and operation count."""
    lines = body(item.graph, dialect)
    text = "\n".join(lines)
    names = (*item.inputs, *item.outputs)
    unused = [f"    (void){name};" for name in names if f"{name}[" not in text]
    head = f"/* {item.meaning}\n   {item.operations} operations. */\n"
    return head + prototype(item, dialect) + "\n{\n" + "\n".join([*unused, *lines]) + "\n}\n"
