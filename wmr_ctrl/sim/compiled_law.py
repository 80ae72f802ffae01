"""A law's compiled controller, called from Python without copies."""

from __future__ import annotations

import ctypes as ct

import numpy as np
from numpy.typing import NDArray

from wmr_ctrl.signals import Signal
from wmr_ctrl.sim.native import Kernels, load
from wmr_ctrl.sim.structs import Call

Floats = NDArray[np.float64]


class CompiledLaw:
    """One control sample of a law: ``torque = law.step()`` on arrays that stay in place.

    Write the inputs into ``u`` (order: ``inputs``; reference, pose, velocity) and call `step`: it
    returns ``torque`` (right, left) [N m] and moves the law's memory ``x`` (order: ``state``) to
    the next sample.  ``parameters`` may be changed in place, in the order of ``parameter_names``.
    None of the four arrays may be replaced by another one.
    """

    def __init__(self, kernels: Kernels) -> None:
        """Load the library of ``kernels`` and set start values."""
        role = kernels.manifest["systems"]["controller"]
        self.inputs = tuple(Signal(**item).name for item in role["inputs"])
        self.state = tuple(name for item in role["state"] for name in Signal(**item).elements)
        self.parameter_names = tuple(
            name for item in role["parameters"] for name in Signal(**item).elements
        )
        self._start = np.array(role["start"], dtype=float)
        self.u: Floats = np.zeros(role["sizes"]["NU"])
        self.parameters: Floats = np.array(role["parameter_values"], dtype=float)
        self.torque: Floats = np.zeros(2)
        self.x: Floats = self._start.copy()
        self._arrays = (self.u, self.parameters, self.x, self.torque)
        self._pointers = Call(*(item.ctypes.data for item in self._arrays))
        load(kernels.library)  # says what is wrong with a library that cannot be loaded
        # A step is shorter than letting go of Python's lock; and the function takes its one
        # argument as it is, since conversion would cost as much as the call.
        self._call = ct.PyDLL(kernels.library)["wmr_law_step"]
        self._call.restype = None
        self._pointer = ct.byref(self._pointers)

    def reset(self) -> None:
        """Start values for the law's memory."""
        self.x[:] = self._start

    def step(self) -> Floats:
        """Evaluate the law once; returns ``torque``."""
        self._call(self._pointer)
        return self.torque
