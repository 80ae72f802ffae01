"""Keys that a scenario must state, and values derived for omitted ones."""

import dataclasses
from collections.abc import Iterator, Mapping
from operator import attrgetter
from typing import TYPE_CHECKING

from wmr_ctrl.core.errors import WmrError
from wmr_ctrl.core.fields.section import Section, quantities
from wmr_ctrl.core.fields.unstated import Unknown, Unstated, derived
from wmr_ctrl.world.effect import EffectRole
from wmr_ctrl.world.references import REFERENCES
from wmr_ctrl.world.references.kind import start_of
from wmr_ctrl.world.registry import EFFECTS
from wmr_ctrl.world.speed_loops import SPEED_LOOP

if TYPE_CHECKING:
    from .scenario import Scenario

KIND = "reference.kind"
LIMITS = "limits.v_u1"


def missing_keys(scenario: "Scenario") -> tuple[str, ...]:
    """Keys that the scenario needs and does not state, in the order of its tables."""
    needed = [*needed_of_robot(scenario), LIMITS]
    keys = [key for key in needed if isinstance(attrgetter(key)(scenario), Unknown)]
    return (*keys, *(() if scenario.reference else (KIND,)))


def unknown_keys(scenario: "Scenario") -> tuple[str, ...]:
    """Unstated keys of [robot]; nothing in the loop depends on them."""
    values = vars(scenario.robot).items()
    return tuple(f"robot.{name}" for name, value in values if isinstance(value, Unknown))


def guessed_keys(scenario: "Scenario") -> tuple[str, ...]:
    """Unstated keys of the base's own speed loop on which the motion depends."""
    if not scenario.takes_velocity:
        return ()
    base = vars(scenario.base)
    needed = {"first-order": ("tau",), "second-order": ("frequency", "damping"), "pi": ("kp", "ki")}
    names = (name for loop in dict.fromkeys(scenario.base.loop) for name in needed[loop])
    return tuple(f"base.{name}" for name in names if isinstance(base[name], Unstated))


def missing_text(keys: tuple[str, ...], known: Mapping[str, type[Section]]) -> str:
    """All missing keys in one sentence, each with unit and meaning."""
    words = []
    for key in keys:
        table, _, name = key.partition(".")
        if key == KIND:
            words.append(f"{KIND}: kind of the desired motion ({', '.join(REFERENCES)})")
        else:
            what = dict(quantities(known[table]))[name]
            words.append(f"{key} [{what.unit}]: {what.doc}")
    head, them = ("These keys are", "them") if len(keys) > 1 else ("A key is", "it")
    return (
        f"{head} missing: {'; '.join(words)}. Nobody can know {them} for you: state {them}, or "
        "extend a preset or file that does."
    )


def needed_of_robot(scenario: "Scenario") -> list[str]:
    """Keys of [robot] that the loop depends on with any law.

    A base that takes torques depends on all of them.  One that takes velocities follows its command
    for any mass, unless its loop is a PI loop or an effect exerts or limits a force.  It also
    depends on the keys that the graphs of sensors and commands read.
    """
    unknown = list(unknown_keys(scenario))
    if not unknown or not scenario.takes_velocity:
        return unknown
    apart = None if "pi" in scenario.base.loop else SPEED_LOOP
    others = [item for item in EFFECTS if item.active(scenario) and item is not apart]
    limited = scenario.actuator.tau_max < float("inf") or scenario.actuator.traction
    if limited or any(item.role in FORCING for item in others):
        return unknown
    read = set(scenario.filter.reads)
    for effect in others:
        read |= {port.signal.name for port in effect.build(scenario).params}
    return [key for key in unknown if key in read]


FORCING = (EffectRole.DISTURBANCE, EffectRole.DRIVE, EffectRole.LOOP)


def following(scenario: "Scenario") -> Iterator[tuple[str, Section]]:
    """The tables with omitted values, which are derived from other tables."""
    robot, clock, initial = scenario.robot, scenario.clock, scenario.initial
    room = (0.05, scenario.limits.v_u1[0]) if isinstance(robot.l, Unknown) else (0.2, robot.l)
    yield from _replaced(
        "metrics", scenario.metrics, _shares(scenario.metrics, {"tolerance": room})
    )
    sizes = {"height": (1.2, robot.r), "caster": (1.2, robot.l), "wheel_width": (0.4, robot.r),
             "wheel_mass": (0.03, robot.m)}  # fmt: skip
    yield from _replaced("body", scenario.body, _shares(scenario.body, sizes))
    gains = {"kp": (3.0, robot.m), "ki": (6.0, robot.m)}
    yield from _replaced("base", scenario.base, _shares(scenario.base, gains))
    accel = tuple(map(min, scenario.base.accel, scenario.base.decel))
    path, given = scenario.reference, vars(scenario.reference)
    sized = path.sized(scenario.limits.v_u1, (accel[0], accel[1])).items()
    left = {name: derived(value) for name, value in sized if isinstance(given[name], Unstated)}
    yield from _replaced("reference", path, left)
    if isinstance(clock.duration, Unstated) and scenario.reference.arrival is not None:
        lasting = {"duration": clock.beyond(scenario.reference.arrival)}
        yield from _replaced("clock", clock, lasting)
    start: dict[str, object] = {}
    if isinstance(initial.pose, Unstated) or isinstance(initial.velocity, Unstated):
        try:
            pose, velocity = start_of(scenario)
        except WmrError:
            return  # said where the reference is checked
        if isinstance(initial.pose, Unstated):
            start["pose"] = derived(pose)
        if isinstance(initial.velocity, Unstated):
            start["velocity"] = derived((0.0, 0.0) if _starts_at_rest(scenario) else velocity)
    yield from _replaced("initial", initial, start)


def _starts_at_rest(scenario: "Scenario") -> bool:
    """True with a guard and late velocity sensors, which assume rest before the start."""
    if not scenario.guard.enabled:
        return False
    bounds = (item.bounded(scenario) for item in EFFECTS.present(scenario))
    return any(any(item.age) or any(item.window) for item in bounds if item is not None)


def _shares(section: Section, shares: Mapping[str, tuple[float, float]]) -> dict[str, object]:
    """Omitted fields of a section, each as a share of a size or of its placeholder."""
    values = vars(section)
    return {
        name: derived(share * size)
        for name, (share, size) in shares.items()
        if isinstance(values[name], Unstated)
    }


def _replaced(
    key: str, section: Section, values: Mapping[str, object]
) -> Iterator[tuple[str, Section]]:
    if any(vars(section)[name] != value for name, value in values.items()):
        yield key, dataclasses.replace(section, **values)  # type: ignore[type-var]
