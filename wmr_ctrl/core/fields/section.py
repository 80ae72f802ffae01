"""Dataclass fields with unit, meaning and bounds, and the validation that all of them share.

A section of a scenario, or the gains of a law, derives from :class:`Section`, which makes it a
frozen dataclass that takes keywords; its fields are made by :func:`quantity`::

    class Gains(Section, key="gains.mb"):
        rho: tuple[float, float] = quantity((15.0, 57.6), "1/s", "decay rates", above=0)
"""

import dataclasses
from collections.abc import Iterator, Mapping
from typing import Any, ClassVar, TypeVar, cast, dataclass_transform

from wmr_ctrl.core.errors import ScenarioError, UnknownKeyError, UnknownNameError, show
from wmr_ctrl.core.signals import Signal

from .values import Quantity, Range, is_by_axis, kind_of

REQUIRED = dataclasses.MISSING
"""Default of a field that every scenario must give (a number)."""


def quantity(
    default: object,
    unit: str,
    doc: str,
    *,
    kind: str | None = None,
    options: tuple[str, ...] = (),
    above: float | None = None,
    minimum: float | None = None,
    below: float | None = None,
    maximum: float | None = None,
    infinite: bool = False,
    size: int = 0,
    usual: tuple[float, float] | None = None,
    multiple_of: str = "",
    most: int = 0,
    orientation: int = 0,
    alike: bool = False,
    by_axis: bool = False,
) -> Any:
    """Return a dataclass field whose metadata hold ``quantity``, ``unit``, ``doc``, ``bounds``.

    Type and size follow from ``default``: a float is a number, an int a whole number, a bool a
    flag, a str a text (one of ``options`` if given), a tuple of floats a vector of that length,
    ``None`` an optional number, ``REQUIRED`` a number that must be given.  ``kind`` overrides this
    (``"points"`` is a list of pairs of any length, ``"shapes"`` one of circles and polygons,
    ``"mapping"`` a table, ``"numbers"`` a table of numbers, ``"texts"`` and ``"flags"`` lists of
    those); ``size`` makes an optional field a vector.  Bounds hold for every element, in ``unit``;
    ``infinite`` admits inf.  For values outside ``usual`` (default: the range of the unit) `check`
    asks if the unit is right.  ``multiple_of``: key of a time of which this one is a whole
    multiple, at most ``most`` times it unless ``most`` is 0.  ``orientation``: number of the
    element, from 1, that is an orientation of the plane, 0 along +Y; a scenario's ``frames`` says
    how files state it.  ``alike``: one value may stand for both elements of a pair.  ``by_axis``: a
    vector may be stated twice, for v and for omega.
    """
    bounds = Range(above, minimum, below, maximum, infinite)
    elements = len(default) if isinstance(default, tuple) and kind is None else size
    if kind is None:
        number = default is REQUIRED or isinstance(default, tuple)
        kind = "number" if number else kind_of(default)
    what = Quantity(
        default,
        unit,
        doc,
        bounds,
        kind,
        elements,
        options,
        usual,
        multiple_of,
        most,
        orientation,
        alike,
        by_axis,
    )
    metadata = {"quantity": what, "unit": unit, "doc": doc, "bounds": bounds}
    if default is REQUIRED:
        return dataclasses.field(metadata=metadata)
    return dataclasses.field(default=default, metadata=metadata)


@dataclass_transform(kw_only_default=True, frozen_default=True)
class Section:
    """Base of the frozen dataclasses of a scenario: cleans and checks every field on creation.

    A derived class names its table, ``key``, or leaves that to its own derived classes.
    """

    KEY: ClassVar[str] = ""
    QUANTITIES: ClassVar[tuple[tuple[str, Quantity], ...]] = ()

    def __init_subclass__(cls, *, key: str = "") -> None:
        super().__init_subclass__()
        cls.KEY = key or cls.KEY
        dataclasses.dataclass(frozen=True, kw_only=True)(cls)
        fields = dataclasses.fields(cls)  # type: ignore[arg-type]
        cls.QUANTITIES = tuple((field.name, field.metadata["quantity"]) for field in fields)

    def __post_init__(self) -> None:
        """Convert every field to its own type, or raise a ScenarioError that names the key."""
        for name, what in quantities(type(self)):
            object.__setattr__(self, name, what.clean(getattr(self, name), key(self.KEY, name)))
        self.relate()

    def relate(self) -> None:
        """Check relations between the fields; a section that has some overrides this."""


S = TypeVar("S", bound=Section)
_DEFAULTS: dict[type[Section], Section] = {}


def quantities(cls: type[Section]) -> tuple[tuple[str, Quantity], ...]:
    """Name and :class:`Quantity` of each field of a section or gains dataclass."""
    return cls.QUANTITIES


def default(cls: type[S]) -> S:
    """The section with all its default values, made once."""
    if cls not in _DEFAULTS:
        _DEFAULTS[cls] = cls()
    return cast("S", _DEFAULTS[cls])


def build(cls: type[S], raw: object, path: str | None = None) -> S:
    """Make a section from a raw table of TOML; errors name keys below ``path`` (default: its KEY).

    Raises ScenarioError for an invalid value, UnknownKeyError for an unknown key.
    """
    where = cls.KEY if path is None else path
    if not isinstance(raw, Mapping):
        header = f"[[{where.split('[')[0]}]]" if where.endswith("]") else f"[{where}]"
        raise ScenarioError(f"{where} = {show(raw)} must be a table, written as {header}.")
    known = dict(quantities(cls))
    values = {}
    for name, value in raw.items():
        if name not in known:
            raise UnknownKeyError(key(where, str(name)), known)
        values[name] = value if path is None else known[name].clean(value, key(where, name))
    for name, what in known.items():
        if what.default is REQUIRED and name not in values:
            raise ScenarioError(f"{key(where, name)} is missing: {what.doc} [{what.unit}].")
    return cls(**values)


def questions(section: Section, path: str) -> Iterator[tuple[str, str]]:
    """Yield key and question for each value of a section whose unit looks mistaken."""
    for name, what in quantities(type(section)):
        for sentence in what.questions(getattr(section, name), key(path, name)):
            yield key(path, name), sentence


def number_of(section: Section, name: str, path: str) -> tuple[Signal, tuple[float, ...]]:
    """Signal called ``path`` and value of a section's field; raises as `numbers_in` does."""
    numbers = numbers_in(section, name)
    what = dict(quantities(type(section)))[name]
    of_both = ", of v, then of omega" * (0 < what.size < len(numbers))
    return Signal(path, what.unit, what.doc + of_both, len(numbers)), numbers


def numbers_in(section: Section, name: str) -> tuple[float, ...]:
    """Value of a section's field as numbers; UnknownNameError if it is something else."""
    value = vars(section).get(name)
    numbers = value if isinstance(value, tuple) else (value,)
    if is_by_axis(value) and dict(quantities(type(section)))[name].by_axis:
        numbers = numbers[0] + numbers[1]
    if not all(isinstance(item, int | float) and not isinstance(item, bool) for item in numbers):
        raise UnknownNameError("number", key(section.KEY, name), dict(quantities(type(section))))
    return tuple(map(float, numbers))


def key(path: str, name: str) -> str:
    """Join a section's path and a field's name by a dot."""
    return f"{path}.{name}" if path else name
