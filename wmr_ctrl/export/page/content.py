"""Data for the page's script: loops, scenes, numbers, looks."""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from wmr_ctrl.codegen.build import numbers_of, phases_of
from wmr_ctrl.control.filter.stop_numbers import stopping
from wmr_ctrl.control.numbers import fields_of
from wmr_ctrl.control.setup import Setup
from wmr_ctrl.core.fields.section import quantities
from wmr_ctrl.core.fields.units import length
from wmr_ctrl.core.signals import Signal, elements
from wmr_ctrl.report.course import drawn_half_track
from wmr_ctrl.report.scene import BODY, TRACK, WHEEL
from wmr_ctrl.report.style import after_dark, unit_text
from wmr_ctrl.theory.corridor import corridor_course
from wmr_ctrl.version import __version__
from wmr_ctrl.world.scenario import Scenario

from .controls import DELAY, GROUPS, SPANS, Control, controls_of
from .module import PageLoop, PageLoops, Room
from .scenes import (
    PageMember,
    PageScene,
    SettledVariant,
    members_of,
    settled_variants,
    stops,
)

Plain = dict[str, Any]
Row = dict[str, float]
STOPS = 20
"""Speeds for which the way of a stop is computed."""
EVERY = 0.1
"""Time [s] for which a corridor that varies has one width, its largest there."""


@dataclass(frozen=True)
class Content:
    """Compiled loops, their room, the script's data, and the robot's mass [kg]."""

    loops: tuple[PageLoop, ...]
    room: Room
    data: Plain
    mass: float


def content_of(
    scenes: Sequence[PageScene], laws: tuple[str, ...], seed: int, progress: Callable[[float], None]
) -> Content:
    """Settle every variant of every scene for every law.

    ``progress`` is called with the share done.  Raises the errors of `settle` for a scene's own
    variant.
    """
    loops, phases, steps = PageLoops(), 1, 0
    scenery = list[Plain]()
    for number, scene in enumerate(scenes):
        members = members_of(scene.scenario, laws)
        variants = list(settled_variants(scene.scenario, members))
        setups = [setup for item in variants for setup in item.setups.values()]
        phases = max(phases, 1 + len(scene.scenario.changes))
        for count, setup in enumerate(setups):
            loops.of(setup)
            progress((number + count / len(setups)) / len(scenes))
            actuator, base = setup.scenario.actuator, setup.scenario.base
            latest = SPANS[DELAY][1] if stops(setup.scenario) else 0.0
            late = actuator.delay + actuator.unmodelled_delay + max(base.delay, latest)
            steps = max(steps, round(late / setup.scenario.clock.plant))
        scenery.append(_scene(scene, variants, loops, len(scenes) == 1))
        progress(len(scenery) / len(scenes))
    numbers = {item.name: item for loop in loops for item in loop.layout.parameters}
    for scene, plain in zip(scenes, scenery, strict=True):
        plain |= _admitted(scene.scenario, numbers.values())
    known = [item for loop in loops for item in (*loop.layout.columns, *loop.layout.parameters)]
    names = {  # unit and meaning of every element
        name: [unit_text(unit), signal.meaning]
        for signal in known
        for name, unit in zip(signal.elements, signal.units, strict=True)
    }
    # Size of the drawn robot [m], as wide as its wheels are apart.
    scale = drawn_half_track(scenes[0].scenario) / TRACK
    size, wheel = ([scale * part for part in item] for item in (BODY, WHEEL))
    data = {
        "version": __version__,
        "seed": seed,
        "body": {"size": size, "wheel": wheel, "track": scale * TRACK},
        "filtered": scenes[0].scenario.takes_velocity,
        "laws": [_look(member) for member in members],
        "names": names,
        "loops": [
            {
                "name": item.name,
                "columns": elements(item.layout.columns),
                "state": elements(item.layout.state),
                "parameters": elements(item.layout.parameters),
                "findings": item.layout.findings,
                "start": item.start,
            }
            for item in loops
        ],
        "groups": [{"key": g.key, "title": g.title, "hint": g.hint} for g in GROUPS],
        "scenes": scenery,
    }
    mass = scenes[0].scenario.robot.m
    return Content(tuple(loops), Room(phases, steps), data, mass)


def _scene(
    scene: PageScene, variants: list[SettledVariant], loops: PageLoops, whole: bool
) -> Plain:
    scenario, setups = scene.scenario, variants[0].setups
    base = {law: _rows(setup, loops.of(setup))[0] for law, setup in setups.items()}
    ports = [item for setup in setups.values() for item in loops.of(setup).layout.parameters]
    values = {name: value for row in base.values() for name, value in row.items()}
    return {
        "key": scene.key,
        "title": scene.title,
        "text": scene.text,
        "scenario": scenario.name,
        "shown": scene.shown,
        "speed": scene.speed,
        "duration": scenario.clock.duration,
        "start": [*scenario.initial.pose, *scenario.initial.velocity],
        "base": {law: _spelled(row) for law, row in base.items()},
        "tubes": {law: tube for law, setup in setups.items() if (tube := _tube(setup, whole))},
        "variants": [_variant(item, base, loops) for item in variants],
        "controls": [_control(item) for item in controls_of(scenario, ports, values)],
        "obstacles": scenario.obstacles,
        **(_stops(scenario) if stops(scenario) else {}),
    }


def _stops(scenario: Scenario) -> Plain:
    """Distances [m] at which the filter stops, by speed; times after which a brake holds [s]."""
    most = scenario.limits.sides[0][1]
    speeds = [most * part / STOPS for part in range(STOPS + 1)]
    ways = [stopping(scenario, speed).distance for speed in speeds]
    return {
        "stops": {
            "most": most,
            "ways": ways,
            "rest": scenario.filter.rest,
            "delay": scenario.filter.intervals("delay")[0],
        }
    }


def _tube(setup: Setup, whole: bool) -> Plain | None:
    """Certified distances from the path over time, and when they end; None without any.

    With ``whole`` also past the robot's changes: for a story of many runs that would take a minute.
    ``widths`` [m], each for ``every`` seconds, the last one until the end; ``until`` [s].
    """
    if stops(setup.scenario):
        return None
    tube = corridor_course(setup.scenario, setup.name, whole=whole)
    if tube is None or tube.course is None:
        return None
    until = tube.until if tube.run is None else tube.run
    period = setup.scenario.clock.control
    count = max(1, round(EVERY / period))
    row = tube.course[0].tolist()
    widths = [max(row[k : k + count]) for k in range(0, len(row), count)]
    return {
        "widths": widths,
        "every": count * period,
        "shown": length(max(widths)),
        "until": _number(math.inf if until is None else until),
    }


def _admitted(scenario: Scenario, parameters: Iterable[Signal]) -> Plain:
    """Bounds of the scenario's fields by key, and keys with another name in the loop."""
    signals = [item.name for item in parameters]
    own = dict(quantities(type(scenario.reference)))
    aliases = {f"reference.{name}": f"ref_{name}" for name in own if f"ref_{name}" in signals}
    fields = fields_of(scenario, [*signals, "initial.pose", "initial.velocity"])
    fields |= {loop: own[key.partition(".")[2]].bounds for key, loop in aliases.items()}
    plain = {name: asdict(bounds) for name, bounds in fields.items()}
    return {"admitted": plain, "aliases": aliases}


def _control(control: Control) -> Plain:
    numbers = {"span": control.span, "bounds": control.bounds}
    return {
        **asdict(control),
        **{name: [_number(value) for value in pair] for name, pair in numbers.items()},
        "unit": unit_text(control.unit),
    }


def _variant(item: SettledVariant, base: Mapping[str, Row], loops: PageLoops) -> Plain:
    setups = item.setups.items()
    laws = {law: _law(setup, base[law], loops.of(setup)) for law, setup in setups}
    return {**asdict(item.variant), "refusal": item.refusal, "laws": laws}


def _law(setup: Setup, base: Row, loop: PageLoop) -> Plain:
    """A law's loop, first plant steps of its phases, and differences between successive rows."""
    rows = _rows(setup, loop)
    pairs = zip([base, *rows[:-1]], rows, strict=True)
    changed = [
        _spelled({name: value for name, value in new.items() if old.get(name) != value})
        for old, new in pairs
    ]
    phases = [step for step, _ in _phases(setup, loop)]
    return {"loop": int(loop.name[1:]), "phases": phases, "rows": changed, "void": setup.void}


def _rows(setup: Setup, loop: PageLoop) -> list[Row]:
    names = elements(loop.layout.parameters)
    return [dict(zip(names, row, strict=True)) for _, row in _phases(setup, loop)]


def _phases(setup: Setup, loop: PageLoop) -> list[tuple[int, tuple[float, ...]]]:
    parameters = loop.layout.parameters
    return phases_of(setup, parameters, numbers_of(setup, parameters))


def _spelled(row: Row) -> Plain:
    return {name: _number(value) for name, value in row.items()}


def _number(value: float) -> float | str:
    """A number for JSON; infinity becomes a text that JavaScript's Number reads."""
    return value if math.isfinite(value) else "Infinity" if value > 0 else "-Infinity"


def _look(member: PageMember) -> Plain:
    """Name, label, title, colours (on white, on black) and dashes of a robot."""
    chosen = member.look
    dash = [] if isinstance(chosen.dash, str) else list(chosen.dash[1])
    words = {"name": member.name, "law": member.law, "label": chosen.label, "title": member.title}
    return {**words, "colour": chosen.colour, "dark": after_dark(chosen.colour), "dash": dash}
