"""The robot and its reference on the host, from the compiled kernels, sample by sample."""

from __future__ import annotations

import numpy as np
from wmr_ctrl.sim.structs import REALS

from wmr_ctrl.codegen.build import build_loop
from wmr_ctrl.scenario import Scenario
from wmr_ctrl.sim.native import load


class Robot:
    """State x, y [m], theta [rad], v1 [m/s], omega [rad/s], without noise."""

    def __init__(self, scenario: Scenario, start: np.ndarray | None = None) -> None:
        kernels = build_loop(scenario, "mb")
        systems = kernels.manifest["systems"]
        library = load(kernels.library)
        self.clock = scenario.clock
        self._plant, self._reference = (
            library.wmr_export_plant_step, library.wmr_export_reference
        )  # fmt: skip
        self._plant.restype = self._reference.restype = None
        self._plant_p, self._reference_p = (
            np.array(systems[role]["parameter_values"]) for role in ("plant", "reference")
        )
        self.state = np.array(systems["plant"]["start"] if start is None else start, dtype=float)
        self.fastest = abs(self.state[3:])

    def reference(self, k: int) -> np.ndarray:
        """Desired trajectory at sample k."""
        found = np.zeros(7)
        _call(self._reference, np.array([k * self.clock.control]), self._reference_p, found)
        return found

    def inputs(self, k: int) -> np.ndarray:
        """What the law is given at sample k."""
        return np.concatenate([self.reference(k), self.state])

    def advance(self, torque: np.ndarray) -> None:
        """One control period with the torques held."""
        u, following = np.array([*torque, 0.0, 0.0]), np.zeros(5)
        for _ in range(self.clock.substeps):
            _call(self._plant, u, self.state, self._plant_p, following)
            self.state, following = following, self.state
            self.fastest = np.maximum(self.fastest, abs(self.state[3:]))

    def distance(self, k: int) -> float:
        """From the desired position at sample k [m]."""
        return float(np.hypot(*(self.state[:2] - self.reference(k)[:2])))


def _call(function: object, *arrays: np.ndarray) -> None:
    function(*(item.ctypes.data_as(REALS) for item in arrays))
