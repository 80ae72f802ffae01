"""Laws' graphs at single points."""

import numpy as np

from tests.papers_robot import paper
from wmr_ctrl.control.controller import law_graph
from wmr_ctrl.control.setup import settle
from wmr_ctrl.world.scenario import override

T, M, INERTIA, R, HALF = 0.01, 50.0, 5.4, 0.1, 0.25
DRIVING = {"x_d": 0.1, "y_d": 0.2, "theta_d": 0.3, "v1_d": 0.4, "v2_d": 0.2, "x": 0.08, "y": 0.15,
           "theta": 0.25, "v1": 0.45, "omega": 0.1}  # fmt: skip


def graph(law, **changed):
    return law_graph(settle(override(paper(), changed), law))


def at(system, given, memory=None):
    """Output and next memory for inputs and memory by name; what is not named is 0."""
    u = [given.get(name, 0.0) for item in system.inputs for name in item.signal.elements]
    x = [number for item in system.state
         for number in (memory or {}).get(item.signal.name, [0.0] * item.signal.size)]  # fmt: skip
    step = system.function("step", [system.y, system.update])
    return [np.asarray(part).ravel() for part in step(u, x, system.p0)]
