"""SX graph to C99: one function a kernel, with branches, loops and pointers that do not alias.

CasADi's own generator reads each operand through a pointer that may be null and may alias the
results, evaluates both sides of every choice, and knows no loops.  This one reads the same graph
(`graph`), makes branches of expensive choices (`branches`) and loops of runs of like operations
(`rolls`, `fold`), and writes them (`body`) in one of two dialects; a test holds all of it to
CasADi's virtual machine.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

import casadi as ca

from wmr_ctrl.codegen.body import body
from wmr_ctrl.codegen.dialect import SCALAR, Dialect
from wmr_ctrl.codegen.preparation import PREPARED, split
from wmr_ctrl.model.graph import PARAMETERS, Graph, read

QUALIFIERS = """\
#ifndef WMR_KERNEL
#define WMR_KERNEL
#endif
#ifndef WMR_RESTRICT
#if defined(__GNUC__) || defined(_MSC_VER)
#define WMR_RESTRICT __restrict
#elif defined(__cplusplus)
#define WMR_RESTRICT
#else
#define WMR_RESTRICT restrict
#endif
#endif
"""
"""C lines before the first prototype: what stands before functions and beside their pointers."""


@dataclass(frozen=True)
class Kernel:
    """One C function: its name, what it does, its graph, and the C names of its vectors.

    ``prepared``: what is slow and hangs on the parameters alone is computed by a second function,
    wmr_NAME_prepare, when they are set.
    """

    name: str
    meaning: str
    function: ca.Function
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    prepared: bool = False

    @cached_property
    def graph(self) -> Graph:
        """Values in single assignment."""
        return read(self.function, self.inputs, self.outputs)

    @property
    def operations(self) -> int:
        """Number of operations, both sides of every choice counted."""
        return operations(self.graph)


def operations(graph: Graph) -> int:
    """Number of operations, both sides of every choice counted."""
    return sum(not node.leaf for node in graph.nodes)


def kernel(
    name: str,
    meaning: str,
    inputs: dict[str, ca.SX],
    outputs: dict[str, ca.SX],
    *,
    prepared: bool = False,
) -> Kernel:
    """Kernel of named SX vectors; common subexpressions are merged when the graph is read."""
    function = ca.Function(
        name,
        list(inputs.values()),
        list(outputs.values()),
        list(inputs),
        list(outputs),
        {"allow_free": False},
    )
    return Kernel(name, meaning, function, tuple(inputs), tuple(outputs), prepared)


def prototype(item: Kernel, dialect: Dialect = SCALAR) -> str:
    """C signature: inputs, then outputs, all pointers to numbers."""
    return _signature(item.name, _given(item), item.outputs, dialect)


def preparation(item: Kernel, dialect: Dialect = SCALAR) -> str:
    """C signature of what a prepared kernel takes of the parameters alone."""
    return _signature(f"{item.name}_prepare", (PARAMETERS,), (PREPARED,), dialect)


def definition(item: Kernel, dialect: Dialect = SCALAR) -> str:
    """The whole C function with its comment and operation count.

    Before a prepared kernel stands its preparation, and the length of what that leaves.
    """
    if not item.prepared:
        names = (*item.inputs, *item.outputs)
        return _text(item.meaning, prototype(item, dialect), item.graph, names, dialect)
    before, rest = split(item.graph)
    meaning = f"What {item.name} takes of the parameters alone."
    names = (*_given(item), *item.outputs)
    return (
        f"#define {length(item)} {len(before.stores)}\n"
        + _text(meaning, preparation(item, dialect), before, (PARAMETERS, PREPARED), dialect)
        + "\n"
        + _text(item.meaning, prototype(item, dialect), rest, names, dialect)
    )


def length(item: Kernel) -> str:
    """Name in C of the length of what a prepared kernel's preparation leaves."""
    return f"WMR_{item.name.upper()}_PREPARED"


def _given(item: Kernel) -> tuple[str, ...]:
    return (*item.inputs, PREPARED) if item.prepared else item.inputs


def _signature(name: str, inputs: Iterable[str], outputs: Iterable[str], dialect: Dialect) -> str:
    given = [f"const {dialect.real} *WMR_RESTRICT {item}" for item in inputs]
    wanted = [f"{dialect.real} *WMR_RESTRICT {item}" for item in outputs]
    return f"WMR_KERNEL void wmr_{name}({', '.join(given + wanted)})"


def _text(
    meaning: str, signature: str, graph: Graph, names: Iterable[str], dialect: Dialect
) -> str:
    lines = body(graph, dialect)
    text = "\n".join(lines)
    unused = [f"    (void){name};" for name in names if f"{name}[" not in text]
    head = f"/* {meaning}\n   {operations(graph)} operations. */\n"
    return head + signature + "\n{\n" + "\n".join([*unused, *lines]) + "\n}\n"
