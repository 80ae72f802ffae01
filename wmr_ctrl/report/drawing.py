"""A figure as a thing to be rendered: its name, its size, and what draws it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from wmr_ctrl.report.style import house_style
from wmr_ctrl.results import atomic_path

SUFFIXES = (".svg", ".png")


@dataclass(frozen=True, slots=True)
class Drawing:
    """One figure of the report.

    ``name`` is that of its files, ``title`` stands above it, ``caption`` says what to see in it;
    ``size`` is its width and height [inch].
    """

    name: str
    title: str
    caption: str
    size: tuple[float, float]
    draw: Callable[[Figure], None]

    def figure(self) -> Figure:
        """The drawn figure, independent of any window or global state."""
        figure = Figure(figsize=self.size)
        FigureCanvasAgg(figure)
        self.draw(figure)
        return figure

    def save(self, folder: Path, suffixes: tuple[str, ...] = SUFFIXES) -> tuple[Path, ...]:
        """Write one file per suffix into ``folder``, each whole or not at all."""
        paths = tuple(folder / f"{self.name}{suffix}" for suffix in suffixes)
        with house_style():
            figure = self.figure()
            for path in paths:
                save_figure(figure, path)
        return paths


def save_figure(figure: Figure, path: Path) -> None:
    """Write a figure to ``path``, without dates in it, so that equal figures are equal files."""
    metadata = {".svg": {"Date": None}, ".pdf": {"CreationDate": None}}.get(path.suffix.lower())
    with atomic_path(path) as scratch:
        figure.savefig(scratch, metadata=metadata)
