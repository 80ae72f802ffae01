"""A sampled System as a compiled C function with its memory."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from wmr_ctrl.codegen.dialect import HEADER
from wmr_ctrl.codegen.kernels import controller_kernel
from wmr_ctrl.codegen.resources import runtime_dir
from wmr_ctrl.codegen.source import plain_sources
from wmr_ctrl.codegen.toolchain import build_library
from wmr_ctrl.model.system import System

VISIBLE = ("-fvisibility=default",)
"""The library is the kernel alone, which is called by its name."""


class CompiledSystem:
    """A System's C function: a step takes some microseconds from Python.

    ``x`` is the state, in the order of the System's; it may be changed in place.
    """

    def __init__(self, system: System, name: str) -> None:
        """Compile the graph, unless it is in the cache.  Raises CompilerError."""
        kernel = controller_kernel(system, name)
        header = {HEADER: (runtime_dir() / HEADER).read_text(encoding="utf-8")}
        path = build_library(plain_sources([kernel], name) | header, name=name, flags=VISIBLE)
        self._step = ctypes.CDLL(str(path))[f"wmr_{name}"]
        self._step.restype = None
        self.start_values: NDArray[np.float64] = np.array(system.x0)
        self.x: NDArray[np.float64] = self.start_values.copy()
        self._u, self._y = np.zeros(system.u.numel()), np.zeros(system.y.numel())
        self._p, self._next = np.array(system.p0), self.x.copy()
        arrays = (self._u, self.x, self._p, self._next, self._y)
        self._pointers = [ctypes.c_void_p(item.ctypes.data) for item in arrays]

    def start(self) -> None:
        """Start values for the state."""
        self.x[:] = self.start_values

    def look(self, u: Sequence[float]) -> list[float]:
        """The outputs for inputs ``u``; the state stays until `move`."""
        self._u[:] = u
        self._step(*self._pointers)
        return self._y.tolist()

    def move(self) -> None:
        """Take the next state of what was looked at last."""
        self.x[:] = self._next

    def step(self, u: Sequence[float]) -> list[float]:
        """The outputs for inputs ``u``, and the next state."""
        y = self.look(u)
        self.move()
        return y
