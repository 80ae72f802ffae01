"""Bases that take velocities, with a speed loop of the first order, and one behind a governor."""

from tests.tables import changes
from wmr_ctrl.world.scenario import load_scenario, override

VELOCITY = changes("""
    base = {kind = "velocity", tau = [0.2, 0.25], gain = [1.05, 0.95]}
    clock.control = 0.05
    clock.duration = 6.0
    limits = {v_u1 = [1.0, 2.0], v_u2 = [0.7, 1.4]}
""")
GOVERNED = VELOCITY | changes("""
    filter.kind = governor
    filter.tau = [0.2, 0.3]
    filter.gain = [0.9, 1.1]
    filter.odometry = [0.01, 0.01]
""")


def based(overrides, **further):
    given = {**overrides, **{key.replace("__", "."): value for key, value in further.items()}}
    return override(load_scenario("paper-simulation-noise-free"), {"changes": [], **given})
