"""Cleaning of single values: a field's type, size and range, and the error if one does not fit.

It also has the sizes beyond which input is refused before it is counted or unpacked.
"""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partialmethod
from itertools import combinations, islice
from numbers import Real
from typing import Any, TypeAlias, TypeVar, cast

from wmr_ctrl.core.errors import ScenarioError, choices, show

from .named_units import Stated, fitting, stated
from .units import USUAL, is_usual, meant, written
from .unstated import Unstated

SEED_END = 2**63
"""Seeds are whole numbers from 0 up, below this."""
MOST_SEEDS = 10_000_000
"""Runs that one call may be asked for."""
MOST_JOBS = 4096
"""Threads or processes that one call may be asked for."""
MOST_UNPACKED, RATIO = 200_000_000, 100
"""Bytes that a packed file may hold unpacked, or so many times its own size if that is more."""


def may_unpack(packed: int, unpacked: int) -> bool:
    """True if ``packed`` bytes may be unpacked to ``unpacked`` bytes."""
    return unpacked <= max(MOST_UNPACKED, RATIO * packed)


LARGEST = 1e12
"""No finite quantity of a scenario may be larger in size: it would be a slip of units."""
LONGEST = 1_000_000
"""Elements of an array; a path has some thousand points."""
V = TypeVar("V")
Pair: TypeAlias = tuple[float, float]


class Frozen(Mapping[str, V]):
    """Read-only mapping from names to hashable values; it can be hashed and pickled."""

    __slots__ = ("_items",)

    def __init__(self, items: Mapping[str, V] | Iterable[tuple[str, V]] = ()) -> None:
        self._items = dict(items)

    def __getitem__(self, name: str) -> V:
        return self._items[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._items)

    def __len__(self) -> int:
        return len(self._items)

    def __hash__(self) -> int:
        return hash(frozenset(self._items.items()))

    def __repr__(self) -> str:
        return f"Frozen({self._items!r})"


@dataclass(frozen=True)
class Range:
    """Range of every element of a quantity; ``None`` means no bound on that side."""

    above: float | None = None
    minimum: float | None = None
    below: float | None = None
    maximum: float | None = None
    infinite: bool = False

    def broken(self, value: float) -> str:
        """Return the rule that ``value`` breaks, such as ``above 0``, or an empty string."""
        if math.isnan(value) or (math.isinf(value) and not self.infinite):
            return "a finite number"
        if not math.isinf(value) and abs(value) > max(LARGEST, self.below or 0.0):
            return f"at most {LARGEST:g} in size"
        if self.above is not None and not value > self.above:
            return f"above {self.above:g}"
        if self.minimum is not None and not value >= self.minimum:
            return f"at least {self.minimum:g}"
        if self.below is not None and not value < self.below:
            return f"below {self.below:g}"
        if self.maximum is not None and not value <= self.maximum:
            return f"at most {self.maximum:g}"
        return ""


@dataclass(frozen=True)
class Quantity:
    """Declaration of a field: default, unit, meaning, bounds, shape.

    ``size``: number of elements of a vector, 0 for a scalar.  ``options``: texts that a text field
    accepts (any, if empty).  ``usual``: range of sizes outside which `check` asks whether the unit
    is meant (None: that of the unit).  ``multiple_of``, ``most``, ``orientation``, ``alike`` and
    ``by_axis`` as in `quantity`.
    """

    default: Any
    unit: str
    doc: str
    bounds: Range
    kind: str
    size: int = 0
    options: tuple[str, ...] = ()
    usual: Pair | None = None
    multiple_of: str = ""
    most: int = 0
    orientation: int = 0
    alike: bool = False
    by_axis: bool = False

    def clean(self, value: object, path: str) -> Any:
        """Return ``value`` in the field's own type, or raise ScenarioError naming ``path``."""
        if isinstance(value, Unstated):
            return value
        if self.kind == "optional" and (
            value is None or (isinstance(value, str) and value == "none")
        ):
            return None
        rows = as_list(value) if self.by_axis else None
        if rows and any(as_list(row) is not None for row in rows):
            return self._apart(rows, path)
        if self.size:
            return self._vector(value, path)
        return getattr(self, "_" + self.kind)(value, path)

    def _apart(self, rows: list[object], path: str) -> tuple[object, ...]:
        """The values of v and of omega."""
        if len(rows) != 2:
            raise self.refuse(rows, path, "one for both axes, or two, of v and of omega")
        return tuple(self._vector(row, f"{path}[{i}]") for i, row in enumerate(rows, start=1))

    def refuse(self, value: object, path: str, rule: str) -> ScenarioError:
        """Build the error: path and value, rule, meaning of the field, its default."""
        plain = isinstance(self.default, bool | float | int | str)
        has_default = plain and not isinstance(self.default, Unstated)
        remedy = f"; the default is {show(self.default)}" if has_default else ""
        unit = f" [{self.unit}]" if self.unit else ""
        return ScenarioError(f"{path} = {show(value)} must be {rule}: {self.doc}{unit}{remedy}.")

    def questions(self, value: object, path: str) -> Iterator[str]:
        """Ask about the unit of every number of a clean value that is unusual in it."""
        if self.kind not in ("number", "integer", "optional") or value is None:
            return
        numbers = value if isinstance(value, tuple) else (value,)
        for i, number in enumerate(numbers):
            if isinstance(number, tuple):
                yield from self.questions(number, f"{path}[{i + 1}]")
                continue
            unit, usual = self._measure(i)
            if usual is not None and not is_usual(number, usual):
                place = f"{path}[{i + 1}]" if self.size else path
                here = f" {unit}" if unit != "1" else ""
                asked = meant(number, unit, usual) or f"Is it meant in {unit}?"
                yield (
                    f"{place} = {number:g}{here} is unusual ({self.doc}; usual: {written(usual)}"
                    f"{here}). {asked}"
                )

    def _measure(self, index: int) -> tuple[str, Pair | None]:
        """Unit of an element, and its usual range of sizes."""
        units = [unit.strip() for unit in self.unit.split(",")]
        unit = units[index] if len(units) > 1 else units[0]
        return unit, self.usual or USUAL.get(unit)

    def _number(self, value: object, path: str, index: int = 0) -> float:
        """A number in the unit of element ``index``; a text must name a unit of that kind."""
        if isinstance(value, str):
            value = stated(value)
        if isinstance(value, Stated):
            if wrong := value.refused(self._measure(index)[0]):
                raise self.refuse(value.text, path, wrong)
            value = float(value)
        usual = type(value) in (float, int)  # to ask for Real takes five times as long
        if not usual and (isinstance(value, bool) or not isinstance(value, Real)):
            raise self.refuse(value, path, self._as_number(value, index))
        try:
            number = float(cast("Real", value))
        except OverflowError:
            number = 1e300  # an integer too long for a double: refused as too large
        rule = self.bounds.broken(number)
        if rule:
            raise self.refuse(value, path, rule)
        return number

    def _as_number(self, value: object, index: int) -> str:
        unit = self._measure(index)[0]
        if not isinstance(value, str) or not unit:
            return "a number"
        return f'a number, or one with its unit ({fitting(unit)}) in quotes, such as "1 {unit}"'

    _optional = _number

    def _integer(self, value: object, path: str) -> int:
        number = self._number(value, path)
        if not number.is_integer():
            raise self.refuse(value, path, "a whole number")
        return value if isinstance(value, int) else int(number)

    def _flag(self, value: object, path: str) -> bool:
        if not isinstance(value, bool):
            raise self.refuse(value, path, "true or false")
        return value

    def _text(self, value: object, path: str) -> str:
        if isinstance(value, Stated):
            value = value.text
        if not isinstance(value, str):
            raise self.refuse(value, path, "text in quotes")
        if self.options and value not in self.options:
            raise ScenarioError(
                f"{path} = {show(value)} is not known ({self.doc}); {choices(value, self.options)}."
            )
        return value

    def _listed(self, value: object, path: str, kind: type) -> tuple[object, ...]:
        """One or more values of that kind, or the default; a single value counts as a list."""
        items = [value] if isinstance(value, kind) else as_list(value)
        right = items and all(isinstance(item, kind) for item in items)
        if items is None or not (right or tuple(items) == self.default):
            words = {str: "texts in quotes", bool: "flags, such as [false, true]"}[kind]
            raise self.refuse(value, path, f"a list of {words}")
        return tuple(items)

    _texts, _flags = partialmethod(_listed, kind=str), partialmethod(_listed, kind=bool)

    def _vector(self, value: object, path: str) -> tuple[Any, ...]:
        items = as_list(value)
        if items is None and self.alike:
            return (self._element(value, path),) * self.size
        if items is None or len(items) != self.size:
            example = list(self.default or range(1, self.size + 1))
            what = f"{self.size} {'texts' if self.kind == 'text' else 'numbers'}"
            rule = (
                f"{'one for both, or ' * self.alike}an array of {what}, such as {show(example)}"
                f"{', or two such, of v and of omega' * self.by_axis}"
            )
            raise self.refuse(value, path, rule)
        return tuple(self._element(item, f"{path}[{i + 1}]", i) for i, item in enumerate(items))

    def _element(self, value: object, path: str, index: int = 0) -> float | str:
        return self._text(value, path) if self.kind == "text" else self._number(value, path, index)

    def _points(self, value: object, path: str) -> tuple[Pair, ...]:
        rows = as_list(value)
        if rows is None:
            raise self.refuse(value, path, "an array of [x, y] pairs")
        return tuple(self._point(row, f"{path}[{i}]") for i, row in enumerate(rows, start=1))

    def _point(self, row: object, path: str) -> Pair:
        pair = as_list(row)
        if pair is None or len(pair) != 2:
            raise self.refuse(row, path, "a pair [x, y]")
        return self._number(pair[0], f"{path}[1]"), self._number(pair[1], f"{path}[2]")

    def _shapes(self, value: object, path: str) -> tuple[tuple[object, ...], ...]:
        """Circles [x, y, r] and polygons [[x, y], [x, y], [x, y], ...]."""
        shapes = as_list(value)
        if shapes is None:
            raise self.refuse(value, path, "an array of circles [x, y, r] and polygons")
        return tuple(self._shape(item, f"{path}[{i}]") for i, item in enumerate(shapes, start=1))

    def _shape(self, value: object, path: str) -> tuple[object, ...]:
        parts = as_list(value)
        if parts is None or len(parts) < 3:
            rule = "a circle [x, y, r] or a polygon of at least three corners [x, y]"
            raise self.refuse(value, path, rule)
        if as_list(parts[0]) is not None:
            corners = self._points(parts, path)
            if sides := _crossing(corners):
                first, second = sides
                rule = (
                    f"a polygon whose sides do not cross, as those after corners {first} and "
                    f"{second} do: list its corners in order, or write several polygons"
                )
                raise self.refuse(value, path, rule)
            return corners
        circle = tuple(self._number(item, f"{path}[{i}]") for i, item in enumerate(parts, start=1))
        if len(circle) != 3 or circle[2] < 0:
            raise self.refuse(value, path, "a circle [x, y, r] with r >= 0")
        return circle

    def _mapping(self, value: object, path: str) -> Mapping[str, object]:
        if not isinstance(value, Mapping):
            raise self.refuse(value, path, f"a table, written as [{path}]")
        return Frozen(value)

    def _numbers(self, value: object, path: str) -> Mapping[str, float]:
        table = self._mapping(value, path)
        return Frozen({name: self._number(item, f"{path}.{name}") for name, item in table.items()})


def _crossing(corners: Sequence[Pair]) -> tuple[int, int] | None:
    """Numbers, from 1, of two corners whose sides cross in a polygon; None without any."""

    def turn(a: Pair, b: Pair, c: Pair) -> float:
        return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])

    sides = list(enumerate(zip(corners, (*corners[1:], corners[0]), strict=True), start=1))
    for (i, (a, b)), (k, (c, d)) in combinations(sides, 2):
        if turn(a, b, c) * turn(a, b, d) < 0 and turn(c, d, a) * turn(c, d, b) < 0:
            return i, k
    return None


def as_list(value: object) -> list[object] | None:
    """Return an array-like value (list, tuple, NumPy array) as a list; ``None`` for others.

    Values with more than `LONGEST` elements are refused, too.
    """
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, Sequence) and not isinstance(value, (str, bytes)):
        items = list(islice(value, LONGEST + 1))
        return items if len(items) <= LONGEST else None
    return None


def is_by_axis(value: object) -> bool:
    """True for a clean value that is stated twice, for v and for omega."""
    return isinstance(value, tuple) and bool(value) and isinstance(value[0], tuple)


def kind_of(default: object) -> str:
    """Infer a field's kind from its default value (a vector's elements are numbers)."""
    if isinstance(default, bool):
        return "flag"
    if isinstance(default, int):
        return "integer"
    if isinstance(default, str):
        return "text"
    return "optional" if default is None else "number"


def multiple(value: float, period: float) -> int | None:
    """Return value/period if it is whole within 1e-9 (relative beyond 1), else ``None``."""
    ratio = value / period
    if not ratio < 1e15:
        return None
    whole = round(ratio)
    return whole if abs(ratio - whole) <= 1e-9 * max(1, whole) else None


def check_multiple(
    name: str, value: float, unit_name: str, unit: float, most: int = 0, least: int = 0
) -> None:
    """Raise ScenarioError unless ``value`` [s] is a whole multiple of ``unit`` [s].

    ``least`` and ``most``: range of the factor; a ``most`` of 0 sets no bound.
    """
    if most:
        check_count(name, value, unit_name, unit, most)
    count, ratio = multiple(value, unit), value / unit
    if count is None or count < least:
        raise ScenarioError(
            f"{name} = {value!r} s must be a whole multiple of {unit_name} = {unit!r} s, not "
            f"{ratio:.9g} times it. The nearest is {max(1, round(ratio)) * unit:.9g} s."
        )


def check_count(name: str, value: float, unit_name: str, unit: float, most: int) -> None:
    """Raise ScenarioError if ``value`` [s] is more than ``most`` times ``unit`` [s]."""
    if value > (most + 0.5) * unit:
        raise ScenarioError(
            f"{name} = {value!r} s is {value / unit:.6g} times {unit_name} = {unit!r} s; at most "
            f"{most:g} are possible. Shorten {name} or lengthen {unit_name}."
        )
