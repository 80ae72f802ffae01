"""Inputs that no robot has, into the C package of every law: refused, or a finite torque."""

from __future__ import annotations

import ctypes as ct
import itertools
import math
import subprocess
from pathlib import Path

import numpy as np
import pytest

from tests.codegen.test_package import needs, written
from wmr_ctrl.codegen.single_precision import LARGEST_SINGLE
from wmr_ctrl.control.controller import controller
from wmr_ctrl.control.setup import settle
from wmr_ctrl.core.signals import LARGEST
from wmr_ctrl.world.scenario import load_scenario

ANGLES = (2, 9)
"""Places of theta_d and theta, which grow without end."""
GOOD = (0.1, 0.0, -1.5, 0.2, 0.1, 0.0, 0.0, -0.1, -0.2, -0.7, 0.1, 0.05)
REFUSED, TAKEN = 1, 0


class Packaged:
    """A package's step in a library, with memory and parameters of its own."""

    def __init__(self, law: str, folder: Path, float32: bool, guarded: bool) -> None:
        needs("cc")
        written(law, folder, float32, guarded)
        flags = ["-std=c99", "-O1", "-ffp-contract=off", "-fPIC", "-shared"]
        source, library = folder / f"wmr_{law}.c", folder / "law.so"
        subprocess.run(["cc", *flags, source, "-o", library, "-lm"], check=True)
        system = controller(settle(load_scenario("safe-simulation" if guarded else
                                                 "paper-simulation"), law))  # fmt: skip
        self.real = np.float32 if float32 else np.float64
        self.largest = LARGEST_SINGLE if float32 else LARGEST
        self.memory = np.zeros(max(system.x.numel(), 1), self.real)
        self.parameters = np.zeros(system.p.numel(), self.real)
        self.torque = np.zeros(2, self.real)
        loaded = ct.CDLL(str(library))
        self._step = getattr(loaded, f"wmr_{law}_step")
        getattr(loaded, f"wmr_{law}_defaults")(self._at(self.parameters))
        getattr(loaded, f"wmr_{law}_start")(self._at(self.memory))

    def _at(self, array: np.ndarray) -> ct.c_void_p:
        return ct.c_void_p(array.ctypes.data)

    def step(self, inputs: np.ndarray) -> int:
        given = np.array(inputs, self.real)
        arrays = (self.parameters, self.memory, given, self.torque)
        return self._step(*map(self._at, arrays))

    @property
    def sound(self) -> bool:
        return bool(np.isfinite(self.memory).all() and np.isfinite(self.torque).all())


@pytest.mark.parametrize(
    ("law", "float32", "guarded"),
    [
        ("pid", False, False),
        ("smc", True, False),
        pytest.param("nn", True, True, marks=pytest.mark.slow),
        pytest.param("pursuit", False, True, marks=pytest.mark.slow),
    ],
)
def test_what_is_too_large_is_refused_and_leaves_no_trace(
    law: str, float32: bool, guarded: bool, tmp_path: Path
) -> None:
    """Each input that has a bound, of either sign, and no number: torques 0; then as before."""
    one = Packaged(law, tmp_path, float32, guarded)
    sizes = (1.7e308, 1.0001 * one.largest, math.inf, math.nan)
    for _ in range(3):
        assert one.step(GOOD) == TAKEN
    kept = one.memory.copy()
    for at, size, sign in itertools.product(range(len(GOOD)), sizes, (-1.0, 1.0)):
        given = np.array(GOOD)
        given[at] = sign * size
        if at in ANGLES and size < float(np.finfo(one.real).max):
            continue
        with np.errstate(over="ignore"):
            assert one.step(given) == REFUSED, (at, given[at])
        assert (one.torque == 0).all()
        assert (one.memory == kept).all()
    assert one.step(GOOD) == TAKEN
    assert one.sound
    assert one.torque.any()
