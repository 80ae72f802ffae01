"""A law's compiled controller, called from Python without copies, and its run time."""

import ctypes as ct
import timeit

import numpy as np

from wmr_ctrl.core.compiled import CompiledLoop
from wmr_ctrl.core.errors import ArgumentError
from wmr_ctrl.core.paper import EVALUATIONS
from wmr_ctrl.core.signals import LARGEST, elements
from wmr_ctrl.results import Floats

from .memory import opened

START_SAMPLE = (0.0, 0.0, -1.5707963, 0.2, 0.1, 0.0, 0.0, -0.5, -0.5, -0.7, 0.3, -0.4)
"""A sample near the paper's start: reference, pose, velocity."""
ROUNDS = 9
"""Repetitions: the least time is the one that nothing else delayed."""


ARRAYS = ("u", "parameters", "x", "torque")
"""Arrays of a law that the compiled code reads and writes where they are."""


class Call(ct.Structure):
    """``wmr_call``: addresses of a law's inputs, parameters, memory, outputs; the inputs' bound."""

    _fields_ = (*((name, ct.c_void_p) for name in ("u", "p", "x", "y")), ("largest", ct.c_double))


class CompiledLaw:
    """One control sample of a law: ``torque = law.step()``, on arrays that are reused.

    Write the inputs into ``u`` (order: ``inputs``; reference, pose, velocity) and call `step`: it
    returns ``torque`` (right, left) [N m] and moves the law's memory ``x`` (order: ``state``) to
    the next sample. ``parameters`` may be changed, in the order of ``parameter_names``. Assigning
    to one of the four arrays writes into it: ``law.u = values`` is ``law.u[:] = values``. A sample
    with an input that is NaN, or above 1e12 in size, is refused: ArgumentError, torques 0, memory
    unchanged.
    """

    def __init__(self, loop: CompiledLoop) -> None:
        """Load the library of ``loop`` and set start values."""
        law = loop.law
        self.inputs = tuple(signal.name for signal in law.inputs)
        self.state, self.parameter_names = elements(law.state), elements(law.parameters)
        self._names = elements(law.inputs)
        self._start = np.array(law.start, dtype=float)
        self.u: Floats = np.zeros(len(self._names))
        self.parameters: Floats = np.array(law.values, dtype=float)
        self.torque: Floats = np.zeros(2)
        self.x: Floats = self._start.copy()
        arrays = self.u, self.parameters, self.x, self.torque
        pointers = Call(*(item.ctypes.data for item in arrays), LARGEST)
        opened(loop.library)  # says what is wrong with a library that cannot be loaded
        # A step is shorter than letting go of Python's lock; and the function takes its one
        # argument as it is, since conversion would cost as much as the call.
        self._call = ct.PyDLL(loop.library)["wmr_law_step"]
        self._call.restype = ct.c_int32
        self._pointer = ct.byref(pointers)  # it keeps them

    def __setattr__(self, name: str, value: object) -> None:
        """Write into the arrays in place, as compiled code has their addresses.

        Raises ArgumentError for a wrong size.
        """
        array = vars(self).get(name) if name in ARRAYS else None
        if array is None:
            object.__setattr__(self, name, value)
            return
        given = np.asarray(value)
        if given.shape != array.shape or given.dtype.kind not in "fiu":
            raise ArgumentError(
                f"{name} takes {len(array)} real numbers, not an array of {given.dtype} with shape "
                f"{given.shape}."
            )
        array[:] = given

    def reset(self) -> None:
        """Set the law's memory to its start values."""
        self.x[:] = self._start

    def step(self) -> Floats:
        """Evaluate the law once; returns ``torque``.  Raises ArgumentError for a refused sample."""
        if not self._call(self._pointer):
            return self.torque
        given = zip(self._names, self.u, strict=True)
        what = ", ".join(f"{name} = {x:g}" for name, x in given if not abs(x) <= LARGEST)
        raise ArgumentError(
            f"the sample is refused: {what or 'its torques or memory'} must be finite and at most "
            f"{LARGEST:g} in size. The torques are 0 and the law's memory is unchanged; check what "
            "was written into u and parameters."
        )


def seconds_of(law: CompiledLaw) -> float:
    """Least of `ROUNDS` times [s] for `EVALUATIONS` evaluations of ``law``, with one call each."""
    law.u[:] = START_SAMPLE
    return min(timeit.repeat(law.step, law.reset, repeat=ROUNDS, number=EVALUATIONS))
