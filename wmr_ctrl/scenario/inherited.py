"""What a sparse file of a scenario does not state of its robot, and so takes from elsewhere."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

from wmr_ctrl.fields.files import read_text
from wmr_ctrl.fields.section import quantities
from wmr_ctrl.scenario.scenario import Scenario, sections
from wmr_ctrl.scenario.toml_io import is_path, parse

OF_A_ROBOT = (
    *("robot.m", "robot.I", "robot.mu", "robot.r", "robot.l", "limits.v_u1"),
    *("initial.pose", "disturbance.std"),
)
"""Fields that one robot does not share with another."""


@dataclass(frozen=True, slots=True)
class InheritedValue:
    """A field that no file of the user states: key, value in effect, unit, meaning."""

    key: str
    value: object
    unit: str
    doc: str


def inherited(
    scenario: Scenario, source: str, overridden: Iterable[str] = ()
) -> tuple[InheritedValue, ...]:
    """Fields that describe the robot and that neither the file ``source`` nor overrides state.

    Files that it extends count as stating, presets do not.  Empty for a preset: it is whole.
    """
    if not is_path(source):
        return ()
    stated = {key.partition("[")[0] for key in overridden} | _stated(Path(source))
    values = []
    for key in OF_A_ROBOT:
        table, _, name = key.partition(".")
        if key not in stated:
            what = dict(quantities(sections()[table]))[name]
            value = getattr(scenario.table(table), name)
            values.append(InheritedValue(key, value, what.unit, what.doc))
    return tuple(values)


def _stated(file: Path) -> set[str]:
    """Keys of a file and of the files that it extends; it has been loaded before."""
    raw = parse(read_text(file, "scenario"), file)
    keys = {
        f"{table}.{name}"
        for table, part in raw.items()
        if isinstance(part, Mapping)
        for name in part
    }
    base = raw.get("extends")
    return keys | _stated(file.parent / base) if isinstance(base, str) and is_path(base) else keys
