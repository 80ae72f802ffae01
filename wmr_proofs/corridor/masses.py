"""Corridor of a law for all masses that the guard assumes, cell by cell with ``corridor.cells``.

If no corridor exists, the share of pushes and errors for which one exists is searched.
"""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from copy import copy
from dataclasses import replace
from itertools import product
from typing import TypeAlias

import numpy as np

from wmr_ctrl.control.guard.bounds import mass_range
from wmr_ctrl.control.setup import Setup, settle
from wmr_ctrl.theory.checks.error_coordinates import COMMAND, Floats
from wmr_ctrl.theory.corridor.answer import Corridor
from wmr_ctrl.world.scenario import Change, override

from .certificate import Certifier
from .enclosure import OpenBoxError
from .inputs import Inputs, NoCorridorError, at_first
from .loop import BODY
from .peaks import Tube
from .stated import checked

Body: TypeAlias = "tuple[float | None, float | None]"
"""Mass and inertia."""
MOST_COURSES = 64
"""Most histories of mass and inertia of a whole run with changes."""
SHARES = 12
"""Halvings in the search for the inputs with which a corridor closes."""


def certified(setup: Setup, *, closing: bool = True) -> Corridor:
    """The Corridor of a setup, or why it has none; with cells, for all masses in them.

    ``closing``: if there is none, search for the share of inputs for which there is one.
    """
    until = min((item.t for item in setup.scenario.changes), default=None)
    known = Corridor(
        setup.name,
        until=until,
        mass=setup.scenario.robot.m,
        late=at_first(setup, run=False),
    )
    tubes, linear, cells = list[Tube](), 0.0, list[tuple[Setup, Floats]]()
    here = ""
    try:
        cells = mass_cells(setup)
        for cell, widths in cells:
            here = f"with M = {cell.scenario.robot.m:.3g} kg " if widths.any() else ""
            with refused_open("the undisturbed loop cannot be enclosed"):
                certifier = Certifier(cell)
            inputs = replace(certifier.inputs, body=widths)
            known = with_inputs(known, inputs, first=not tubes)
            linear = max(linear, certifier.linear_position)
            known = replace(known, linear=linear)
            tube = _certified_tube(certifier, inputs, closing)
            tubes.append(checked(certifier, inputs, tube))
    except NoCorridorError as error:
        return replace(
            known, refused=f"{here}{error}", closes=error.closes, near=error.near,
            alone=len(cells) > 1, start=setup.scenario.corridor.start,
            masses=mass_ranges(setup) if here else None,
        )  # fmt: skip
    worst = max(tubes, key=lambda tube: tube.share)
    return replace(
        known,
        position=max(tube.position for tube in tubes),
        position_late=max(tube.position_late for tube in tubes),
        start=setup.scenario.corridor.start,
        heading=max(tube.heading for tube in tubes),
        binding=worst.binding,
        share=worst.share,
        masses=mass_ranges(setup) if cells[0][1].any() else None,
    )


def mass_ranges(setup: Setup) -> tuple[tuple[float, float], ...]:
    """Intervals of mass and inertia that the guard assumes [kg, kg m2]."""
    return tuple(mass_range(setup.guard, i) for i in (0, 1))


@contextmanager
def refused_open(text: str) -> Iterator[None]:
    """Context that raises NoCorridorError with a text if an enclosure is undecided."""
    try:
        yield
    except OpenBoxError as error:
        raise NoCorridorError(f"{text} ({error})") from error


def with_inputs(known: Corridor, inputs: Inputs, *, first: bool) -> Corridor:
    """Add a cell's inputs to the result; NoCorridorError if its push is not the first cell's."""
    push = float(inputs.push[0])
    if not first and push != known.push:
        raise NoCorridorError("an effect's bound changes with the mass: set cells = 0")
    v, w = map(float, inputs.velocity)
    errors = replace(known, pose=inputs.pose, velocity=(v, w), missing=inputs.missing)
    return replace(errors, push=push)


def mass_cells(setup: Setup) -> list[tuple[Setup, Floats]]:
    """The setup by cells of mass and inertia, each with its half-widths [kg, kg m2].

    One cell of width 0 without ``corridor.cells``, else equal parts of the guard's intervals.
    """
    scenario, count = setup.scenario, setup.scenario.corridor.cells
    if not count or not scenario.guard.enabled:
        return [(setup, np.zeros(COMMAND))]
    check_within(setup)
    middles, widths = _cells(setup, count)
    pairs = product(*middles.tolist())
    return [(_with_robots(setup, [(m, I)]), widths) for m, I in pairs]


def _cells(setup: Setup, count: int) -> tuple[Floats, Floats]:
    """Middles (2, count) of equal parts of the guard's intervals, and their half-widths (2)."""
    ranges = np.array(mass_ranges(setup))
    widths = (ranges[:, 1] - ranges[:, 0]) / (2 * count)
    middles = ranges[:, :1] + widths[:, None] * (2 * np.arange(count) + 1)
    return middles, widths * (1 + 1e-12)


def mass_courses(setup: Setup) -> list[tuple[Setup, Floats]]:
    """Sequences of cells for a whole run: at a change of mass or inertia, any cell may follow any
    other.

    Raises NoCorridorError for too many sequences.
    """
    count, changes = setup.scenario.corridor.cells, setup.scenario.changes
    if not count or not setup.scenario.guard.enabled or not changes:
        return mass_cells(setup)
    check_within(setup)
    moves = 1 + sum(map(changes_body, changes))
    total = count ** (2 * moves)
    if total > MOST_COURSES:
        raise NoCorridorError(
            f"corridor.cells = {count} with changes needs {total} mass/inertia histories; the "
            f"limit is {MOST_COURSES}"
        )
    middles, widths = _cells(setup, count)
    courses = product(product(*middles.tolist()), repeat=moves)
    return [(_with_robots(setup, _course(changes, bodies)), widths) for bodies in courses]


def changes_body(change: Change) -> bool:
    """True if a change affects mass or inertia; with cells it is treated as a change of both."""
    return change.m is not None or change.I is not None


def check_within(setup: Setup) -> None:
    """NoCorridorError if the scenario's robot has a mass that the guard does not assume."""
    scenario = setup.scenario
    robots = [scenario.robot, *scenario.changes]
    for name, (low, high) in zip(("m", "I"), mass_ranges(setup), strict=True):
        for size in (getattr(robot, name) for robot in robots):
            if size is not None and not low <= size <= high:
                raise NoCorridorError(
                    f"the robot has {name} = {size:g} at some time, which is not within {low:g} to "
                    f"{high:g}, all that guard and corridor.cells count on: widen the guard's "
                    "masses, or set cells = 0"
                )


def _course(changes: Sequence[Change], bodies: Sequence[Body]) -> list[Body]:
    """Mass and inertia initially and after each change; None if it changes neither."""
    first, *later = bodies
    left = iter(later)
    return [first, *(next(left) if changes_body(item) else (None, None) for item in changes)]


def _with_robots(setup: Setup, robots: Sequence[Body]) -> Setup:
    """The setup with these true masses and inertias, and an unchanged model."""
    scenario = setup.scenario
    (m, I), *later = robots
    changes = tuple(
        replace(item, m=mass, I=inertia)
        for item, (mass, inertia) in zip(scenario.changes, later, strict=False)
    )
    believed = {f"model.{key}": getattr(scenario.believed, key) for key in ("m", "I", "mu")}
    other = override(scenario, {**believed, BODY[0]: m, BODY[1]: I})
    return settle(replace(other, changes=changes or scenario.changes), setup.name)


def _certified_tube(certifier: Certifier, inputs: Inputs, closing: bool) -> Tube:
    try:
        return certifier.tube(inputs)
    except NoCorridorError as error:
        closes, near = _closing(certifier, inputs) if closing else (None, 1.0)
        none = f"; nor is there one with 1/{2**SHARES} of pushes and errors"
        tried = closing and closes is None and inputs.any
        raise NoCorridorError(f"{error}{none * tried}", closes, near) from error


def _closing(certifier: Certifier, inputs: Inputs) -> tuple[float | None, float]:
    """Largest tried shares of inputs and of the start for which there is a corridor.

    First a share of the start is tried with all inputs; if there is none, a share of the inputs
    from the path.
    """
    if not certifier.start.any():
        return _largest(lambda share: (certifier, inputs.scaled(share))), 1.0
    near = _largest(lambda share: (_nearer(certifier, share), inputs))
    if near is not None:
        return 1.0, near
    alone = _nearer(certifier, 0.0)
    return _largest(lambda share: (alone, inputs.scaled(share))), 0.0


def _nearer(certifier: Certifier, share: float) -> Certifier:
    """The certifier for a share of its initial deviation."""
    other = copy(certifier)
    other.gains, other.start = certifier.gains.nearer(share), certifier.start * share
    return other


def _largest(loop: Callable[[float], tuple[Certifier, Inputs]]) -> float | None:
    """Largest of several shares of a loop or its inputs with a corridor that passes its check.

    None if no share has one.
    """
    low, high = 0.0, 1.0
    for _ in range(SHARES):
        middle = (low + high) / 2
        certifier, inputs = loop(middle)
        try:
            checked(certifier, inputs, certifier.tube(inputs))
            low = middle
        except NoCorridorError:
            high = middle
    return low or None
