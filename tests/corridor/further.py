"""Cases for the further adversaries: bases that take velocities, late commands, lost poses.

`benchmarks.corridor_further` makes the page's table of them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from tests.corridor import late, sending
from tests.corridor.adversary import Attacked, worst_pushes
from tests.papers_robot import preset, safe
from tests.tables import changes
from wmr_ctrl.world.scenario import Scenario

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
PI = changes("""
    base.loop = pi
    base.kp = 10.0
    base.ki = 20.0
    filter.kind = none
""")
WIDE = changes("limits.v_u2 = [0.21, 2.6]; filter.kind = none")
POSES = {**QUIET, "sensor.pose_noise": 5e-4}
RAMP = changes("""
    filter.kind = clip
    base.accel = [0.5, 3.0]
    base.decel = [0.5, 3.0]
    filter.d = [0.01, 0.1]
""")
BASES = {
    "turtlebot3-burger, kanayama, 0.3 mN m": ("kanayama", "push", PUSHED, 90),
    "the same, gains of 1.02 and 0.98":
        ("kanayama", "push", {**PUSHED, "base.gain": [1.02, 0.98]}, 90),
    "the same, acceleration limited to 0.5 m/s2 and 3 rad/s2":
        ("kanayama", "push", {**PUSHED, **RAMP}, 90),
    "the same, a PI loop": ("kanayama", "push", {**PUSHED, **PI}, 90),
    "mb through the adapter": ("mb", "push", PUSHED, 90),
    "prox through the adapter, 0.09 mN m, v_u2 = (0.21, 2.6)":
        ("prox", "push", {**PUSHED, **WIDE, "disturbance.std": 3e-5}, 120),
    "kanayama, poses off by 0.5 mm an axis": ("kanayama", "pose", POSES, 90),
    "the same, three tenths of their difference corrected":
        ("kanayama", "pose", {**POSES, "sensor.correction": 0.3}, 110),
    "the same, seven tenths": ("kanayama", "pose", {**POSES, "sensor.correction": 0.7}, 110),
    "kanayama, acceleration limited, poses off by 0.2 mm an axis":
        ("kanayama", "pose", {**QUIET, **RAMP, "sensor.pose_noise": 2e-4}, 110),
    "mb, velocities off by 2 mm/s and 10 mrad/s":
        ("mb", "velocity", {**QUIET, "sensor.velocity_noise": [2e-3, 1e-2]}, 90),
}  # fmt: skip
"""Law, what disturbs, changes of a TurtleBot3, and the samples that an attack takes."""


@dataclass(frozen=True)
class Further:
    """A scenario and law, and the distance from its place [m] that an adversary can cause.

    ``reach`` takes a factor on the scenario's bound of pushes or errors.
    """

    scenario: Scenario
    law: str
    reach: Callable[[float], float]


def burger(*parts):
    """An exact TurtleBot3 with some changes."""
    return preset("turtlebot3-burger", EXACT, QUICK, *parts)


def simulated(*parts):
    """safe-simulation, pushed by 0.3 N m, without guard and change, with some changes."""
    return safe("disturbance.std = 0.1; guard.enabled = false; changes = []", *parts)


def on_base(case):
    """A case of BASES."""
    law, kind, changes, samples = BASES[case]
    scenario = burger(changes)
    size = {
        "push": np.full(2, 3 * scenario.disturbance.std),
        "pose": np.full(2, scenario.sensor.pose_noise),
        "velocity": np.array(scenario.sensor.velocity_noise),
    }[kind]

    def reach(times):
        return sending.farthest(scenario, law, samples, kind, size, times).position

    return Further(scenario, law, reach)


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


def with_losses(times):
    """safe-simulation, which may lose ``times`` poses in a row from any sample on."""
    scenario = simulated(lossy(times))

    def reach(more):
        pushes = [more * push for push in worst_pushes(simulated(), "prox", 200, 0.3)]
        each = [np.roll([*[0] * times, 1], k) for k in range(times + 1)]
        return max(farthest_lost(scenario, pushes, come)[0] for come in each)

    return Further(scenario, "prox", reach)


LINE = changes("""
    reference.kind = line
    reference.speed = 0.2
    disturbance.std = 0.0
    sensor.velocity_noise = [1e-4, 0.0]
    gains.kinematics.k = [4.0, 60.0, 6.0]
    gains.mb.rho = [180.0, 180.0]
""")


def reckoned_for_long(times):
    """mb on a line, dead reckoning over ``times`` samples with a wrong speed; an attack loses more
    poses.
    """
    scenario = simulated(lossy(times), LINE)

    def reach(more):
        lost = round(more * times)
        still = np.zeros((lost + 50, 2))
        off = np.tile(scenario.sensor.velocity_noise, (len(still), 1))
        return farthest_lost(scenario, [still], [*[0] * lost, 1], [off], "mb")[0]

    return Further(scenario, "mb", reach)


def with_jitter(steps, size, *parts):
    """safe-simulation under pushes of ``size`` [N m] with jitter of ``steps`` milliseconds."""
    scenario = simulated({"actuator.jitter": 1e-3 * steps, "disturbance.std": size / 3}, *parts)

    def reach(more):
        return late.farthest_jittered(scenario, "prox", 250, size, steps, more).position

    return Further(scenario, "prox", reach)


def with_delay(steps, size, *parts):
    """safe-simulation under pushes of ``size`` [N m] with a delay of ``steps`` milliseconds that
    the law does not know.
    """
    told = {"actuator.unmodelled_delay": 1e-3 * steps, "disturbance.std": size / 3}
    scenario = simulated(told, *parts)

    def reach(more):
        return late.farthest_held(scenario, "prox", 250, more * size, steps).position

    return Further(scenario, "prox", reach)


GUARDED = changes("guard.enabled = true; disturbance.truncate = 3.0")
ROWS = {
    **{name: partial(on_base, name) for name in BASES},
    "safe-simulation, prox, 0.3 N m, one pose in a row lost": partial(with_losses, 1),
    "the same, two in a row": partial(with_losses, 2),
    "the same, four in a row": partial(with_losses, 4),
    "mb on a line, k = (4, 60, 6), rho = 180, v1 off by 0.1 mm/s, 300 in a row": partial(
        reckoned_for_long, 300
    ),
    "safe-simulation, prox, 0.3 N m, jitter of 2 ms, no guard": partial(with_jitter, 2, 0.3),
    "the same, jitter of 5 ms, half a period": partial(with_jitter, 5, 0.3),
    "safe-simulation, prox, 1.5 N m, an untold delay of 4 ms, the guard on": partial(
        with_delay, 4, 1.5, GUARDED
    ),
    "the same, jitter of 2 ms in its place": partial(with_jitter, 2, 1.5, GUARDED),
    "the same, jitter of 4 ms": partial(with_jitter, 4, 1.5, GUARDED),
}
"""The page's rows."""
