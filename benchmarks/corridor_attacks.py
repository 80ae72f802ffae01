"""Attacks of the corridor's table that no test repeats: whole runs, misled poses, other starts."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from benchmarks.corridor_adversary import (
    DIRECTIONS,
    STRIDE,
    TINY,
    TRIED,
    WINDOW,
    Attacked,
    Excursion,
    attack,
    farthest_first,
    worst_errors,
)
from wmr_ctrl.world.model.evaluate import Floats
from wmr_ctrl.world.scenario import Scenario


@lru_cache(maxsize=4)
def worst_on_the_way(scenario: Scenario, law: str, end: int) -> list[Floats]:
    """For each of DIRECTIONS: signs (end, 2) of pushes that displace the robot most at sample
    ``end``.

    The worst of all comes first.  Any path is possible, and the robot changes as its scenario says.
    """
    loop = Attacked(scenario, law, np.zeros((end, 2)), changing=True)
    places = np.arange(end - 1, max(end - WINDOW, 0), -STRIDE)[::-1]
    answers, done = np.zeros((2, len(places), 3)), 0
    for k, place in enumerate(places):
        done = loop.goes_on(done, place)
        for wheel in (0, 1):
            pushed = loop.branched()
            pushed.noise[place, wheel] = TINY
            pushed.goes_on(place, end)
            answers[wheel, k] = pushed.errors[-1]
    loop.goes_on(done, end)
    answers -= loop.errors[-1]
    every = []
    for ahead, left in DIRECTIONS:
        led = ahead * answers[..., 0] + left * answers[..., 1]
        courses = [np.interp(np.arange(end), places, row) for row in led]
        every.append(np.stack(courses, axis=1))
    return farthest_first(every)


def farthest_on_the_way(scenario: Scenario, law: str, end: int, size: float) -> Excursion:
    """Largest excursion under the pushes of `worst_on_the_way`, times ``size``."""
    pushes = (size * signs for signs in worst_on_the_way(scenario, law, end)[:TRIED])
    each = (attack(scenario, law, push, changing=True) for push in pushes)
    return max(each, key=lambda x: x.position)


def farthest_misled(
    scenario: Scenario, law: str, samples: int, kind: str, times: float = 1.0
) -> Excursion:
    """Largest excursion under errors of one ``kind``, of the scenario's size, without pushes."""
    sensor = scenario.sensor
    size = {"pose": (sensor.pose_noise,) * 2, "velocity": sensor.velocity_noise}[kind]
    push, errors = np.zeros((samples, 2)), worst_errors(scenario, law, samples, kind, size)
    each = (attack(scenario, law, push, **{kind: times * error}) for error in errors)
    return max(each, key=lambda x: x.position)


def farthest_displaced(scenario: Scenario, law: str, samples: int, times: float = 1.0) -> Excursion:
    """Largest excursion from a corner of the scenario's box of starts, without pushes."""
    quiet, size = np.zeros((samples, 2)), times * np.array(scenario.corridor.start)
    corners = (size * (1 - 2 * np.array(corner)) for corner in np.ndindex(2, 2, 2))
    each = (attack(scenario, law, quiet, jump=corner, at=2) for corner in corners)
    return max(each, key=lambda x: x.position)
