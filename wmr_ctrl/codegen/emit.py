"""SX graph to C99: one function a kernel, with branches, loops and pointers that do not alias.

CasADi's own generator reads each operand through a pointer that may be null and may alias the
results, evaluates both sides of every choice, and knows no loops.  This one reads the same graph
(`world.model.graph`) and computes slow values that depend only on parameters beforehand.  It makes
branches of expensive choices (`items`) and loops of runs of similar operations (`reroll`), and
writes them (`body`) in one of two dialects.  A test compares all of it with CasADi's virtual
machine.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import casadi as ca

from wmr_ctrl.world.model import graph as graphs
from wmr_ctrl.world.model.graph import PARAMETERS, Graph, Node, Store

from .body import body
from .dialect import SCALAR, Dialect

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

PREPARED = "c"
"""Name of the vector of prepared values."""


@dataclass(frozen=True)
class Kernel:
    """One C function: its name, its purpose, its graph, and the C names of its vectors.

    ``prepared``: a second function, wmr_NAME_prepare, computes slow values that depend only on
    parameters, when parameters are set.  ``whole``: it computes all values that depend only on
    parameters.
    """

    name: str
    meaning: str
    function: ca.Function
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    prepared: bool = False
    whole: bool = False

    @cached_property
    def graph(self) -> Graph:
        """Values in single assignment."""
        return graphs.read(self.function, self.inputs, self.outputs)

    @property
    def operations(self) -> int:
        """Number of operations, including both sides of every choice."""
        return _operations(self.graph)


def _operations(graph: Graph) -> int:
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
    vectors = (list(inputs.values()), list(outputs.values()), list(inputs), list(outputs))
    function = ca.Function(name, *vectors, {"allow_free": False})
    return Kernel(name, meaning, function, tuple(inputs), tuple(outputs), prepared)


def prototype(item: Kernel, dialect: Dialect = SCALAR) -> str:
    """C signature: inputs, then outputs, all pointers to numbers."""
    return _signature(item.name, _given(item), item.outputs, dialect)


def preparation(item: Kernel, dialect: Dialect = SCALAR) -> str:
    """C signature of a prepared kernel's first part, which depends on parameters alone."""
    return _signature(f"{item.name}_prepare", (PARAMETERS,), (PREPARED,), dialect)


def definition(item: Kernel, dialect: Dialect = SCALAR) -> str:
    """The whole C function with its comment and operation count.

    A prepared kernel is preceded by its preparation, and the length of that part's results.
    """
    graph, names, head = item.graph, (*_given(item), *item.outputs), ""
    if item.prepared:
        before, graph = split(graph, whole=item.whole)
        first = replace(item, meaning=f"What {item.name} takes of the parameters alone.")
        taken, lines = preparation(item, dialect), body(before, dialect)
        head = f"#define {length(item)} {len(before.stores)}\n"
        head += framed(first, taken, before, (PARAMETERS, PREPARED), lines) + "\n"
    lines = body(graph, dialect)
    return head + framed(item, prototype(item, dialect), graph, names, lines)


def length(item: Kernel) -> str:
    """Name in C of the length of a prepared kernel's intermediate values."""
    return f"WMR_{item.name.upper()}_PREPARED"


def framed(
    item: Kernel, signature: str, graph: Graph, names: Iterable[str], lines: Sequence[str]
) -> str:
    """A C function with these lines; unused vectors among ``names`` are marked as such."""
    text = "\n".join(lines)
    unused = [f"    (void){name};" for name in names if f"{name}[" not in text]
    head = f"/* {item.meaning}\n   {_operations(graph)} operations. */\n"
    return head + signature + "\n{\n" + "\n".join([*unused, *lines]) + "\n}\n"


def _given(item: Kernel) -> tuple[str, ...]:
    return (*item.inputs, PREPARED) if item.prepared else item.inputs


def _signature(name: str, inputs: Iterable[str], outputs: Iterable[str], dialect: Dialect) -> str:
    given = [f"const {dialect.real} *WMR_RESTRICT {item}" for item in inputs]
    wanted = [f"{dialect.real} *WMR_RESTRICT {item}" for item in outputs]
    return f"WMR_KERNEL void wmr_{name}({', '.join(given + wanted)})"


def split(graph: Graph, *, whole: bool = False) -> tuple[Graph, Graph]:
    """Split a graph: slow values of parameters alone, and the graph that reads these as a vector.

    Slow values contain a division, root or function; with ``whole`` all values of parameters alone
    are in the first part.  Both together compute the same bits as the whole.
    """
    wanted = _wanted(graph, whole)
    nodes = list(graph.nodes)
    before = [Store(PREPARED, index, number) for index, number in enumerate(wanted)]
    places = {number: (PREPARED, index) for index, number in enumerate(wanted)}
    read = [
        Node(ca.OP_INPUT, place=places[number]) if number in places else node
        for number, node in enumerate(nodes)
    ]
    after = graphs.without_unused(read, list(graph.stores))
    return graphs.without_unused(nodes, before), after


def _wanted(graph: Graph, whole: bool) -> list[int]:
    """Slow (with ``whole``: all) parameter-only values that changing values or results read."""
    kind, slow = graphs.kinds(graph.nodes), list[bool]()
    for number, node in enumerate(graph.nodes):
        slow.append(graph.cost(number) > 1 or any(slow[k] for k in node.operands))
    readers = [node for number, node in enumerate(graph.nodes) if kind[number] == graphs.CHANGING]
    read = {number for node in readers for number in node.operands}
    read |= {store.node for store in graph.stores}
    steady = sorted(number for number in read if kind[number] == graphs.STEADY)
    if not whole:
        return [k for k in steady if slow[k] and not graph.is_logical(k)]

    def form(number: int) -> tuple[int, list[float]]:  # the operation, and plain numbers in it
        node = graph.nodes[number]
        operands = (graph.nodes[k] for k in node.operands)
        return node.op, [item.number for item in operands if item.op == ca.OP_CONST]

    return sorted((number for number in steady if not graph.nodes[number].leaf), key=form)
