"""Cases of `benchmarks.corridor_further`, with the distance that an adversary causes in each."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial

import numpy as np

from benchmarks.corridor_adversary import TINY, TRIED, farthest_first, led_by, worst_pushes
from benchmarks.corridor_late import farthest_held, farthest_jittered
from tests.corridor.further import (
    GUARDED,
    PUSHED,
    QUIET,
    WIDE,
    burger,
    farthest_lost,
    lossy,
    simulated,
)
from tests.corridor.sending import FIRST, Course, course
from tests.oracle.references import reference_of
from tests.tables import changes
from wmr_ctrl.world.model.evaluate import Floats
from wmr_ctrl.world.scenario import Scenario

PI = changes("""
    base.loop = pi
    base.kp = 10.0
    base.ki = 20.0
    filter.kind = none
""")
RAMP = changes("""
    filter.kind = clip
    base.accel = [0.5, 3.0]
    base.decel = [0.5, 3.0]
    filter.d = [0.01, 0.1]
""")
POSES = {**QUIET, "sensor.pose_noise": 5e-4}
LINE = changes("""
    reference.kind = line
    reference.speed = 0.2
    disturbance.std = 0.0
    sensor.velocity_noise = [1e-4, 0.0]
    gains.kinematics.k = [4.0, 60.0, 6.0]
    gains.mb.rho = [180.0, 180.0]
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


def worst(scenario: Scenario, law: str, samples: int, kind: str, size: Floats) -> list[Floats]:
    """For TRIED of DIRECTIONS: errors (N, 2) of ``kind`` and ``size`` (2) that displace the robot
    most.
    """
    steps = scenario.clock.substeps
    rest = course(scenario, law, samples + FIRST).e[(FIRST + 1) * steps - 1 :: steps]
    answers = []
    for axis in (0, 1):
        error = np.zeros((samples + FIRST, 2))
        error[FIRST, axis] = TINY
        e = course(scenario, law, samples + FIRST, **{kind: error}).e
        answers.append(e[(FIRST + 1) * steps - 1 :: steps] - rest)
    rate = reference_of(scenario.reference)(0.0).v2 if kind == "pose" else 0.0
    return farthest_first(led_by(answers, rate * scenario.clock.control), size)[:TRIED]


def farthest(
    scenario: Scenario, law: str, samples: int, kind: str, size: Floats, times: float = 1.0
) -> Course:
    """Course with the largest distance under the worst errors of ``kind``."""
    each = (
        course(scenario, law, samples, **{kind: times * error})
        for error in worst(scenario, law, samples, kind, size)
    )
    return max(each, key=lambda x: x.position)


def on_base(case: str) -> Further:
    """A case of BASES."""
    law, kind, changes, samples = BASES[case]
    scenario = burger(changes)
    size = {
        "push": np.full(2, 3 * scenario.disturbance.std),
        "pose": np.full(2, scenario.sensor.pose_noise),
        "velocity": np.array(scenario.sensor.velocity_noise),
    }[kind]

    def reach(times: float) -> float:
        return farthest(scenario, law, samples, kind, size, times).position

    return Further(scenario, law, reach)


def with_losses(times: int) -> Further:
    """safe-simulation, which may lose ``times`` poses in a row from any sample on."""
    scenario = simulated(lossy(times))

    def reach(more: float) -> float:
        pushes = [more * push for push in worst_pushes(simulated(), "prox", 200, 0.3)]
        each = [np.roll([*[0] * times, 1], k) for k in range(times + 1)]
        return max(farthest_lost(scenario, pushes, come)[0] for come in each)

    return Further(scenario, "prox", reach)


def reckoned_for_long(times: int) -> Further:
    """mb on a line, dead reckoning over ``times`` samples with a wrong speed; an attack loses more
    poses.
    """
    scenario = simulated(lossy(times), LINE)

    def reach(more: float) -> float:
        lost = round(more * times)
        still = np.zeros((lost + 50, 2))
        off = np.tile(scenario.sensor.velocity_noise, (len(still), 1))
        return farthest_lost(scenario, [still], [*[0] * lost, 1], [off], "mb")[0]

    return Further(scenario, "mb", reach)


def with_jitter(steps: int, size: float, *parts: Mapping[str, object]) -> Further:
    """safe-simulation under pushes of ``size`` [N m] with jitter of ``steps`` milliseconds."""
    scenario = simulated({"actuator.jitter": 1e-3 * steps, "disturbance.std": size / 3}, *parts)

    def reach(more: float) -> float:
        return farthest_jittered(scenario, "prox", 250, size, steps, more).position

    return Further(scenario, "prox", reach)


def with_delay(steps: int, size: float, *parts: Mapping[str, object]) -> Further:
    """safe-simulation under pushes of ``size`` [N m] with a delay of ``steps`` milliseconds that
    the law does not know.
    """
    told = {"actuator.unmodelled_delay": 1e-3 * steps, "disturbance.std": size / 3}
    scenario = simulated(told, *parts)

    def reach(more: float) -> float:
        return farthest_held(scenario, "prox", 250, more * size, steps).position

    return Further(scenario, "prox", reach)


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
