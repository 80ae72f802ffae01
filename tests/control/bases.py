"""Bases that take velocities, with a speed loop of the first order, and one behind a governor."""

from tests.papers_robot import preset
from tests.tables import changes

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


def based(*parts):
    """An ideal world with a base, each part a mapping or text of `tests.tables`."""
    return preset("paper-simulation-noise-free", "changes = []", *parts)
