"""Checks between the sections of a scenario; those within one section stand beside it."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from wmr_ctrl.errors import ScenarioError
from wmr_ctrl.fields.problems import show
from wmr_ctrl.fields.section import Section, quantities
from wmr_ctrl.fields.values import as_list, check_multiple
from wmr_ctrl.scenario.change import Change
from wmr_ctrl.world.references import REFERENCES
from wmr_ctrl.world.registry import EFFECTS

if TYPE_CHECKING:
    from wmr_ctrl.scenario.scenario import Scenario

ROUNDING = 1e-9
"""Share by which a difference of two times may miss a third."""


def check_types(scenario: Scenario) -> None:
    """Raise ScenarioError if a part of the scenario is not of its own class."""
    for name in ("name", "title"):
        if not isinstance(getattr(scenario, name), str):
            raise ScenarioError(f"{name} = {show(getattr(scenario, name))} must be text in quotes.")
    if REFERENCES.of(scenario.reference) is None:
        raise ScenarioError(f"reference must be one of the kinds {', '.join(REFERENCES)}.")
    if not isinstance(scenario.effects, Mapping):
        raise ScenarioError(f"effects = {show(scenario.effects)} must map tables to sections.")
    for key, part in scenario.effects.items():
        if type(part) is not EFFECTS.sections().get(key):
            raise ScenarioError(f"{key} = {show(part)} is not the section of an effect.")
    if as_list(scenario.changes) is None:
        raise ScenarioError(f"changes = {show(scenario.changes)} must be an array of changes.")
    for field in dataclasses.fields(scenario):
        wanted: Any = field.default_factory
        value = getattr(scenario, field.name)
        section = isinstance(wanted, type) and issubclass(wanted, Section)
        if section and field.name != "reference" and type(value) is not wanted:
            raise ScenarioError(f"{field.name} = {show(value)} must be a {wanted.__name__}.")


def relate(scenario: Scenario) -> None:
    """Check changes against the run's end, and effects against the rest of the scenario."""
    _changes(scenario.changes, scenario.clock.duration)
    _multiples(scenario)
    clock = scenario.clock
    for effect in EFFECTS:
        effect.relate(scenario)
    low, high = scenario.guard.delay or (0.0, 0.0)
    if high - low > clock.control * (1 + ROUNDING):
        raise ScenarioError(
            f"guard.delay = [{low!r}, {high!r}] s may not vary by more than clock.control = "
            f"{clock.control!r} s: a command could take over after the next one. Narrow it, or "
            "lengthen clock.control."
        )
    split = scenario.metrics.split
    if split is not None and not split < clock.duration:
        raise ScenarioError(
            f"metrics.split = {split!r} s must be below clock.duration = {clock.duration!r} s: it "
            "splits the run in two. Leave it out to split at half the duration."
        )


def _multiples(scenario: Scenario) -> None:
    """Times that are a multiple of another time are one."""
    for part in dict.fromkeys(effect.section.KEY for effect in EFFECTS):
        section = scenario.table(part)
        for name, what in quantities(type(section)):
            if what.multiple_of:
                key, other = f"{part}.{name}", what.multiple_of
                (value,), (unit,) = scenario.value(key), scenario.value(other)
                check_multiple(key, value, other, unit, what.most)


def _changes(changes: tuple[Change, ...], duration: float) -> None:
    before = -1.0
    for i, change in enumerate(changes, start=1):
        if not isinstance(change, Change):
            raise ScenarioError(f"changes[{i}] must be a Change, or a table [[changes]] in TOML.")
        if change.m is None and change.I is None and change.mu is None:
            raise ScenarioError(f"changes[{i}] changes nothing: give it a new m, I or mu.")
        if change.t <= before:
            raise ScenarioError(
                f"changes[{i}].t = {change.t!r} s must be later than changes[{i - 1}].t = "
                f"{before!r} s: changes stand in the order of time. Sort or merge them."
            )
        if change.t >= duration:
            raise ScenarioError(
                f"changes[{i}].t = {change.t!r} s must be before the run's end, clock.duration = "
                f"{duration!r} s. Make the run longer or remove the change."
            )
        before = change.t
