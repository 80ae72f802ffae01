"""Questions about values of a scenario whose unit looks mistaken."""

import math
from collections.abc import Iterator
from itertools import pairwise

from wmr_ctrl.core.fields.section import Section, questions
from wmr_ctrl.core.fields.units import USUAL, meant
from wmr_ctrl.core.fields.unstated import Unstated
from wmr_ctrl.world.references import Waypoints

from .scenario import Scenario, sections
from .sections import Robot

INERTIA = 50.0
"""Usual inertias are m l^2, times or over this at most."""
LONGEST_WAY = 3600.0
"""Time [s] that the way to a goal usually takes at most."""


def unit_questions(scenario: Scenario) -> Iterator[tuple[str, str]]:
    """Yield key and question of each value that is unusual in its unit, first those of sections."""
    for path, part in _parts(scenario):
        yield from questions(part, path)
    yield from _inertia(scenario.robot)
    if isinstance(scenario.reference, Waypoints):
        yield from _way(scenario.reference)


def _parts(scenario: Scenario) -> Iterator[tuple[str, Section]]:
    for name in sections():
        yield name, scenario.model if name == "model" else scenario.table(name)
    yield "reference", scenario.reference
    for i, change in enumerate(scenario.changes, start=1):
        yield f"changes[{i}]", change


def _inertia(robot: Robot) -> Iterator[tuple[str, str]]:
    """Ask about an inertia that does not fit mass and track."""
    if any(isinstance(value, Unstated) for value in (robot.m, robot.I, robot.l)):
        return
    about = robot.m * robot.l**2
    usual = (about / INERTIA, about * INERTIA)
    if not usual[0] <= robot.I <= usual[1]:
        sentence = (
            f"robot.I = {robot.I:g} kg m2 is unusual for robot.m = {robot.m:g} kg and robot.l = "
            f"{robot.l:g} m (usual: about m l^2 = {about:.3g} kg m2). "
        )
        yield "robot.I", (sentence + meant(robot.I, "kg.m2", usual)).strip()


def _way(reference: Waypoints) -> Iterator[tuple[str, str]]:
    """Ask about the points of a path that is very long, or takes very long."""
    length, time = sum(math.dist(a, b) for a, b in pairwise(reference.points)), reference.arrival
    if length > USUAL["m"][1]:
        asked = meant(float(f"{length:.4g}"), "m", USUAL["m"])
        sentence = f"The path of reference.points is {length / 1e3:.3g} km long. {asked}"
        yield "reference.points", sentence
    elif time is not None and time > LONGEST_WAY:
        sentence = (
            f"The desired motion takes {time / 3600:.3g} h for {length:.4g} m. Are its points in "
            "m, and speed, omega_max and a_max in m/s, rad/s and m/s2?"
        )
        yield "reference.speed", sentence
