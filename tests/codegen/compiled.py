"""Compile single kernels and call them on arrays."""

from __future__ import annotations

import ctypes as ct
from collections.abc import Callable, Sequence

import casadi as ca
import numpy as np

from wmr_ctrl.codegen.emit import Kernel, definition
from wmr_ctrl.codegen.resources import runtime_dir
from wmr_ctrl.codegen.toolchain import build_library, find_toolchain

_HEAD = '#define WMR_KERNEL __attribute__((visibility("default")))\n#include "arithmetic.h"\n\n'
REALS = ct.POINTER(ct.c_double)


def compiled(kernels: Sequence[Kernel], *, native: bool = False) -> list[Callable[..., np.ndarray]]:
    """Callables of kernels with one output vector, from one library."""
    text = _HEAD + "\n".join(definition(item) for item in kernels)
    header = (runtime_dir() / "arithmetic.h").read_text(encoding="utf-8")
    path = build_library({"one.c": text, "arithmetic.h": header}, find_toolchain(native=native))
    library = ct.CDLL(str(path))
    return [_callable(library[f"wmr_{item.name}"], item.function) for item in kernels]


def _callable(entry: Callable[..., None], function: ca.Function) -> Callable[..., np.ndarray]:
    entry.restype = None

    def call(*given: np.ndarray) -> np.ndarray:
        out = np.zeros(function.numel_out(0))
        arrays = [np.ascontiguousarray(item, dtype=float) for item in given]
        entry(*(item.ctypes.data_as(REALS) for item in (*arrays, out)))
        return out

    return call


def machine(item: Kernel) -> Callable[..., np.ndarray]:
    """The same by CasADi's virtual machine."""
    return lambda *given: item.function(*given).full().ravel()
