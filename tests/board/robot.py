"""The robot and its reference on the host, sample by sample."""

import numpy as np

from wmr_ctrl.export.fmi.blocks import stepped_plant
from wmr_ctrl.world.references.kind import reference


class Robot:
    """State x, y [m], theta [rad], v1 [m/s], omega [rad/s], without noise."""

    def __init__(self, scenario, start=None):
        (plant, step), desired = stepped_plant(scenario), reference(scenario)
        self.clock = scenario.clock
        self._step, self._plant_p = step.function, plant.p0
        self._reference, self._p = desired.function("desired", [desired.y]), desired.p0
        self._more = np.zeros(plant.u.numel() - 2)
        self.state = np.array(plant.x0 if start is None else start, dtype=float)
        self.velocities = [self.state[3:]]

    def reference(self, k):
        """Desired trajectory at sample k."""
        return self._reference(k * self.clock.control, [], self._p).full().ravel()

    def inputs(self, k):
        """Inputs of the law at sample k."""
        return np.concatenate([self.reference(k), self.state])

    def advance(self, torque):
        """One control period with the torques held."""
        u = np.concatenate([torque, self._more])
        for _ in range(self.clock.substeps):
            self.state = self._step(u, self.state, self._plant_p).full().ravel()
            self.velocities.append(self.state[3:])

    def distance(self, k):
        """Distance from the desired position at sample k [m]."""
        return float(np.hypot(*(self.state[:2] - self.reference(k)[:2])))
