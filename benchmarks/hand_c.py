"""The hand-written C of ``hand/`` from Python: one step, one loop, or a timing loop at a time."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import layout
from .native import HERE, load
from .setup import Case, Setup

Array = NDArray[np.float64]
LAWS = ("mb", "nn")
"""In the order of hand.h's enumeration."""

_STATE_SIZE = {"mb": 0, "nn": 128}
_Vector = np.ctypeslib.ndpointer(dtype=np.float64, flags="C_CONTIGUOUS")
_Law, _Plant = ctypes.POINTER(layout.HandLaw), ctypes.POINTER(layout.HandPlant)
_Setup = ctypes.POINTER(layout.HandSetup)
_STEP = (_Law, _Vector, _Vector, _Vector)
_D, _N = ctypes.c_double, ctypes.c_int64
_SIGNATURES: dict[str, tuple[Any, tuple[Any, ...]]] = {
    "hand_sizes": (None, (ctypes.POINTER(_N),)),
    "hand_prepare": (None, (_Setup, _Law)),
    "hand_prepare_plant": (None, (_Setup, _D, _D, _D, _D, _Plant)),
    "hand_mb_step": (None, (*_STEP, _Vector)),
    "hand_nn_step": (None, (*_STEP, _Vector, _Vector)),
    "hand_plant_step": (None, (_Plant, _Vector, _Vector)),
    "hand_loop": (
        ctypes.c_int,
        (ctypes.c_int, _Setup, ctypes.POINTER(layout.HandCase), _Vector,
         ctypes.POINTER(layout.HandResult)),
    ),
    "hand_mb_repeat": (_D, (_Law, _N, _Vector, _N)),
    "hand_nn_repeat": (_D, (_Law, _N, _Vector, _N, _Vector)),
    "hand_plant_repeat": (_D, (_Plant, _N, _Vector, _N, _Vector)),
}  # fmt: skip


class HandC:
    """The library and, for one Setup, everything that can be called in it.

    Vectors are float64 arrays, ordered as in hand.h.  Raises CompilerError without a C compiler.
    """

    def __init__(self, setup: Setup | None = None, *, flags: Sequence[str] = ()) -> None:
        """Compile (unless cached) with the floor's flags and ``flags``, then prepare ``setup``."""
        self.library = _library(flags)
        self.raw = layout.fill_setup(setup or Setup())
        self.law = layout.HandLaw()
        self.library.hand_prepare(self.raw, self.law)

    def step(
        self, law: str, reference: Array, pose: Array, v: Array, state: Array | None = None
    ) -> Array:
        """Return the torques (2,) [N m]; ``state`` of nn (128,) is updated."""
        torque = np.empty(2)
        memory = () if law == "mb" else (state,)
        function = getattr(self.library, f"hand_{law}_step")
        function(self.law, reference, pose, v, *memory, torque)
        return torque

    def plant(self, m: float, inertia: float, mu: float, h: float) -> layout.HandPlant:
        """Return the plant's constants for steps of ``h`` seconds."""
        plant = layout.HandPlant()
        self.library.hand_prepare_plant(self.raw, m, inertia, mu, h, plant)
        return plant

    def loop(self, law: str, case: Case) -> tuple[layout.HandResult, Array]:
        """Run one closed loop; return what the monitor found and the law's final state."""
        result, state = layout.HandResult(), np.zeros(128)
        given = layout.fill_case(case)
        self.library.hand_loop(LAWS.index(law), self.raw, given, state, result)
        return result, state[: _STATE_SIZE[law]]

    def driven_state(self, law: str) -> Array:
        """Return the ``state`` of ``hand_<law>_driven``: the constants, then 128 zero weights."""
        constants = np.frombuffer(bytes(self.law), dtype=np.float64)
        return np.concatenate([constants, np.zeros(_STATE_SIZE[law])])


def _library(flags: Sequence[str]) -> ctypes.CDLL:
    files = sorted((HERE / "hand").glob("*.[ch]"))
    library = load(files, "hand", flags)
    for name, (result, arguments) in _SIGNATURES.items():
        function = getattr(library, name)
        function.restype, function.argtypes = result, arguments
    _check_layout(library)
    return library


def _check_layout(library: ctypes.CDLL) -> None:
    found = (ctypes.c_int64 * len(layout.STRUCTURES))()
    library.hand_sizes(found)
    wanted = [ctypes.sizeof(structure) for structure in layout.STRUCTURES]
    if list(found) != wanted:
        raise RuntimeError(f"layout.py does not match hand.h: {wanted} bytes, not {list(found)}.")
