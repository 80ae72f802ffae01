"""SX graph to C99: one straight-line function, every operation one line.

CasADi's own generator reads each operand through a pointer that may be null and may alias the
results, which keeps compilers from vectorising 128 weights.  This one walks the same instruction
list and writes single assignments with `restrict` pointers; a test holds it to CasADi's virtual
machine bit by bit where the operations are exact.
"""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca

_BINARY = {
    ca.OP_ADD: "{0} + {1}",
    ca.OP_SUB: "{0} - {1}",
    ca.OP_MUL: "{0} * {1}",
    ca.OP_DIV: "{0} / {1}",
    ca.OP_LT: "{0} < {1}",
    ca.OP_LE: "{0} <= {1}",
    ca.OP_EQ: "{0} == {1}",
    ca.OP_NE: "{0} != {1}",
    ca.OP_AND: "{0} && {1}",
    ca.OP_OR: "{0} || {1}",
    ca.OP_FMIN: "wmr_min({0}, {1})",
    ca.OP_FMAX: "wmr_max({0}, {1})",
    ca.OP_ATAN2: "atan2({0}, {1})",
    ca.OP_HYPOT: "hypot({0}, {1})",
    ca.OP_POW: "pow({0}, {1})",
    ca.OP_CONSTPOW: "pow({0}, {1})",
    ca.OP_COPYSIGN: "copysign({0}, {1})",
    ca.OP_IF_ELSE_ZERO: "{0} ? {1} : 0.0",
}
_UNARY = {
    ca.OP_ASSIGN: "{0}",
    ca.OP_NEG: "-{0}",
    ca.OP_NOT: "!{0}",
    ca.OP_FABS: "fabs({0})",
    ca.OP_SQRT: "sqrt({0})",
    ca.OP_SQ: "{0} * {0}",
    ca.OP_TWICE: "2.0 * {0}",
    ca.OP_INV: "1.0 / {0}",
    ca.OP_EXP: "exp({0})",
    ca.OP_LOG: "log({0})",
    ca.OP_LOG1P: "log1p({0})",
    ca.OP_EXPM1: "expm1({0})",
    ca.OP_SIN: "sin({0})",
    ca.OP_COS: "cos({0})",
    ca.OP_TAN: "tan({0})",
    ca.OP_TANH: "tanh({0})",
    ca.OP_ASIN: "asin({0})",
    ca.OP_ACOS: "acos({0})",
    ca.OP_ATAN: "atan({0})",
    ca.OP_SINH: "sinh({0})",
    ca.OP_COSH: "cosh({0})",
    ca.OP_FLOOR: "floor({0})",
    ca.OP_CEIL: "ceil({0})",
    ca.OP_SIGN: "wmr_sign({0})",
}
_LOGICAL = {ca.OP_LT, ca.OP_LE, ca.OP_EQ, ca.OP_NE, ca.OP_AND, ca.OP_OR, ca.OP_NOT}


@dataclass(frozen=True)
class Kernel:
    """One C function: its name, what it does, its graph, and the C names of its vectors."""

    name: str
    meaning: str
    function: ca.Function
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]


def kernel(name: str, meaning: str, inputs: dict[str, ca.SX], outputs: dict[str, ca.SX]) -> Kernel:
    """Kernel of named SX vectors; common subexpressions are merged first."""
    shared = ca.cse(list(outputs.values()))
    function = ca.Function(
        name, list(inputs.values()), shared, list(inputs), list(outputs), {"allow_free": False}
    )
    return Kernel(name, meaning, function, tuple(inputs), tuple(outputs))


def prototype(item: Kernel) -> str:
    """C signature: inputs, then outputs, all pointers to doubles."""
    given = [f"const double *restrict {name}" for name in item.inputs]
    wanted = [f"double *restrict {name}" for name in item.outputs]
    return f"WMR_KERNEL void wmr_{item.name}({', '.join(given + wanted)})"


def definition(item: Kernel) -> str:
    """The whole C function with its comment and operation count."""
    lines = _Body(item).lines()
    unused = [
        f"    (void){name};"
        for name in item.inputs
        if not any(f"{name}[" in line for line in lines)
    ]
    head = f"/* {item.meaning}\n   {item.function.n_instructions()} instructions. */\n"
    return head + prototype(item) + "\n{\n" + "\n".join(unused + lines) + "\n}\n"


@dataclass(frozen=True)
class _Statement:
    """One line of C: what it defines (empty for a store into a result), what it reads."""

    defines: str
    reads: tuple[str, ...]
    text: str


class _Body:
    """Statements of one kernel: work-vector slots become single assignments."""

    def __init__(self, item: Kernel) -> None:
        self.item, self.f = item, item.function
        self.slot: dict[int, str] = {}
        self.parts: dict[str, tuple[int, tuple[str, ...]]] = {}

    def lines(self) -> list[str]:
        """All statements that a result needs, in execution order."""
        every = [made for k in range(self.f.n_instructions()) if (made := self._statement(k))]
        return [f"    {item.text}" for item in _needed(every)]

    def _statement(self, k: int) -> _Statement | None:
        op, into, operands = (
            self.f.instruction_id(k),
            self.f.instruction_output(k),
            self.f.instruction_input(k),
        )
        if op == ca.OP_OUTPUT:
            source = self.slot[operands[0]]
            return _Statement("", (source,), f"{self.item.outputs[into[0]]}[{into[1]}] = {source};")
        if op == ca.OP_INPUT:
            self.slot[into[0]] = f"{self.item.inputs[operands[0]]}[{operands[1]}]"
            return None
        if op == ca.OP_CONST:
            self.slot[into[0]] = _number(self.f.instruction_constant(k))
            return None
        return self._assignment(op, into[0], tuple(self.slot[i] for i in operands))

    def _assignment(self, op: int, into: int, operands: tuple[str, ...]) -> _Statement:
        name, kind = f"t{len(self.parts) + 1}", "int" if op in _LOGICAL else "double"
        pattern, reads = self._merged_choice(op, operands) or (_pattern(op, operands), operands)
        self.slot[into] = name
        self.parts[name] = (op, operands)
        return _Statement(name, reads, f"const {kind} {name} = {pattern.format(*reads)};")

    def _merged_choice(
        self, op: int, operands: tuple[str, ...]
    ) -> tuple[str, tuple[str, ...]] | None:
        """(c ? a : 0) + (!c ? b : 0), which is how if_else arrives, as one choice."""
        if op != ca.OP_ADD:
            return None
        first, second = (self.parts.get(name, (-1, ())) for name in operands)
        if first[0] != ca.OP_IF_ELSE_ZERO or second[0] != ca.OP_IF_ELSE_ZERO:
            return None
        if self.parts.get(second[1][0]) != (ca.OP_NOT, (first[1][0],)):
            return None
        return "{0} ? {1} : {2}", (first[1][0], first[1][1], second[1][1])


def _needed(statements: list[_Statement]) -> list[_Statement]:
    """Without the assignments that nothing reads (parts of merged choices)."""
    live: set[str] = set()
    kept: list[_Statement] = []
    for item in reversed(statements):
        if not item.defines or item.defines in live:
            live.update(item.reads)
            kept.append(item)
    return kept[::-1]


def _pattern(op: int, operands: tuple[str, ...]) -> str:
    table = _BINARY if len(operands) == 2 else _UNARY
    if op not in table:
        raise NotImplementedError(f"CasADi operation {op} has no C form in wmr_ctrl.codegen.emit")
    return table[op]


def _number(value: float) -> str:
    text = repr(float(value))
    named = {"inf": "WMR_INF", "-inf": "(-WMR_INF)", "nan": "WMR_NAN"}
    return named.get(text, f"({text})" if text.startswith("-") else text)
