"""The reader of all tables that users supply: logs, recorded drives, paths.

Cells are separated by the strongest of ``;``, tab, ``,`` and blank in the first row that is not a
comment.  If that is not a comma, a comma is a decimal sign.  The columns' names are in the first
row, or in the last comment above it, each with or without its unit: ``t [ms]``, ``t (ms)``,
``t_ms``.  Columns of a table without names are called 1, 2 and so on.
"""

from __future__ import annotations

import csv
import itertools
import math
import re
from array import array
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

from wmr_ctrl.core.errors import ScenarioError, WmrError, show

from .named_units import fitting, stated

_UNIT = re.compile(r"(.*?)(?:\s+\[([^\[\]]*)\]|\[((?![12]\])[^\[\]]*)\]|\s*\(([^()]*)\))")
_ENDING = re.compile(r"(.+)_(ns|us|ms|s|mm|cm|m|km|deg|rad|rpm|mps|kmh)")
_SPELLINGS = {"mps": "m/s", "kmh": "km/h", "counts": "1", "ticks": "1"}
MOST_NAMED = 12
"""Columns that a message names."""


class Table(NamedTuple):
    """Columns (N,) by our names and in our units, nan for empty cells; the line of each row.

    ``unread``: names of columns that were not read.  ``cut``: number of a last line that ends too
    early, 0 if none does.
    """

    columns: Mapping[str, array[float]]
    lines: array[int]
    unread: tuple[str, ...] = ()
    cut: int = 0


class _Column(NamedTuple):
    place: int
    factor: float
    theirs: str


@dataclass(frozen=True)
class TableReader:
    """Reader of tables: which columns to read, and which error to raise.

    ``known``: unit by our name; ``needed``: our names that must be there; ``columns``: the table's
    name, with or without its unit, by ours; ``unnamed``: our names, in order, for a table of that
    width without names; ``alike``: a pattern of other names, whose first group is our name.
    """

    place: str
    known: Mapping[str, str]
    needed: Sequence[str]
    error: Callable[[str], WmrError] = ScenarioError
    columns: Mapping[str, str] = field(default_factory=dict)
    unnamed: Sequence[str] = ()
    alike: re.Pattern[str] | None = None
    remedy: str = "Rename them."

    def read(self, lines: Iterable[str]) -> Table:
        """The table in some lines of text; raises ``error``."""
        text = iter(lines)
        above, first, count = _begin(text)
        separator = _separator(first)
        rows = self._rows(itertools.chain((first,), text), separator, count - 1)
        line, cells = next(rows, (0, [""]))
        headed = all(_number(cell, separator) is None for cell in cells if cell)
        names = _names(cells, separator) if headed else _names_above(above, len(cells))
        if not headed:
            rows = itertools.chain(((line, cells),), rows)
        if not headed and not (names and self._found(names)):
            plain = len(cells) == len(self.unnamed)
            names = [*self.unnamed] if plain else [str(k + 1) for k in range(len(cells))]
        taken = self._taken(names)
        table = self._filled(rows, taken, len(names), separator)
        return table._replace(unread=_unread(names, taken))

    def scaled(self, columns: Mapping[str, Sequence[float]]) -> Table:
        """The table whose columns are given by their names; raises ``error``."""
        names, values = [*columns], [*columns.values()]
        taken = self._taken(names)
        numbers = {
            ours: array("d", [factor * x for x in values[place]])
            for ours, (place, factor, _) in taken.items()
        }
        return Table(numbers, array("q", range(1, len(values[0]) + 1)), _unread(names, taken))

    def _rows(
        self, lines: Iterable[str], separator: str, before: int
    ) -> Iterator[tuple[int, list[str]]]:
        """Line and cells of each row that is neither empty nor a comment."""
        reader = csv.reader(lines, delimiter=separator, skipinitialspace=True)
        try:
            for count, row in enumerate(reader, 1):
                if reader.line_num != count:
                    raise csv.Error("a quotation mark is not closed in its line")
                cells = [cell.strip() for cell in row]
                if separator == " ":
                    cells = [cell for cell in cells if cell]
                if any(cells) and not cells[0].startswith("#"):
                    yield before + reader.line_num, cells
        except csv.Error as problem:
            at = before + reader.line_num
            raise self.error(f"{self.place}, line {at}: {problem}. Save it as CSV.") from None

    def _taken(self, names: Sequence[str]) -> dict[str, _Column]:
        """Columns to read, by our names; raises ``error`` if a needed column is missing."""
        taken = self._found(names)
        if missing := [name for name in self.needed if name not in taken]:
            said = ", ".join(names[:MOST_NAMED]) or "no names"
            raise self.error(
                f"{self.place}: no column is named {' or '.join(missing)}. There are {said}"
                f"{', ...' if len(names) > MOST_NAMED else ''}. {self.remedy} Names that are read: "
                f"{', '.join(self.known)}."
            )
        return taken

    def _found(self, names: Sequence[str]) -> dict[str, _Column]:
        split = [_split(name) for name in names]
        taken: dict[str, _Column] = {}
        for ours, spec in self.columns.items():
            theirs, unit = _split(spec)
            if ours not in self.known:
                raise self.error(
                    f"columns: {show(ours)} is not read; names are {', '.join(self.known)}."
                )
            found = [k for k, pair in enumerate(split) if spec == names[k] or theirs == pair[0]]
            if len(found) != 1:
                raise self.error(
                    f"{self.place}: {len(found) or 'no'} columns are named {show(theirs)}, which "
                    f"is to be {ours}. There are {', '.join(names[:MOST_NAMED])}."
                )
            taken[ours] = self._column(ours, found[0], theirs, unit or split[found[0]][1])
        used = {item.place for item in taken.values()}
        for k, (name, unit) in enumerate(split):
            ending = _ENDING.fullmatch(name)
            for ours in (name, name.lower(), ending[1].lower() if ending else ""):
                match = self.alike.fullmatch(ours) if self.alike else None
                ours = match[1].lower() if match else ours
                if ours in self.known:
                    break
            if ours not in self.known or ours in self.columns or k in used:
                continue
            if ours in taken:
                raise self.error(f"{self.place}: two columns are named {ours}. Rename one.")
            taken[ours] = self._column(ours, k, name, unit)
        return taken

    def _column(self, ours: str, place: int, name: str, unit: str) -> _Column:
        """A column, with the factor from its unit to ours."""
        wanted, ending = self.known[ours], _ENDING.fullmatch(name)
        said = ending[2] if ending and name != ours else ""
        one, named = (stated(f"1 {_SPELLINGS.get(text, text)}") for text in (unit, said))
        if unit and said and one != named:
            raise self.error(
                f"{self.place}: the name of column {name} says {said}, and its unit {unit}. Say "
                f"which is right by renaming it."
            )
        given = unit or said
        factor = one if unit else named
        if given == "%":
            raise self.error(
                f"{self.place}: column {name} is in per cent, and nothing says of what. Give it in "
                f"{wanted}."
            )
        if given and (isinstance(factor, str) or factor.refused(wanted)):
            raise self.error(
                f"{self.place}: column {name} is in {show(given)}, which does not fit it. Give it "
                f"in {fitting(wanted)}."
            )
        return _Column(place, float(factor) if given else 1.0, name)

    def _filled(
        self,
        rows: Iterable[tuple[int, list[str]]],
        taken: Mapping[str, _Column],
        width: int,
        separator: str,
    ) -> Table:
        """The numbers of all rows; the last one may be cut off."""
        table = Table({name: array("d") for name in taken}, array("q"))
        into = [(table.columns[name], *item) for name, item in taken.items()]
        short = 0
        for line, cells in rows:
            if short or (len(cells) > width and any(cells[width:])):
                raise self.error(
                    f"{self.place}, line {short or line}: it has another number of cells than the "
                    f"{width} columns. Complete the row, or remove it."
                )
            if len(cells) < width:
                short = line
                continue
            for column, at, factor, name in into:
                value = _number(cells[at], separator)
                if value is None:
                    raise self.error(
                        f"{self.place}, line {line}, column {name}: {show(cells[at])} is not a "
                        "number. Leave the cell empty, or remove the row."
                    )
                column.append(value * factor)
            table.lines.append(line)
        return table._replace(cut=short)


def _begin(text: Iterator[str]) -> tuple[str, str, int]:
    """The last comment above the first row, that row, and its line number."""
    above, count = "", 0
    for count, line in enumerate(text, start=1):
        line = line.removeprefix("\ufeff")
        if line.lstrip().startswith("#"):
            above = line.strip().lstrip("# ")
        elif line.strip():
            return above, line, count
    return above, "", count


def _unread(names: Sequence[str], taken: Mapping[str, _Column]) -> tuple[str, ...]:
    read = {item.place for item in taken.values()}
    return tuple(name for k, name in enumerate(names) if k not in read and name)


def _separator(line: str) -> str:
    return next((sign for sign in ";\t, " if sign in line.strip()), ",")


def _number(cell: str, separator: str) -> float | None:
    if not cell:
        return math.nan
    try:
        return float(cell if separator == "," else cell.replace(",", "."))
    except ValueError:
        return None


def _names(cells: Iterable[str], separator: str) -> list[str]:
    """Names of columns; if blanks separate the cells, a unit is joined to the name before it."""
    names: list[str] = []
    for cell in cells:
        if separator == " " and names and cell[0] in "[(":
            names[-1] += f" {cell}"
        else:
            names.append(cell)
    return names


def _names_above(comment: str, width: int) -> list[str]:
    separator = _separator(comment)
    cells = [cell.strip() for cell in comment.split(separator)]
    names = _names((cell for cell in cells if cell or separator != " "), separator)
    return names if len(names) == width else []


def _split(text: str) -> tuple[str, str]:
    """Name and unit of a header's cell."""
    match = _UNIT.fullmatch(text.strip())
    if match is None:
        return text.strip(), ""
    return match[1].strip(), next(part for part in match.groups()[1:] if part is not None).strip()
