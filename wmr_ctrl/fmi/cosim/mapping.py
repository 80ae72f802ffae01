"""Maps between our names and units and those of somebody else's FMU, from a TOML file.

A row says ``target = sum of coefficient times source, plus offset``.  Rows of ``outputs`` have our
names on the left, rows of ``inputs`` theirs.  A plain string is a renaming; units are converted::

    [plant]
    step = 0.002                       # their communication step, s
    units = "SI"                       # of variables that state none; left out, each row states it
    [plant.inputs]
    motorR = "torque_right"
    [plant.outputs]
    x = "position.x"
    psi = { terms = { heading = 1.0 }, unit = "deg" }
    w_right = { terms = { wheelR = 1.0 }, unit = "rpm" }
    w_left = { terms = { wheelL = 1.0 }, unit = "rpm" }
    [plant.parameters]
    "robot.m" = "mass"                 # for scenarios that change it
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from operator import itemgetter
from pathlib import Path
from typing import Any

from wmr_ctrl.errors import ArgumentError, UnknownNameError
from wmr_ctrl.fields.files import parse_toml, read_text
from wmr_ctrl.fields.problems import show
from wmr_ctrl.fields.section import REQUIRED, Section, build, quantity
from wmr_ctrl.fields.values import Frozen
from wmr_ctrl.fmi.units import NamedUnit, unit_of

UnitOf = Callable[[str], NamedUnit | str | None]
"""From the name of their variable to its unit: as the FMU defines it, its mere name, or nothing."""
Units = Callable[[str, str, str], NamedUnit]
"""From a name, the key of the row that needs it and a unit that would fit, to the name's unit."""
_BARE = re.compile(r"[A-Za-z0-9_-]+")


def _table(doc: str) -> Any:
    return quantity(Frozen(), kind="mapping", unit="", doc=doc)


@dataclass(frozen=True)
class MapRow:
    """target = sum of coefficient * source + offset, all in the units of their owners."""

    target: str
    terms: tuple[tuple[str, float], ...]
    offset: float = 0.0

    @property
    def plain(self) -> bool:
        """Whether it only renames."""
        return self.offset == 0.0 and len(self.terms) == 1 and self.terms[0][1] == 1.0


class PartMap(Section):
    """The map of one FMU, as read: raw rows, parameters by our key, start values, step."""

    inputs: Mapping[str, object] = _table("row of each of their inputs")
    outputs: Mapping[str, object] = _table("row of each of our quantities")
    parameters: Mapping[str, str] = _table("their name of each of our keys")
    start: Mapping[str, float] = _table("their start values")
    step: float | None = quantity(None, unit="s", doc="their communication step", above=0)
    units: str = quantity(
        "stated", unit="1", options=("stated", "SI"),
        doc="units of variables of which the FMU gives none: stated in their rows, or SI",
    )  # fmt: skip

    @property
    def si(self) -> bool:
        """Whether variables without a unit are in the SI unit of what they are mapped to."""
        return self.units == "SI"


class MapEntry(Section):
    """A row as a table: target = sum of coefficient * source + offset."""

    terms: Mapping[str, float] = quantity(
        REQUIRED, kind="numbers", unit="1", doc="coefficient of each source"
    )
    offset: float = quantity(0.0, unit="1", doc="what is added, in the target's unit")
    unit: str = quantity("", unit="1", doc="unit of their variables")
    coefficient_unit: str = quantity("1", unit="1", doc="unit of the coefficients")


def load_map(path: str | Path) -> dict[str, PartMap]:
    """Read a map file: parts ``plant`` and ``controller``; raises ArgumentError naming the key."""
    raw = parse_toml(read_text(Path(path), "map"), Path(path))
    for part in raw:
        if part not in ("plant", "controller"):
            raise UnknownNameError(f"part of the map {path}", part, ("plant", "controller"))
    return {part: build(PartMap, table, part) for part, table in raw.items()}


def input_rows(
    raw: Mapping[str, object],
    ours: Mapping[str, str],
    theirs: UnitOf,
    part: str,
    *,
    si: bool = False,
) -> list[MapRow]:
    """Rows that give their inputs; ``ours`` and ``theirs``: units of either side's variables.

    ``si``: as in `PartMap`.
    """
    return [
        _row(
            f"{part}.inputs.{name}",
            name,
            entry,
            _Side(theirs, entry, si),
            _ours(ours),
            _first_unit(ours, entry),
        )
        for name, entry in raw.items()
    ]


def output_rows(
    raw: Mapping[str, object],
    ours: Mapping[str, str],
    theirs: UnitOf,
    part: str,
    *,
    si: bool = False,
) -> list[MapRow]:
    """Rows that give our quantities from their outputs."""
    return [
        _row(
            f"{part}.outputs.{name}",
            name,
            entry,
            _ours(ours),
            _Side(theirs, entry, si),
            ours.get(name, "1"),
        )
        for name, entry in raw.items()
    ]


def _first_unit(ours: Mapping[str, str], entry: object) -> str:
    """Unit of the first of our quantities that an entry reads."""
    names = [entry] if isinstance(entry, str) else list(_terms(entry))
    return next((ours[name] for name in names if name in ours), "1")


def _terms(entry: object) -> Mapping[str, object]:
    terms = entry.get("terms") if isinstance(entry, dict) else None
    return terms if isinstance(terms, dict) else {}


def compiled(
    rows: Sequence[MapRow], sources: Sequence[str]
) -> Callable[[Sequence[float]], Sequence[float]]:
    """A function from the values of ``sources`` to those of the rows' targets."""
    place = {name: i for i, name in enumerate(sources)}
    if len(rows) > 1 and all(row.plain for row in rows):
        return itemgetter(*(place[row.terms[0][0]] for row in rows))
    table = [([(place[name], factor) for name, factor in row.terms], row.offset) for row in rows]
    return lambda values: [
        sum(values[i] * factor for i, factor in terms) + offset for terms, offset in table
    ]


def identity(names: Sequence[str]) -> list[MapRow]:
    """Rows of an FMU that has our names and units."""
    return [MapRow(name, ((name, 1.0),)) for name in names]


class _Side:
    """Units of their variables: as the entry states them, else as their FMU declares them."""

    def __init__(self, declared: UnitOf, entry: object, si: bool) -> None:
        self.declared, self.entry, self.si = declared, entry, si
        self.stated = entry.get("unit") if isinstance(entry, dict) else None

    def __call__(self, name: str, key: str, fitting: str) -> NamedUnit:
        unit = self.stated or self.declared(name) or (fitting if self.si else None)
        hint = f"State it in the row, such as: {self._row(key, fitting)}"
        if unit is None:
            part = key.partition(".")[0]
            raise ArgumentError(
                f"{key}: the FMU gives no unit for {name}. {hint}; or, where all of its variables "
                f'without a unit are in SI units, write units = "SI" in [{part}].'
            )
        if isinstance(unit, NamedUnit):
            return unit
        try:
            return unit_of(unit)
        except ArgumentError as error:
            raise ArgumentError(
                f"{key}: {name} has the unit {unit!r}, which the FMU does not define, and {error} "
                f"{hint}."
            ) from error

    def _row(self, key: str, fitting: str) -> str:
        """The row of a map with its unit stated, as TOML."""
        target = key.split(".", 2)[-1]
        terms = {self.entry: 1.0} if isinstance(self.entry, str) else _terms(self.entry)
        listed = ", ".join(f"{_key(term)} = {share!r}" for term, share in terms.items())
        return f'{_key(target)} = {{ terms = {{ {listed} }}, unit = "{fitting}" }}'


def _key(name: str) -> str:
    """A key as TOML spells it."""
    return name if _BARE.fullmatch(name) else json.dumps(name)


def _ours(units: Mapping[str, str]) -> Units:
    def unit(name: str, key: str, _fitting: str) -> NamedUnit:
        if name not in units:
            raise UnknownNameError(f"quantity of ours (in {key})", name, units)
        return unit_of(units[name])

    return unit


def _row(
    key: str, target: str, entry: object, unit_of_target: Units, unit_of_source: Units, near: str
) -> MapRow:
    """One row in the owners' units: whatever has an offset to SI is converted by way of SI."""
    terms, offset, factor_unit = _entry(key, entry)
    wanted = unit_of_target(target, key, near)
    shares, start = [], -wanted.offset
    for name, factor in terms.items():
        given = unit_of_source(name, key, near)
        _check(key, wanted, given, factor_unit, name)
        share = factor * factor_unit.factor
        shares.append((name, share * given.factor / wanted.factor))
        start += share * given.offset
    return MapRow(target, tuple(shares), offset + start / wanted.factor)


def _entry(key: str, entry: object) -> tuple[Mapping[str, float], float, NamedUnit]:
    """Terms, offset (in the target's unit) and the coefficients' unit."""
    if isinstance(entry, str):
        return {entry: 1.0}, 0.0, unit_of("1")
    if not isinstance(entry, Mapping):
        raise ArgumentError(f"{key} = {show(entry)} must be a name, or a table with terms.")
    row = build(MapEntry, entry, key)
    return row.terms, row.offset, unit_of(row.coefficient_unit)


def _check(key: str, wanted: NamedUnit, given: NamedUnit, factor: NamedUnit, name: str) -> None:
    """The source's kind times the coefficient's must be the target's."""
    keys = {*given.exponents, *factor.exponents}
    product = {k: given.exponents.get(k, 0) + factor.exponents.get(k, 0) for k in keys}
    if not NamedUnit("", 1.0, {k: v for k, v in product.items() if v}).fits(wanted):
        unit = "" if factor.name == "1" else f" with a coefficient in {factor.name}"
        raise ArgumentError(
            f"{key}: {name} in {given.name} does not give {wanted.name}{unit}. Give the "
            "coefficient's unit as coefficient_unit, or map another variable."
        )
