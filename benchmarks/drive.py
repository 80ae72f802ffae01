"""Python side of drive.c: time any control step from C, by its pointer, over a ring of inputs."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .native import HERE, load

Array = NDArray[np.float64]
_Vector = np.ctypeslib.ndpointer(dtype=np.float64, flags="C_CONTIGUOUS")
_N = ctypes.c_int64


def in_place(step: Any, rows: Array, state: Array, outputs: int) -> Callable[[int], float]:
    """Return a loop of n calls ``step(row, state, out)``; it returns the sum of all outputs.

    ``step`` is a ctypes function or an address, ``rows`` has shape (count, inputs), ``state`` is
    changed in place.
    """
    out, rows = np.zeros(outputs), np.ascontiguousarray(rows)
    count, width = rows.shape
    function, pointer = _driver().drive, ctypes.cast(step, ctypes.c_void_p)

    def run(n: int) -> float:
        return float(function(pointer, n, rows, count, width, state, out, outputs))

    return run


def out_of_place(
    step: Any, rows: Array, x: Array, p: Array, outputs: int
) -> Callable[[int], float]:
    """Return a loop of n calls ``step(u, x, p, next, y)`` with x and next changing places."""
    y, rows = np.zeros(outputs), np.ascontiguousarray(rows)
    one, other = np.array(x, dtype=np.float64), np.zeros_like(x, dtype=np.float64)
    count, width = rows.shape
    function, pointer = _driver().drive_kernel, ctypes.cast(step, ctypes.c_void_p)

    def run(n: int) -> float:
        return float(function(pointer, n, rows, count, width, one, other, p, y, outputs))

    return run


def plant_only(step: Any, rows: Array, x: Array, p: Array) -> Callable[[int], float]:
    """Return a loop of n plant steps ``step(i, u, x, p, w, next)`` from ``x``, without draws w."""
    rows = np.ascontiguousarray(rows)
    count, width = rows.shape
    function, pointer = _driver().drive_plant, ctypes.cast(step, ctypes.c_void_p)

    def run(n: int) -> float:
        one, other = np.array(x, dtype=np.float64), np.zeros_like(x, dtype=np.float64)
        return float(function(pointer, n, rows, count, width, one, other, p))

    return run


@cache
def _driver() -> ctypes.CDLL:
    library = load([HERE / "drive.c"], "drive")
    for name in ("drive", "drive_kernel", "drive_plant"):
        getattr(library, name).restype = ctypes.c_double
    ring = (ctypes.c_void_p, _N, _Vector, _N, _N)
    library.drive.argtypes = (*ring, _Vector, _Vector, _N)
    library.drive_plant.argtypes = (*ring, _Vector, _Vector, _Vector)
    library.drive_kernel.argtypes = (*ring, _Vector, _Vector, _Vector, _Vector, _N)
    return library
