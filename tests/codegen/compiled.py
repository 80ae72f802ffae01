"""Compile single kernels and call them on arrays."""

import ctypes as ct
import shutil

import casadi as ca
import numpy as np

from tests.arithmetic.functions import one
from tests.compilers import compile_in
from wmr_ctrl.codegen.emit import QUALIFIERS, definition, kernel
from wmr_ctrl.codegen.resources import runtime_dir
from wmr_ctrl.codegen.toolchain import build_library, find_toolchain

_HEAD = '#define WMR_KERNEL __attribute__((visibility("default")))\n#include "arithmetic.h"\n'
REALS = ct.POINTER(ct.c_double)
ELEMENTARY = {ca.OP_EXP: "exp", ca.OP_LOG: "log", ca.OP_SIN: "sin", ca.OP_COS: "cos"}
"""Elementary functions, whose last digits may differ; all other operations have one correct result.
"""


def made(y, name="made", *, prepared=False, **inputs):
    """A kernel of one output."""
    return kernel(name, "A kernel of a test.", inputs, {"y": y}, prepared=prepared)


def compiled(kernels, *, native=False):
    """Callables of kernels with one output vector, from one library."""
    text = "\n".join((_HEAD, QUALIFIERS, *map(definition, kernels)))
    header = (runtime_dir() / "arithmetic.h").read_text("utf-8")
    path = build_library({"one.c": text, "arithmetic.h": header}, find_toolchain(native=native))
    library = ct.CDLL(str(path))
    return [_callable(library[f"wmr_{item.name}"], item.function) for item in kernels]


def runtime_library(folder, name, *flags):
    """One of the runtime's parts alone, by this machine's compiler."""
    for file in (f"{name}.c", f"{name}.h"):
        shutil.copy(runtime_dir() / file, folder)
    own = ["-std=c99", "-shared", "-fPIC", f"{name}.c", "-o", "part.so"]
    compile_in(folder, [*find_toolchain().command, *flags, *own])
    return ct.CDLL(str(folder / "part.so"))


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
    """Evaluator that steps through CasADi's list of instructions, with our elementary functions."""
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
                numbers = [float(work[i]) for i in operands]
                exact = ca.DM.unary if len(numbers) == 1 else ca.DM.binary
                work[into[0]] = calls[op](*numbers) if op in calls else float(exact(op, *numbers))
        return out

    return run
