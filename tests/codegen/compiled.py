"""Compile single kernels and call them on arrays."""

import ctypes as ct
import math

import casadi as ca
import numpy as np

from tests.arithmetic.functions import one
from wmr_ctrl.codegen.emit import QUALIFIERS, definition
from wmr_ctrl.codegen.resources import runtime_dir
from wmr_ctrl.codegen.toolchain import build_library, find_toolchain

_HEAD = '#define WMR_KERNEL __attribute__((visibility("default")))\n#include "arithmetic.h"\n'
REALS = ct.POINTER(ct.c_double)
ELEMENTARY = {
    ca.OP_EXP: "exp", ca.OP_LOG: "log", ca.OP_SIN: "sin", ca.OP_COS: "cos",
}  # fmt: skip
EXACT = {
    ca.OP_ASSIGN: lambda a: a, ca.OP_ADD: lambda a, b: a + b, ca.OP_SUB: lambda a, b: a - b,
    ca.OP_MUL: lambda a, b: a * b, ca.OP_DIV: lambda a, b: a / b, ca.OP_NEG: lambda a: -a,
    ca.OP_SQ: lambda a: a * a, ca.OP_TWICE: lambda a: 2 * a, ca.OP_INV: lambda a: 1 / a,
    ca.OP_SQRT: math.sqrt, ca.OP_FABS: abs, ca.OP_FMIN: min, ca.OP_FMAX: max,
    ca.OP_SIGN: lambda a: (a > 0) - (a < 0), ca.OP_LT: lambda a, b: a < b,
    ca.OP_LE: lambda a, b: a <= b, ca.OP_NOT: lambda a: not a, ca.OP_AND: lambda a, b: a and b,
    ca.OP_OR: lambda a, b: a or b, ca.OP_IF_ELSE_ZERO: lambda a, b: b if a else 0.0,
}  # fmt: skip
"""Operations of which there is only one right result."""


def compiled(kernels, *, native=False):
    """Callables of kernels with one output vector, from one library."""
    text = "\n".join((_HEAD, QUALIFIERS, *map(definition, kernels)))
    header = (runtime_dir() / "arithmetic.h").read_text("utf-8")
    path = build_library({"one.c": text, "arithmetic.h": header}, find_toolchain(native=native))
    library = ct.CDLL(str(path))
    return [_callable(library[f"wmr_{item.name}"], item.function) for item in kernels]


def _callable(entry, function):
    entry.restype = None
    arrays = [np.zeros(function.numel_in(i)) for i in range(function.n_in())]
    out = np.zeros(function.numel_out(0))
    pointers = [item.ctypes.data_as(REALS) for item in (*arrays, out)]

    def call(*given):
        for array, numbers in zip(arrays, given, strict=True):
            array[:] = numbers
        entry(*pointers)
        return out.copy()

    return call


def machine(item):
    """The same by CasADi's list of instructions, one by one, with our elementary functions."""
    f, calls = item.function, {op: one(name) for op, name in ELEMENTARY.items()}
    listed = [
        (f.instruction_id(k), f.instruction_output(k), f.instruction_input(k), k)
        for k in range(f.n_instructions())
    ]

    def run(*given):
        work, out = np.zeros(f.sz_w()), np.zeros(f.numel_out(0))
        for op, into, operands, k in listed:
            if op == ca.OP_INPUT:
                work[into[0]] = np.ravel(given[operands[0]])[operands[1]]
            elif op == ca.OP_OUTPUT:
                out[into[1]] = work[operands[0]]
            elif op == ca.OP_CONST:
                work[into[0]] = f.instruction_constant(k)
            else:
                made = calls.get(op) or EXACT[op]
                work[into[0]] = made(*(float(work[i]) for i in operands))
        return out

    return run
