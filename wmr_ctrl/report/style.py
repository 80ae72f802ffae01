"""Common style of figures, numbers and pages: colours, sizes, digits, unit signs, templates."""

import base64
import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any, TypeAlias

import matplotlib as mpl
from jinja2 import Environment, PackageLoader, StrictUndefined

from wmr_ctrl.core.data import data
from wmr_ctrl.core.errors import printable

PAPER = "#ffffff"
"""Background of drawings and pages."""
INK = "#222222"
"""Axes, text and the robot."""
MUTED = "#6b6b6b"
"""Notes, the reference trajectory and whatever serves for comparison."""
LIMIT = "#c62828"
"""Edges and shade of the region beyond a velocity limit."""
GRID = "#e4e4e4"
"""Lines behind the data."""
RULE_LINE = "#ececec"
"""Lines between rows of marks."""
DASHED = (0, (5, 1.6))
DASH_DOT = (0, (6, 1.5, 1.2, 1.5))
DOTTED = (0, (1.2, 1.4))
Dash: TypeAlias = str | tuple[float, tuple[float, ...]]
"""A line's dash pattern, as matplotlib takes it."""
DASHES: tuple[Dash, ...] = ("-", DASHED, DASH_DOT, DOTTED)
"""Dashes of runs drawn over each other, so that one hides another only in part."""
ABSENT = "–"


@dataclass(frozen=True)
class Look:
    """A law's plot style: colour, dash pattern, marker, and its short name."""

    label: str
    colour: str
    dash: Dash = "-"
    marker: str = "o"


_PATTERNS: Mapping[str, Dash] = {
    "solid": "-", "dashed": DASHED, "dash-dot": DASH_DOT, "dotted": DOTTED
}  # fmt: skip
"""Dash patterns by their names in data."""


def look_of(row: Mapping[str, str]) -> Look:
    """The look that a table of data describes."""
    return Look(row["label"], row["colour"], _PATTERNS[row["dash"]], row.get("marker", "o"))


_DATA = data(__package__, "looks.toml")
_LOOKS = {law: look_of(row) for law, row in _DATA["law"].items()}
_SPARE = [look_of(row) for row in _DATA["spare"]]
AFTER_DARK: Mapping[str, str] = _DATA["after_dark"]
"""Each colour of an animation, and its counterpart where a reader has asked for dark pages."""


def after_dark(colour: str) -> str:
    """The variant of a colour for readers who prefer dark pages."""
    return AFTER_DARK.get(colour, colour)


def look(law: str) -> Look:
    """The look of a law; laws of other origin get one of the spare looks, by name."""
    if law in _LOOKS:
        return _LOOKS[law]
    spare = _SPARE[sum(law.encode()) % len(_SPARE)]
    return replace(spare, label=law.replace("_", " "))


def colours_of(laws: Sequence[str]) -> list[str]:
    """Colours of runs of ``laws``: each law's own; a repeated law gets an unused one, if any is
    left.
    """
    every = [one.colour for one in (*_LOOKS.values(), *_SPARE)]
    own, taken = [look(law).colour for law in laws], list[str]()
    free = iter([colour for colour in every if colour not in own])
    for colour in own:
        taken.append(next(free, colour) if colour in taken else colour)
    return taken


def driver(law: str, guarded: bool) -> str:
    """Law and guard of a run, for its title."""
    return f"{look(law).label}{', guarded' if guarded else ''}"


def verbatim(name: str) -> str:
    """A user's name for a picture: on one line, and without formulas between ``$``."""
    return printable(name).replace("$", r"\$")


_SHEET = Path(__file__).with_name("house.mplstyle")
_COLOURS: dict[Any, Any] = {
    **dict.fromkeys(("axes.edgecolor", "axes.labelcolor", "xtick.color", "ytick.color"), INK),
    "grid.color": GRID,
}


@contextmanager
def house_style() -> Iterator[None]:
    """Context with matplotlib's defaults and our style on top, for any user settings."""
    with mpl.rc_context():
        mpl.rcdefaults()
        mpl.rcParams.update(mpl.rc_params_from_file(_SHEET, use_default_template=False))
        mpl.rcParams.update(_COLOURS)
        yield


def unit_text(unit: str) -> str:
    """A unit for readers (``N.m`` -> ``N m``, ``m2.s + rad2.s`` -> ``m² s + rad² s``)."""
    return "" if unit == "1" else unit.replace(".", " ").translate(str.maketrans("23", "²³"))


def with_unit(text: str, unit: str) -> str:
    """An axis label: the quantity, and its unit in brackets if it has one."""
    shown = unit_text(unit)
    return f"{text} [{shown}]" if shown else text


def shown(value: float | None, digits: int = 3) -> str:
    """A number with ``digits`` significant digits, without programmers' notation; – for None."""
    if value is None or math.isnan(value):
        return ABSENT
    if math.isinf(value):
        return "∞" if value > 0 else "−∞"
    if value == 0:
        return "0"
    mantissa, power = f"{value:.{digits - 1}e}".split("e")
    if 1e-3 <= abs(value) < 1e5:
        places = digits - 1 - int(power)
        return f"{round(value, places):.{max(places, 0)}f}".replace("-", "−")
    raised = str(int(power)).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))
    return f"{mantissa}·10{raised}".replace("-", "−")


@cache
def page_environment(package: str = "wmr_ctrl.report") -> Environment:
    """A package's templates; texts are escaped, and an undefined name is an error."""
    environment = Environment(
        loader=PackageLoader(package, "templates"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {"shown": shown, "with_unit": with_unit}
    environment.tests["finite"] = math.isfinite
    return environment


def picture(svg: str) -> str:
    """An SVG text as a data address, so that the page needs no other file."""
    text = base64.b64encode(svg.encode()).decode("ascii")
    return f"data:image/svg+xml;base64,{text}"
