"""Pictures of a study: a heat map, boxes by factor, the region where the limit is kept, indices."""

from __future__ import annotations

import csv
import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from wmr_ctrl.campaign.study_plan import SHARES
from wmr_ctrl.campaign.study_sample import SOBOL, library
from wmr_ctrl.errors import ResultFileError
from wmr_ctrl.report.drawing import save_figure
from wmr_ctrl.report.style import LIMIT, MUTED, house_style, look, with_unit

Floats = NDArray[np.float64]
PlainPlan: TypeAlias = Mapping[str, Any]
"""A plan in plain values, as study.json has it."""
PREFERRED = ("position_rms", "ise_total")
MOST_VALUES = 12
BINS = 8
KEPT = "#1F77C9"


@dataclass(frozen=True)
class StudyTable:
    """What is drawn of a study: its plan in plain values, and the columns of its table.

    ``numbers`` has an array a column of numbers (NaN: none), ``group`` law and guard of each run.
    """

    plan: PlainPlan
    numbers: Mapping[str, Floats]
    group: NDArray[np.str_]
    units: Mapping[str, str]

    @property
    def keys(self) -> list[str]:
        """Fields with numbers that differ from run to run."""
        return [key for key in _keys(self.plan) if np.unique(self.numbers[key]).size > 1]

    @property
    def groups(self) -> list[str]:
        """Law and guard, in the plan's order."""
        return list(dict.fromkeys(self.group.tolist()))

    @property
    def figure(self) -> str:
        """The figure that is drawn: how well it tracked, else the first of the plan."""
        names = self.plan["figures"]
        return next((name for name in PREFERRED if name in names), names[0])


def plot_study(folder: str | Path) -> list[Path]:
    """Draw what a study's table shows into its folder, as SVG and PNG; returns the files.

    Raises ResultFileError for a folder without a finished study, MissingExtraError for Sobol
    indices without SALib.
    """
    table = _read(Path(folder))
    written = []
    with house_style():
        for name, figure in _drawings(table):
            for suffix in (".svg", ".png"):
                path = Path(folder) / f"{name}{suffix}"
                save_figure(figure, path)
                written.append(path)
    return written


def _keys(plan: Mapping[str, Any]) -> list[str]:
    sample = plan["sample"] or {"ranges": {}}
    return [*plan["grid"], *sample["ranges"]]


def _read(folder: Path) -> StudyTable:
    try:
        plan = json.loads((folder / "study.json").read_text(encoding="utf-8"))["plan"]
        with (folder / "columns.csv").open(encoding="utf-8", newline="") as file:
            units = {row["name"]: row["unit"] for row in csv.DictReader(file)}
        wanted = [*_keys(plan), *plan["figures"]]
        with (folder / "table.csv").open(encoding="utf-8", newline="") as file:
            reader = csv.reader(file)
            places = {name: place for place, name in enumerate(next(reader))}
            lists: dict[str, list[float]] = {name: [] for name in wanted}
            group = []
            for row in reader:
                guarded = ", guarded" if row[places["guard"]] == "true" else ""
                group.append(row[places["law"]] + guarded)
                for name, values in lists.items():
                    values.append(_number(row[places[name]]))
    except (OSError, KeyError, ValueError, StopIteration) as error:
        raise ResultFileError(_unfinished(folder, error)) from error
    if not group:
        raise ResultFileError(f"{str(folder)!r}: the study's table has no row.")
    numbers = {name: np.array(values) for name, values in lists.items()}
    return StudyTable(plan, numbers, np.array(group), units)


def _unfinished(folder: Path, error: Exception) -> str:
    """Why the folder cannot be drawn, and what to do."""
    if not folder.exists():
        why = f"there is no folder {str(folder)!r}."
    elif isinstance(error, OSError) and error.filename:
        reason = "is missing" if isinstance(error, FileNotFoundError) else "cannot be read"
        why = f"{str(folder)!r} holds no finished study: {Path(error.filename).name} {reason}."
    else:
        why = f"{str(folder)!r} holds no finished study: its files are damaged or not a study's."
    return (
        f"{why} Name the folder that `wmr-ctrl study PLAN.toml --out DIR` wrote, once the study "
        "has run to its end."
    )


def _number(cell: str) -> float:
    try:
        return float(cell)
    except ValueError:
        return {"true": 1.0, "false": 0.0}.get(cell, np.nan)


def _drawings(table: StudyTable) -> Iterator[tuple[str, Figure]]:
    """Name and figure of each picture that the study has something for."""
    yield "spread", _by_group(table)
    if table.keys:
        yield "factors", _by_factor(table)
    if len(table.keys) >= 2:
        yield "map", _maps(table, table.figure)
        if "violated" in table.plan["figures"]:
            yield "limit-kept", _maps(table, "violated")
    if table.plan["sample"] and table.plan["sample"]["method"] == SOBOL:
        yield "sobol", _indices(table)


def _label(table: StudyTable, name: str) -> str:
    return with_unit(name, table.units.get(name, ""))


def _values(table: StudyTable, mask: NDArray[np.bool_]) -> Floats:
    values = table.numbers[table.figure][mask]
    return values[np.isfinite(values)]


def _by_group(table: StudyTable) -> Figure:
    """A violin for each law and guard."""
    figure = Figure(figsize=(1.6 + 0.9 * len(table.groups), 3.0), layout="constrained")
    axes = figure.add_subplot()
    for place, group in enumerate(table.groups):
        values = _values(table, table.group == group)
        if values.size > 1 and np.ptp(values) > 0:
            parts = axes.violinplot(values, [place], widths=0.8, showextrema=False)
            bodies: Any = parts["bodies"]
            for body in bodies:
                body.set_facecolor(look(group.split(",")[0]).colour)
                body.set_alpha(0.35)
        if values.size:
            low, middle, high = np.quantile(values, (0.25, 0.5, 0.75))
            axes.vlines(place, low, high, color=look(group.split(",")[0]).colour, lw=3)
            axes.plot(place, middle, "o", ms=4, color="white", mec="black", mew=0.7)
    axes.set_xticks(range(len(table.groups)), [_short(group) for group in table.groups])
    axes.set_ylabel(_label(table, table.figure))
    axes.set_title(f"All runs: median, quartiles, density ({len(table.group)} runs)")
    return figure


def _short(group: str) -> str:
    law, _, guard = group.partition(",")
    return look(law).label + ("\nguarded" if guard else "")


def _by_factor(table: StudyTable) -> Figure:
    """Boxes of the figure by each key, a colour a law and guard."""
    keys = table.keys
    figure = Figure(figsize=(7.2, 2.6 * len(keys)), layout="constrained")
    for row, axes in enumerate(np.ravel(figure.subplots(len(keys), 1, squeeze=False))):
        centres, bins = _bins(table.numbers[keys[row]])
        count = len(table.groups)
        for k, group in enumerate(table.groups):
            inside = [
                _values(table, (table.group == group) & (bins == b)) for b in range(len(centres))
            ]
            colour = look(group.split(",")[0]).colour
            places = np.arange(len(centres)) + (k + 0.5) / count * 0.8 - 0.4
            axes.boxplot(
                inside, positions=places, widths=0.7 / count, showfliers=False, manage_ticks=False,
                patch_artist=True, medianprops={"color": "black"},
                boxprops={"facecolor": colour, "alpha": 0.3 if "guarded" in group else 0.7},
                whiskerprops={"color": MUTED}, capprops={"color": MUTED},
            )  # fmt: skip
            axes.plot([], [], "s", color=colour, alpha=0.3 if "guarded" in group else 0.7,
                      label=_short(group).replace("\n", ", "))  # fmt: skip
        axes.set_xticks(range(len(centres)), [f"{centre:.3g}" for centre in centres])
        axes.set_xlabel(_label(table, keys[row]))
        axes.set_ylabel(_label(table, table.figure))
        if row == 0 and count > 1:
            axes.legend(ncols=4, loc="lower left", bbox_to_anchor=(0, 1.0))
    return figure


def _bins(values: Floats) -> tuple[Floats, NDArray[np.intp]]:
    """Centres and the bin of each value: the values themselves where they are few."""
    known, places = np.unique(values, return_inverse=True)
    if known.size <= MOST_VALUES:
        return known, places
    edges = np.quantile(values, np.linspace(0, 1, BINS + 1))
    places = np.clip(np.searchsorted(edges, values, side="right") - 1, 0, BINS - 1)
    return (edges[:-1] + edges[1:]) / 2, places


def _maps(table: StudyTable, name: str) -> Figure:
    """The median of a figure over the first two keys, or the share of a figure of 0 and 1."""
    first, second = table.keys[:2]
    groups = table.groups
    wide = min(3, len(groups))
    high = -(-len(groups) // wide)
    figure = Figure(figsize=(1.2 + 2.6 * wide, 0.5 + 2.4 * high), layout="constrained")
    grid = [_bins(table.numbers[key]) for key in (first, second)]
    cells = [_cells(table, name, grid, table.group == group) for group in groups]
    finite = np.concatenate([c[np.isfinite(c)] for c in cells] or [np.zeros(1)])
    ends = (0.0, 1.0) if name in SHARES else _ends(finite)
    axes = np.ravel(figure.subplots(high, wide, squeeze=False))
    for place, ax in enumerate(axes):
        if place >= len(groups):
            ax.set_axis_off()
            continue
        image = _map(ax, cells[place], grid, ends, name)
        ax.set_title(_short(groups[place]).replace("\n", ", "))
        ax.set_xlabel(_label(table, first))
        ax.set_ylabel(_label(table, second))
    said = f"share of runs: {name}" if name in SHARES else f"median {_label(table, name)}"
    figure.colorbar(image, ax=list(axes), label=said)
    return figure


def _ends(finite: Floats) -> tuple[float, float]:
    if not finite.size:
        return 0.0, 1.0
    return float(finite.min()), float(finite.max())


def _cells(
    table: StudyTable,
    name: str,
    grid: list[tuple[Floats, NDArray[np.intp]]],
    mask: NDArray[np.bool_],
) -> Floats:
    """The median (of shares the mean) in each bin of two keys; NaN where there is no run."""
    (columns, across), (rows, up) = grid
    cells = np.full((len(rows), len(columns)), np.nan)
    values = table.numbers[name]
    for i in range(len(rows)):
        for j in range(len(columns)):
            inside = values[mask & (across == j) & (up == i)]
            inside = inside[np.isfinite(inside)]
            if inside.size:
                cells[i, j] = inside.mean() if name in SHARES else np.median(inside)
    return cells


def _map(
    axes: Axes,
    cells: Floats,
    grid: list[tuple[Floats, NDArray[np.intp]]],
    ends: tuple[float, float],
    name: str,
) -> Any:
    colours = "RdYlBu_r" if name == "violated" else "viridis"
    axes.grid(visible=False)
    image = axes.imshow(
        cells, origin="lower", aspect="auto", cmap=colours, vmin=ends[0], vmax=ends[1]
    )
    for ticks, (centres, _) in zip((axes.set_xticks, axes.set_yticks), grid, strict=True):
        step = -(-len(centres) // 6)
        places = range(0, len(centres), step)
        ticks(list(places), [f"{centres[k]:.3g}" for k in places])
    whole = name == "violated" and np.isfinite(cells).all() and min(cells.shape) > 1
    if whole and cells.min() < 0.5 < cells.max():
        axes.contour(cells, [0.5], colors=LIMIT, linewidths=1.0)
    return image


def _indices(table: StudyTable) -> Figure:
    """First and total Sobol indices of the figure with 95 % intervals, by law and guard.

    The mean over the seeds stands for each point; where a point has none, nothing is drawn.
    """
    analyze: Any = library("SALib.analyze.sobol", "study")
    ranges = table.plan["sample"]["ranges"]
    problem = {
        "num_vars": len(ranges), "names": list(ranges),
        "bounds": [list(pair) for pair in ranges.values()],
    }  # fmt: skip
    wide = len(table.groups)
    figure = Figure(figsize=(1.0 + 2.4 * wide, 3.0), layout="constrained")
    for place, axes in enumerate(np.ravel(figure.subplots(1, wide, squeeze=False))):
        group = table.groups[place]
        means = _point_means(table, table.group == group)
        axes.set_title(_short(group).replace("\n", ", "))
        if not np.isfinite(means).all() or np.ptp(means) == 0:
            axes.text(0.5, 0.5, "not defined:\nruns without the figure", ha="center", va="center",
                      color=MUTED, transform=axes.transAxes)  # fmt: skip
            continue
        indices = analyze.analyze(problem, means, calc_second_order=False, seed=0)
        at = np.arange(len(ranges))
        for shift, key, label, colour in (
            (-0.18, "S1", "first", KEPT),
            (0.18, "ST", "total", MUTED),
        ):
            axes.bar(at + shift, indices[key], 0.34, yerr=indices[f"{key}_conf"], label=label,
                     color=colour, capsize=2, error_kw={"lw": 0.8})  # fmt: skip
        axes.set_xticks(at, list(ranges), rotation=20, ha="right")
        axes.set_ylabel(f"Sobol index of {table.figure}")
        axes.legend()
    return figure


def _point_means(table: StudyTable, mask: NDArray[np.bool_]) -> Floats:
    """Mean of the figure at each point of the sample, in the plan's order.

    Points of a group stand together, in order, each with all of its seeds.
    """
    values = table.numbers[table.figure][mask]
    sample = table.plan["sample"]
    points = sample["n"] * (len(sample["ranges"]) + 2)
    if values.size % points or values.size != points * table.plan["seeds"]["count"]:
        return np.full(1, np.nan)
    return np.asarray(values.reshape(points, -1).mean(axis=1))
