"""Corridor of a law over a whole run: along any path, with changes of the robot."""

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from wmr_ctrl.control.setup import Setup
from wmr_ctrl.theory.checks.error_coordinates import Floats
from wmr_ctrl.theory.corridor.answer import Corridor
from wmr_ctrl.world.references.kind import reference

from .along import Along
from .inputs import (
    Inputs,
    NoCorridorError,
    at_first,
    bounded_inputs,
    check_covered,
)
from .instant import RunBounds
from .late_guard import counts_late
from .masses import (
    changes_body,
    mass_courses,
    mass_ranges,
    refused_open,
    with_inputs,
)
from .overlap import ramps
from .passage import Passing
from .stated import checked_run

OPEN = "the undisturbed loop cannot be followed"
BY_START = "; corridor.start alone is too large for it, also without pushes and errors"
LEAST = 8
"""Most halvings of pushes and errors that are tried where all of them have no corridor."""
BEYOND = 1.0
"""Time for which samples are followed after a possible stop [s]."""
EARLY = 0.25
"""Share of the run that is early."""


def certified_run(setup: Setup, *, closing: bool = True) -> Corridor:
    """The Corridor of a setup over its scenario's run; with cells, for all masses in them.

    ``closing``: if there is none, search for the share of inputs for which there is one.
    """
    scenario, cells = setup.scenario, list[tuple[Setup, Floats]]()
    known = Corridor(
        setup.name,
        run=scenario.clock.duration,
        mass=scenario.robot.m,
        late=at_first(setup, run=True),
    )
    result: list[tuple[Along, RunBounds]] = []
    here = ""
    try:
        check_covered(setup)
        if reference(scenario).x.numel():
            raise NoCorridorError("a reference that has a state of its own is not covered")
        if scenario.actuator.jitter > 0 or (setup.takes_velocity and ramps(scenario)):
            name = "base.accel" if setup.takes_velocity else "actuator.jitter"
            raise NoCorridorError(f"{name} is not covered over a whole run: leave it out")
        if counts_late(setup):
            raise NoCorridorError(
                "a guard that counts late commands is not covered over a whole run: leave out what "
                "makes them late, or set guard.enabled = false"
            )
        cells = mass_courses(setup)
        for cell, widths in cells:
            here = f"with M = {cell.scenario.robot.m:.3g} kg " if widths.any() else ""
            inputs = replace(bounded_inputs(cell), body=widths)
            if inputs.missing:
                raise NoCorridorError(
                    "[sensor]: poses that are rare or lost are not covered over a whole run: leave "
                    "out sensor.pose_period and sensor.pose_dropout"
                )
            known = with_inputs(known, inputs, first=not result)
            with np.errstate(over="ignore", invalid="ignore"):  # what is no number is refused
                result.append(_passed(cell, inputs, closing))
    except NoCorridorError as error:
        masses = mass_ranges(setup) if here else None
        return replace(
            known, refused=f"{here}{error}", closes=error.closes, masses=masses,
            alone=len(cells) > 1,
        )  # fmt: skip
    along, passage = max(result, key=lambda item: float(item[1].share.max()))
    worst = int(passage.share.argmax())
    every = [item for _, item in result]
    courses = np.array([[item.position, item.heading] for item in every]).max(axis=0)
    return replace(
        known,
        course=courses,
        position=_most(item.position for item in every),
        position_late=_most(item.position[len(item.position) // 2 :] for item in every),
        linear=_most(item.linear for item in every),
        heading=_most(item.heading for item in every),
        start=scenario.corridor.start,
        binding=along.loop.conditions[passage.binding[worst]].name,
        share=float(passage.share[worst]),
        masses=mass_ranges(setup) if cells[0][1].any() else None,
        anew=any(map(changes_body, scenario.changes)),
    )


def _most(courses: Iterable[Floats]) -> float:
    return max(float(course.max()) for course in courses)


def _passed(setup: Setup, inputs: Inputs, closing: bool) -> tuple[Along, RunBounds]:
    start = np.array(setup.scenario.corridor.start)
    with refused_open(OPEN):
        along = Along(setup)
    passing = Passing(along, inputs, start)
    try:
        bounds = _followed(passing)
    except NoCorridorError as error:
        early = start.any() and passing.tried <= along.memory
        if early and not _passes(along, inputs.scaled(0.0), start, passing.tried):
            raise NoCorridorError(f"{error}{BY_START}") from error
        closes = _closing(passing, start) if closing else None
        none = f"; nor is there one with 1/{2**LEAST} of pushes and errors"
        tried = closing and closes is None and inputs.any
        raise NoCorridorError(f"{error}{none * tried}", closes) from error
    return along, checked_run(passing, bounds)


def _followed(passing: Passing, until: int | None = None) -> RunBounds:
    with refused_open(OPEN):
        return passing.run(until)


def _closing(refused: Passing, start: Floats) -> float | None:
    """The first of the half, quarter, eighth, ... of the inputs for which there is a corridor.

    If the half has none, the others are bisected, on the assumption that smaller inputs always have
    one.  They are tried around the robot's changes, starting there without deviations, which takes
    little time, and around the place at which all of them were refused, unless that was EARLY. A
    share that passes there is propagated over the whole run.  If that is refused twice at a place,
    the shares are tried there.
    """
    along, inputs = refused.along, refused.inputs
    early = refused.tried < EARLY * len(along.states)
    critical = [*([] if early else [refused.tried]), *along.motion.moved]
    best, lost = _least(refused, start, critical, 1), list[int]()
    while best is not None:
        passing = Passing(along, inputs.scaled(0.5**best), start)
        try:
            checked_run(passing, _followed(passing))
        except NoCorridorError:
            near = round(BEYOND / along.setup.scenario.clock.control)
            again = [passing.tried] if any(abs(k - passing.tried) < near for k in lost) else []
            best = _least(refused, start, again, best + 1)
            lost.append(passing.tried)
        else:
            return 0.5**best
    return None


def _least(refused: Passing, start: Floats, places: list[int], halved: int) -> int | None:
    """Fewest halvings, at least ``halved``, with which a flowpipe exists near all ``places``."""
    along, inputs = refused.along, refused.inputs
    for k in places if inputs.any else ():
        most, trial = LEAST + 1, halved
        while halved < most:
            if _passes(along, inputs.scaled(0.5**trial), start, k):
                most = trial
            else:
                halved = trial + 1
            trial = (halved + most) // 2
    return halved if inputs.any and halved <= LEAST else None


def _passes(along: Along, inputs: Inputs, start: Floats, k: int) -> bool:
    """True if a flowpipe exists around a sample."""
    beyond = round(BEYOND / along.setup.scenario.clock.control)
    passing = Passing(along, inputs, start, max(0, k - along.memory))
    try:
        _followed(passing, k + beyond)
    except NoCorridorError:
        return False
    return True
