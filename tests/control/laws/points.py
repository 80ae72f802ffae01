"""Laws' graphs at single points, compared with their twins in `tests.oracle`."""

from types import SimpleNamespace

import numpy as np
import pytest

from tests.oracle.loop import _Loop
from tests.oracle.target import DesiredState
from tests.papers_robot import paper
from wmr_ctrl.control.controller import law_graph
from wmr_ctrl.control.setup import settle
from wmr_ctrl.world.scenario import override

T, M = 0.01, 50.0
DRIVING = {"x_d": 0.1, "y_d": 0.2, "theta_d": 0.3, "v1_d": 0.4, "v2_d": 0.2, "x": 0.08, "y": 0.15,
           "theta": 0.25, "v1": 0.45, "omega": 0.1}  # fmt: skip
SPREAD = (0.5, 0.5, 3.0, 0.4, 0.8, 0.5, 0.5)
"""Half-widths of the desired states that are drawn, in the order of a DesiredState."""


def graph(law, **changed):
    return law_graph(settle(override(paper(), changed), law))


def at(system, given, memory=None):
    """Return output and next memory for inputs and memory given by name; omitted values are 0."""
    u = [given.get(name, 0.0) for item in system.inputs for name in item.signal.elements]
    x = [number for item in system.state
         for number in (memory or {}).get(item.signal.name, [0.0] * item.signal.size)]  # fmt: skip
    step = system.function("step", [system.y, system.update])
    return [np.asarray(part).ravel() for part in step(u, x, system.p0)]


def assert_twin(law, samples=80, **changed):
    """Assert that a law's forces equal the oracle's, over random samples.

    Desired states are anywhere.  The robot is near or far from them, with speeds at which friction
    is partly or fully developed.  Torques are random, too.  Returns the forces (samples, 2).
    """
    scenario = override(paper(), changed)
    setup = settle(scenario, law)
    system, twin = (
        law_graph(setup),
        _Loop(scenario, law, vars(setup.gains), vars(setup.kinematics), 0),
    )
    step, x, forces = system.function("step", [system.update, system.y]), system.x0, []
    draw = np.random.default_rng(5)
    for k in range(samples):
        desired = draw.uniform(-1, 1, 7) * SPREAD
        pose = desired[:3] + draw.uniform(-1, 1, 3) * 10 ** draw.uniform(-2, 0, 3)
        v = draw.uniform(-0.9, 0.9, 2) * draw.choice([0.03, 1.0])
        applied, sent = draw.uniform(-5, 5, 2), draw.uniform(-5, 5, 2)
        twin.sensor = SimpleNamespace(look=lambda *_, seen=(tuple(pose), tuple(v)): seen)
        twin.applied = tuple(applied)
        sight = twin._look(k, DesiredState(*desired))
        inputs = {"tau_applied": applied}
        inputs |= {f"tau_sent{age}": pair for age, pair in enumerate(sight.sent, start=1)}
        further = [inputs.get(item.signal.name, np.zeros(2)) for item in system.inputs[12:]]
        x, force = step(np.concatenate([desired, pose, v, *further]), x, system.p0)
        forces.append(force.full().ravel())
        wanted = twin.law.act(sight)
        assert forces[-1] == pytest.approx(wanted, rel=1e-8, abs=1e-8), k
        twin.sent.appendleft(tuple(sent))
    return np.array(forces)
