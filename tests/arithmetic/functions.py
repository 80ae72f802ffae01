"""The functions of fmu/runtime/arithmetic.h, compiled and called on arrays."""

import ctypes as ct
import functools
from pathlib import Path

import numpy as np

from wmr_ctrl.codegen.dialect import HEADER
from wmr_ctrl.codegen.resources import runtime_dir
from wmr_ctrl.codegen.toolchain import build_library, find_toolchain

ONES = ("exp", "expm1", "log", "log1p", "sin", "cos", "tan", "tanh", "sinh", "cosh", "asin",
        "acos", "atan", "sqrt", "floor", "ceil", "abs", "sign", "one_nan",
        "sin_of_both", "cos_of_both")  # fmt: skip
PAIRS = ("atan2", "hypot", "pow", "min", "max", "copysign")
EVERY = (*ONES, *PAIRS, "exp_many")
"""Functions, in the order of each.c."""

SOURCE = Path(__file__).parent / "each.c"


def files():
    """Sources of the library, by name."""
    paths = (SOURCE, runtime_dir() / HEADER)
    return {path.name: path.read_text(encoding="utf-8") for path in paths}


@functools.cache
def library(toolchain=None, flags=()):
    """All functions for one number, or with a flag -DWMR_LANES for lanes."""
    chosen = (toolchain or find_toolchain()).with_flags(*flags)
    loaded = ct.CDLL(str(build_library(files(), chosen, name="each")))
    loaded.hash_of.restype = ct.c_uint64
    return loaded


def called(name, a, b=None, *, of):
    """Function ``name`` of a library on arrays of one length."""
    size = -(-len(a) // 8) * 8
    out = np.resize(np.asarray(a, dtype=float), size)
    other = np.resize(np.asarray(a if b is None else b, dtype=float), size)
    pointers = (ct.c_void_p(item.ctypes.data) for item in (out, other))
    of[f"each_{name}"](*pointers, ct.c_int64(size))
    return out[: len(a)]


def hashes(of):
    """Hash of each function's results on each.c's own inputs; equal hashes mean equal bits."""
    return {name: f"{of.hash_of(ct.c_int32(place)):016x}" for place, name in enumerate(EVERY)}


def one(name):
    """Function ``name`` of single numbers, as this machine's compiler makes it."""
    entry, number = library()[f"each_{name}"], ct.c_double * 1

    def call(a, b=0.0):
        out, other = number(a), number(b)
        entry(out, other, ct.c_int64(1))
        return out[0]

    return call
