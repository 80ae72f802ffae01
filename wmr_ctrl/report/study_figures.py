"""Pictures of a study: a heat map, boxes, the region where the limit is kept, indices."""

import json
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from textwrap import fill
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from matplotlib.image import AxesImage
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from wmr_ctrl.core.errors import library
from wmr_ctrl.results.figures import SHARES
from wmr_ctrl.simulation.campaign.plan import SOBOL, SamplePlan

from . import style
from .drawing import save_figure
from .study_table import StudyTable, read_study

Floats = NDArray[np.float64]
MOST_VALUES = 12
BINS = 8
KEPT = "#1F77C9"
_SHARES = {"violated": "share of runs beyond a limit", "tracked": "share of runs that tracked"}


def plot_study(folder: str | Path) -> list[Path]:
    """Draw the pictures of a study's table into its folder, as SVG and PNG; returns the files.

    Raises ResultFileError for a folder without a finished study, MissingExtraError for Sobol
    indices without SALib.
    """
    table = read_study(Path(folder))
    written = []
    with style.house_style():
        for name, figure in drawings_of(table):
            for suffix in (".svg", ".png"):
                path = Path(folder) / f"{name}{suffix}"
                save_figure(figure, path)
                written.append(path)
    return written


def drawings_of(table: StudyTable) -> Iterator[tuple[str, Figure]]:
    """Yield name and figure of each picture of a study."""
    yield "spread", _by_group(table)
    if not np.isfinite(table.numbers[table.figure]).any():
        return
    if table.keys:
        yield "factors", _by_factor(table)
    if len(table.keys) >= 2:
        yield "map", _maps(table, table.figure)
        if "violated" in table.plan["figures"]:
            yield "limit-kept", _maps(table, "violated")
    if table.plan["sample"] and table.plan["sample"]["method"] == SOBOL:
        yield "sobol", _indices(table)


def _label(table: StudyTable, name: str) -> str:
    unit = table.scale(name)[1]
    return f"{name} [1]" if unit == "1" else style.with_unit(name, unit)


def _values(table: StudyTable, mask: NDArray[np.bool_]) -> Floats:
    """The drawn figure's finite values over some runs."""
    values = table.numbers[table.figure][mask] * table.scale(table.figure)[0]
    return values[np.isfinite(values)]


def _by_group(table: StudyTable) -> Figure:
    """A box for each law and guard."""
    wide = max(4.2, 1.6 + 0.9 * len(table.groups))
    figure = Figure(figsize=(wide, 3.2), layout="constrained")
    axes = figure.add_subplot()
    drawn = 0
    for place, group in enumerate(table.groups):
        values = _values(table, table.group == group)
        _boxes(axes, group, [values], np.array([place]), 0.6)
        drawn += values.size
    axes.set_xticks(range(len(table.groups)), [_label_of(group, "\n") for group in table.groups])
    axes.set(ylabel=_label(table, table.figure), xlim=(-0.6, len(table.groups) - 0.4))
    figure.suptitle(f"{len(table.group)} runs: median and quartiles", fontsize="medium")
    why = fill(_missing(table), int(14 * wide))
    if drawn:
        axes.set_title(why, color=style.MUTED, fontsize="small", fontweight="normal")
    else:
        _say(axes, why)
    return figure


def _boxes(
    axes: Axes, group: str, values: list[Floats], places: NDArray[np.floating], width: float
) -> None:
    """Boxes in the look of a law and guard; outliers are omitted."""
    guarded, colour = "guarded" in group, _colour(group)
    # Lines in the law's colour: a box may be thinner than its outline.
    line = {"color": colour, "linestyle": style.DOTTED if guarded else "-"}
    face = to_rgba(colour, 0.15 if guarded else 0.45)
    drawn = axes.boxplot(
        values,
        positions=places,
        widths=width,
        showfliers=False,
        manage_ticks=False,
        patch_artist=True,
        medianprops=line | {"linewidth": 2.0},
        boxprops={"facecolor": face, "edgecolor": colour, "linestyle": line["linestyle"]},
        whiskerprops=line,
        capprops={"color": colour},
    )
    drawn["boxes"][0].set_label(_label_of(group))


def _missing(table: StudyTable) -> str:
    return table.missing(np.ones(len(table.group), dtype=bool))


def _say(axes: Axes, text: str) -> None:
    """A text in place of a picture that cannot be drawn."""
    axes.set_yticks([])
    axes.text(0.5, 0.5, text, ha="center", va="center", color=style.MUTED, fontsize="small",
              transform=axes.transAxes)  # fmt: skip


def _colour(group: str) -> str:
    return style.look(group.split(",")[0]).colour


def _label_of(group: str, join: str = ", ") -> str:
    law, _, guard = group.partition(",")
    return style.look(law).label + (f"{join}guarded" if guard else "")


def _by_factor(table: StudyTable) -> Figure:
    """Boxes of the figure by each key, with a colour per law and guard."""
    keys, count = table.keys, len(table.groups)
    figure = Figure(figsize=(7.2, 2.6 * len(keys)), layout="constrained")
    for axes, key in zip(figure.subplots(len(keys), 1, squeeze=False)[:, 0], keys, strict=True):
        bins = _bins(table.numbers[key])
        for k, group in enumerate(table.groups):
            values = [
                _values(table, (table.group == group) & (bins.places == b))
                for b in range(bins.count)
            ]
            places = np.arange(bins.count) + (k + 0.5) / count * 0.8 - 0.4
            _boxes(axes, group, values, places, 0.7 / count)
        axes.set_xticks(bins.ticks, bins.labels)
        axes.set_xlim(-0.6, bins.count - 0.4)
        axes.set(xlabel=_label(table, key), ylabel=_label(table, table.figure))
        if key == keys[0] and count > 1:
            axes.legend(ncols=4, loc="lower left", bbox_to_anchor=(0, 1.0))
    if why := _missing(table):
        figure.suptitle(fill(why, 100), color=style.MUTED, fontsize="small")
    return figure


@dataclass(frozen=True)
class Bins:
    """Bins of a key's values: the bin of each, and ticks at places and labels.

    Bin b is drawn around b: a tick at b is that of a single value, one at b - 1/2 a bin's edge.
    """

    count: int
    places: NDArray[np.intp]
    ticks: Floats
    labels: list[str]


def _bins(values: Floats) -> Bins:
    """The values themselves if they are few, else bins between round numbers."""
    known, places = np.unique(values, return_inverse=True)
    if known.size <= MOST_VALUES:
        labels = [f"{value:.3g}" for value in known]
        return Bins(len(known), places, np.arange(float(len(known))), labels)
    edges = MaxNLocator(BINS, steps=[1, 2, 5, 10]).tick_values(known[0], known[-1])
    places = np.clip(np.searchsorted(edges, values, side="right") - 1, 0, len(edges) - 2)
    ticks = np.arange(float(len(edges))) - 0.5
    return Bins(len(edges) - 1, places, ticks, [f"{edge:g}" for edge in edges])


def _maps(table: StudyTable, name: str) -> Figure:
    """The median of a figure over the first two keys, or the share of a figure of 0 and 1."""
    keys, groups = table.keys[:2], table.groups
    wide = len(groups)
    if wide > 3:
        wide = min((3, 2), key=lambda columns: -len(groups) % columns)
    high = -(-len(groups) // wide)
    figure = Figure(figsize=(1.2 + 2.6 * wide, 0.5 + 2.4 * high), layout="constrained")
    grid = [_bins(table.numbers[key]) for key in keys]
    cells = [_cells(table, name, grid, table.group == group) for group in groups]
    finite = np.concatenate([c[np.isfinite(c)] for c in cells])
    ends = (finite.min(), finite.max()) if finite.size and name not in SHARES else (0.0, 1.0)
    axes = np.ravel(figure.subplots(high, wide, squeeze=False))
    for place, ax in enumerate(axes):
        if place >= len(groups):
            ax.set_axis_off()
            continue
        image = _map(ax, cells[place], grid, ends, name)
        ax.set(title=_label_of(groups[place]))
        ax.set(xlabel=_label(table, keys[0]), ylabel=_label(table, keys[1]))
    figure.colorbar(image, ax=list(axes), label=_SHARES.get(name, f"median {_label(table, name)}"))
    if any(np.isnan(part).any() for part in cells):
        figure.suptitle("hatched: no run there", color=style.MUTED, fontsize="small")
    return figure


def _cells(table: StudyTable, name: str, grid: list[Bins], mask: NDArray[np.bool_]) -> Floats:
    """Median (for shares the mean) in each bin of two keys; NaN without a run."""
    across, up = grid
    cells = np.full((up.count, across.count), np.nan)
    values = table.numbers[name] * table.scale(name)[0]
    for i, j in np.ndindex(cells.shape):
        inside = values[mask & (across.places == j) & (up.places == i) & np.isfinite(values)]
        if inside.size:
            cells[i, j] = inside.mean() if name in SHARES else np.median(inside)
    return cells


def _map(
    axes: Axes, cells: Floats, grid: list[Bins], ends: tuple[float, float], name: str
) -> AxesImage:
    colours = "RdYlBu_r" if name == "violated" else "viridis"
    axes.grid(visible=False)
    axes.patch.set(hatch="////", edgecolor=style.GRID)
    low, high = ends
    image = axes.imshow(cells, origin="lower", aspect="auto", cmap=colours, vmin=low, vmax=high)
    for ticks, bins in zip((axes.set_xticks, axes.set_yticks), grid, strict=True):
        step = -(-len(bins.ticks) // 6)
        ticks(bins.ticks[::step], bins.labels[::step])
    return image


def _indices(table: StudyTable) -> Figure:
    """First and total Sobol indices of the figure with 95 % intervals.

    A row for each point of the grid, a column for each law and guard. Each point has the mean
    over its seeds; if a run has no value, a text there says why.
    """
    grid, ranges = table.plan["grid"], table.plan["sample"]["ranges"]
    combinations = list(product(*grid.values()))
    wide = len(table.groups)
    high = len(combinations)
    size = (1.0 + 2.6 * wide, 0.3 + 2.8 * high)
    figure = Figure(figsize=size, layout="constrained")
    for row, line in enumerate(figure.subplots(high, wide, squeeze=False)):
        at = zip(grid, combinations[row], strict=True)
        where = "".join(f"\n{key} = {json.dumps(value)}" for key, value in at)
        for group, axes in zip(table.groups, line, strict=True):
            axes.set_title(_label_of(group) + where)
            axes.set_xticks(np.arange(len(ranges)), list(ranges), rotation=20, ha="right")
            _bars(table, axes, (table.group == group) & (table.point // _points(table) == row))
    drawn = [axes for axes in figure.axes if axes.get_legend_handles_labels()[0]]
    if drawn:
        handles, labels = drawn[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper left", ncols=2)
    return figure


def _points(table: StudyTable) -> int:
    """Points of the sample that Sobol indices need."""
    sample = table.plan["sample"]
    return int(sample["n"] * (len(sample["ranges"]) + 2))


def _bars(table: StudyTable, axes: Axes, mask: NDArray[np.bool_]) -> None:
    """Indices over the runs of a mask, or the reason why there are none."""
    values, points = table.numbers[table.figure][mask], table.point[mask] % _points(table)
    why = table.missing(mask)
    if why or np.ptp(values) == 0:
        _say(axes, fill(why or f"{table.figure} is the same in all runs: nothing to explain", 34))
        return
    analyze: Any = library("SALib.analyze.sobol", "study")
    sample = SamplePlan(**table.plan["sample"])
    means = np.bincount(points, values) / np.bincount(points)
    seed = 1  # 0 would count as none
    indices = analyze.analyze(sample.problem, means, calc_second_order=False, seed=seed)
    bars = (-0.18, "S1", "first", KEPT), (0.18, "ST", "total", style.MUTED)
    for shift, key, label, colour in bars:
        places = np.arange(len(sample.ranges)) + shift
        axes.bar(places, indices[key], 0.34, label=label, color=colour,
                 yerr=indices[f"{key}_conf"], capsize=2, error_kw={"lw": 0.8})  # fmt: skip
    axes.set_ylabel(f"Sobol index of {table.figure} [1]")
