"""Scenarios of further adversaries: bases that take velocities, late commands, lost poses."""

from __future__ import annotations

import numpy as np

from benchmarks.corridor_adversary import Attacked
from tests.papers_robot import preset, safe
from tests.tables import changes

EXACT = changes("""
    disturbance.std = 0.0
    sensor.pose_noise = 0.0
    sensor.velocity_noise = [0.0, 0.0]
""")
QUICK = changes("gains.kanayama.k = [3.57, 64.6, 16.1]")
"""Gains with which kanayama stays close to its path, for the preset without noise."""
PUSHED = changes("""
    disturbance.std = 1e-4
    disturbance.truncate = 3.0
    clock.plant = 0.005
""")
QUIET = {"clock.plant": 0.005}
WIDE = changes("limits.v_u2 = [0.21, 2.6]; filter.kind = none")


def burger(*parts):
    """An exact TurtleBot3 with some changes."""
    return preset("turtlebot3-burger", EXACT, QUICK, *parts)


def simulated(*parts):
    """safe-simulation, pushed by 0.3 N m, without guard and change, with some changes."""
    return safe("disturbance.std = 0.1; guard.enabled = false; changes = []", *parts)


def lossy(times):
    """Keys of a scenario in which up to ``times`` poses in a row may be lost."""
    return {"sensor.pose_dropout": 0.1, "corridor.losses": times}


def farthest_lost(scenario, pushes, come, velocities=None, law="prox"):
    """Largest distance and turn if poses arrive at samples where ``come`` is 1 and are lost where
    it is 0.
    """
    found = []
    for k, push in enumerate(pushes):
        velocity = None if velocities is None else velocities[k]
        loop = Attacked(scenario, law, push, np.zeros_like(push), velocity)
        loop.sensor.chance = np.resize(come, len(push)).astype(float)
        loop.run()
        e = np.array(loop.errors)
        found.append((np.hypot(e[:, 0], e[:, 1]).max(), np.abs(e[:, 2]).max()))
    return np.max(found, axis=0)


GUARDED = changes("guard.enabled = true; disturbance.truncate = 3.0")
