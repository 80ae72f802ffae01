"""A law's compiled controller, called from Python without copies."""

from __future__ import annotations

import ctypes as ct
from typing import Any

import numpy as np
from numpy.typing import NDArray

from wmr_ctrl.signals import Signal
from wmr_ctrl.sim.native import Kernels, load
from wmr_ctrl.sim.structs import REALS

Floats = NDArray[np.float64]


class CompiledLaw:
    """One control sample of a law: ``torque = law.step()`` on arrays that stay in place.

    Write the inputs into ``u`` (order: ``inputs``; reference, pose, velocity) and call `step`: it
    returns ``torque`` (right, left) [N m] and moves the law's memory ``x`` (order: ``state``) to
    the next sample.  ``parameters`` may be changed in place, in the order of ``parameter_names``.
    """

    def __init__(self, kernels: Kernels) -> None:
        """Load the library of ``kernels`` and set start values."""
        role = kernels.manifest["systems"]["controller"]
        self.inputs = tuple(Signal(**item).name for item in role["inputs"])
        self.state = tuple(name for item in role["state"] for name in Signal(**item).elements)
        self.parameter_names = tuple(
            name for item in role["parameters"] for name in Signal(**item).elements
        )
        self.u: Floats = np.zeros(role["sizes"]["NU"])
        self.parameters: Floats = np.array(role["parameter_values"], dtype=float)
        self.torque: Floats = np.zeros(2)
        self._start = np.array(role["start"], dtype=float)
        self._memory = [np.zeros(len(self._start) + 1), np.zeros(len(self._start) + 1)]
        self._call = load(kernels.library).wmr_export_controller_step
        self._call.restype, self._call.argtypes = None, [REALS] * 5
        self._pointers = self._both_ways()
        self.reset()

    @property
    def x(self) -> Floats:
        """The law's memory now."""
        return self._memory[self._now][: len(self._start)]

    def reset(self) -> None:
        """Start values for the law's memory."""
        self._now = 0
        self.x[:] = self._start

    def step(self) -> Floats:
        """Evaluate the law once; returns ``torque``."""
        self._call(*self._pointers[self._now])
        self._now = 1 - self._now
        return self.torque

    def _both_ways(self) -> list[tuple[Any, ...]]:
        u, p, y = (_pointer(item) for item in (self.u, self.parameters, self.torque))
        first, second = (_pointer(item) for item in self._memory)
        return [(u, first, p, second, y), (u, second, p, first, y)]


def _pointer(array: Floats) -> Any:
    return array.ctypes.data_as(ct.POINTER(ct.c_double))
