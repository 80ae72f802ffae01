"""Helpers of the figures: a figure as a value, axes placed in inches, and marks."""

import io
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypeAlias

import numpy as np
from jinja2 import Environment
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure, SubFigure
from matplotlib.lines import Line2D
from matplotlib.ticker import LogLocator, NullFormatter

from wmr_ctrl.core.errors import ResultFileError
from wmr_ctrl.core.fields.files import AnyPath
from wmr_ctrl.results import (
    Floats,
    Settings,
    atomic_path,
    atomic_text,
    check_writable,
    robots_over,
)

from .style import (
    INK,
    LIMIT,
    MUTED,
    Dash,
    house_style,
    page_environment,
    picture,
    shown,
)

SUFFIXES = (".svg", ".png")
Place: TypeAlias = Figure | SubFigure
"""Target of a panel: a figure of its own, or a part of a sheet."""
_SWITCH: Dash = (0, (2, 2))


@dataclass(frozen=True)
class Drawing:
    """One figure: the name of its files, width and height [inch], and its drawing function.

    ``title``: the text for readers of the page without pictures.
    """

    name: str
    size: tuple[float, float]
    draw: Callable[[Figure], None]
    title: str = ""

    def figure(self) -> Figure:
        """The drawn figure, independent of any window or global state."""
        figure = Figure(figsize=self.size)
        FigureCanvasAgg(figure)
        self.draw(figure)
        return figure

    def save(self, folder: Path, suffixes: tuple[str, ...] = SUFFIXES) -> tuple[Path, ...]:
        """Write one file per suffix into ``folder``, each atomically."""
        paths = tuple(folder / f"{self.name}{suffix}" for suffix in suffixes)
        self.written(paths)
        return paths

    def written(self, paths: Iterable[Path]) -> Figure:
        """The figure in the house style, also written to files."""
        with house_style():
            figure = self.figure()
            for path in paths:
                save_figure(figure, path)
        return figure

    def inlined(self) -> str:
        """The figure in the house's style, as `inlined`."""
        with house_style():
            return inlined(self.figure())


def save_figure(figure: Figure, path: Path) -> None:
    """Write a figure to ``path`` without dates, so that equal figures are equal files."""
    metadata = {".svg": {"Date": None}, ".pdf": {"CreationDate": None}}.get(path.suffix.lower())
    with atomic_path(path) as scratch:
        figure.savefig(scratch, metadata=metadata)


def inlined(figure: Figure) -> str:
    """A figure as a data address, so that a page needs no other file."""
    text = io.StringIO()
    figure.savefig(text, format="svg", metadata={"Date": None})
    return picture(text.getvalue())


def target_of(path: AnyPath, suffixes: Sequence[str], what: str, *, write: bool = True) -> Path:
    """Checked path of a file to be written; ``what`` is the message on known suffixes.

    Raises ResultFileError for another suffix or, unless ``write`` is off, if nothing can be
    written.
    """
    target = Path(path)
    if target.suffix.lower() not in suffixes:
        raise ResultFileError(
            f"{str(target)!r} has the suffix {target.suffix!r}; {what}. "
            "Give the file one of these suffixes."
        )
    if write:
        check_writable(target)
    return target


def write_html(
    path: AnyPath, template: str, environment: Environment | None = None, **values: object
) -> None:
    """Write a page from a template of reports, atomically; errors as `target_of`."""
    target = target_of(path, (".html",), "the page is .html")
    text = (environment or page_environment()).get_template(template).render(values)
    with atomic_text(target) as file:
        file.write(text)


PICTURES = (".png", ".svg", ".pdf")


def picture_targets(path: AnyPath | None, are_drawn: str) -> list[Path]:
    """The path of a picture, or none; ``are_drawn``: a clause such as "runs are drawn"; as
    `target_of`.
    """
    known = f"{are_drawn} as {', '.join(PICTURES)}"
    return [] if path is None else [target_of(path, PICTURES, known)]


@dataclass(frozen=True)
class Padding:
    """Space around the axes of a panel [inch]."""

    left: float = 0.56
    right: float = 0.10
    bottom: float = 0.40
    top: float = 0.48


def size_of(place: Place) -> tuple[float, float]:
    """Width and height of a place [inch]."""
    dpi = place.figure.dpi if isinstance(place, SubFigure) else place.dpi
    return place.bbox.width / dpi, place.bbox.height / dpi


def one_axes(place: Place, padding: Padding) -> Axes:
    """A single pair of axes that fills the place inside the padding."""
    return row_of_axes(place, padding, (1.0,), 0.0)[0]


def row_of_axes(
    place: Place, padding: Padding, widths: Sequence[float], gap: float
) -> tuple[Axes, ...]:
    """Axes side by side with relative ``widths``, ``gap`` inches between them."""
    width, height = size_of(place)
    inner = width - padding.left - padding.right - gap * (len(widths) - 1)
    high = (height - padding.bottom - padding.top) / height
    left, axes = padding.left, []
    for share in widths:
        wide = inner * share / sum(widths)
        axes.append(place.add_axes((left / width, padding.bottom / height, wide / width, high)))
        left += wide + gap
    return tuple(axes)


def heading(place: Place, text: str, handles: Sequence[Line2D] = (), below: float = 0.24) -> None:
    """A title at the upper left corner, and a legend in one row, ``below`` inches under the edge.

    Neither ever lies over data.
    """
    width, height = size_of(place)
    place.text(0.06 / width, 1 - 0.06 / height, text, ha="left", va="top", weight="bold",
               size=8.5, color=INK)  # fmt: skip
    if handles:
        place.legend(handles=handles, ncols=len(handles), loc="upper left",
                     bbox_to_anchor=(0.06 / width, 1 - below / height))  # fmt: skip


def line_handle(label: str, colour: str, width: float = 1.4, dash: Dash = "-") -> Line2D:
    """A legend's entry for a line."""
    return Line2D([], [], color=colour, lw=width, ls=dash, label=label)


def plot_reference(axes: Axes, x: Floats, y: Floats, dots: int = 64) -> None:
    """The reference's path (N,) [m] as ``dots`` with a rim, visible on any law's line."""
    axes.plot(x, y, ls="", marker="o", ms=2.6, mfc=INK, mec="white", mew=0.6, zorder=3.5,
              markevery=max(1, len(x) // dots))  # fmt: skip


def mark_start(axes: Axes, x: Floats, y: Floats) -> None:
    """A ring at the first point of a path (N,) [m]."""
    axes.plot(x[0], y[0], "o", mfc="white", mec=INK, ms=4.5, zorder=4)


SLENDER = 12.0
"""A path this many times longer than wide is drawn on two scales: else all of it is one line."""


def finish_path(axes: Axes, marks: Iterable[str]) -> None:
    """Labels, title and scales of a map; ``marks`` are the texts of its legend."""
    wide, high = np.ptp(axes.dataLim.intervalx), np.ptp(axes.dataLim.intervaly)
    said = list(marks)
    if max(wide, high) > SLENDER * min(wide, high) > 0:
        said.append("x and y on different scales")
    else:
        axes.set_aspect("equal", adjustable="datalim")
    axes.set(xlabel="x [m]", ylabel="y [m]")
    axes.set_title(f"Path ({', '.join(said)})", weight="normal")


def include(axes: Axes, levels: Iterable[float]) -> None:
    """Widen the vertical view, if need be, so that it shows ``levels``."""
    low, high = axes.get_ylim()
    axes.set_ylim(min(low, *levels), max(high, *levels))


def shade_limits(axes: Axes, least: float, most: float) -> None:
    """Shade the area beyond ``least`` and ``most`` and draw its edges; the view stays as it is."""
    low, high = axes.get_ylim()
    for start, end in ((most, max(high, most)), (min(low, least), least)):
        axes.axhspan(start, end, color=LIMIT, alpha=0.10, lw=0, zorder=0.5)
    for level in (most, least):
        axes.axhline(level, color=LIMIT, lw=0.9, zorder=1.5)
    axes.set_ylim(low, high)


FAR = 4.0
"""A velocity is drawn up to so many times its limit."""


def limits_in_words(least: float, most: float) -> str:
    """The limits of a velocity, as "limit ±1" or "limits −0.2 to 1"."""
    if least == -most:
        return f"limit ±{most:g}"
    return f"limits {least:g} to {most:g}".replace("-", "−")


def view_limits(axes: Axes, sides: tuple[float, float], traces: Mapping[str, Floats]) -> None:
    """View named velocities with their limits, up to FAR times these; a remark names values
    outside.

    The area beyond the limits is shaded.
    """
    least, most = sides
    include(axes, (1.15 * least, 1.15 * most))
    low, high = axes.get_ylim()
    far = FAR * max(-least, most)
    axes.set_ylim(max(low, -far), min(high, far))
    gone = []
    for name, values in traces.items():
        ends = float(np.nanmin(values, initial=0.0)), float(np.nanmax(values, initial=0.0))
        gone += [f"{name} ↓ {shown(ends[0])}".strip()] * (ends[0] < -far)
        gone += [f"{name} ↑ {shown(ends[1])}".strip()] * (ends[1] > far)
    if gone:
        say_below(axes, f"out of view: {', '.join(gone)}")
    shade_limits(axes, least, most)


def say_below(axes: Axes, text: str) -> None:
    """Add a remark to the label of the horizontal axis, which no curve covers."""
    axes.set_xlabel(f"{axes.get_xlabel()}   ({text})")


def switch_handles(settings: Settings) -> list[Line2D]:
    """Legend's entry for :func:`mark_switch`; none if the robot never changes."""
    words = robots_over(settings)
    return [line_handle(words, MUTED, 0.9, _SWITCH)] if words else []


def mark_switch(axes: Axes, settings: Settings, end: float = math.inf) -> None:
    """A thin vertical line at each change of the robot before ``end`` [s]."""
    for time in (time for time, _ in settings.robots[1:] if time < end):
        axes.axvline(time, color=MUTED, lw=0.8, ls=_SWITCH, zorder=1.2)


def plain_ticks(axes: Axes, steps: Sequence[float] = (1, 2, 5)) -> None:
    """Label a logarithmic horizontal axis with plain numbers at ``steps`` of each decade."""
    axes.xaxis.set_major_locator(LogLocator(subs=steps))
    axes.xaxis.set_major_formatter(lambda value, _: f"{value:g}")
    axes.xaxis.set_minor_formatter(NullFormatter())


def running_mean(values: Floats, width: int) -> Floats:
    """Centred mean over ``width`` values, fewer at the ends, shape (N,)."""
    total = np.concatenate(([0.0], np.cumsum(values)))
    index = np.arange(len(values))
    low = np.maximum(index - width // 2, 0)
    high = np.minimum(index + width - width // 2, len(values))
    return np.asarray((total[high] - total[low]) / (high - low))
