"""Runs and their figures as plain values, pandas tables, and HTML.

pandas is imported on first use.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict
from html import escape
from typing import TYPE_CHECKING, cast

import numpy as np

from wmr_ctrl.core.errors import library
from wmr_ctrl.core.late_bound import late_bound
from wmr_ctrl.core.signals import TIME

from .figures import FIGURES, READINGS, values_of
from .settings import COUNTED

if TYPE_CHECKING:
    import pandas
    from numpy.typing import ArrayLike

    from .run import Run

ABSENT = "–"
PROVENANCE = ("version", "scenario_hash", "kernel_hash")
"""The keys of a run's provenance that the summary repeats."""
FMUS = ("reference", "controller", "guard", "filter", "plant")
FAULTS = ("warned", "lagged", "invalid")
"""Parts of a run that coupled FMUs, and what is told of them."""
COUPLED = ("master", "delay", *(f"{what}_{part}" for what in ("fmu", *FAULTS) for part in FMUS))
"""Keys of such a run that it repeats: who stepped, names and hashes of files, who warned,
reached the end of its steps late, or has a description that breaks FMI's rules."""


@np.errstate(over="ignore", invalid="ignore")
def summary(run: Run) -> dict[str, object]:
    """The run's identity, outcome and figures, as printed by ``wmr-ctrl run --json``.

    Plain Python values only; None for a window that the run did not cover and for a number that is
    not finite.
    """
    known = run.settings
    values = {
        "scenario": run.scenario,
        "law": run.law,
        "guard": {name: getattr(known, name) for name in COUNTED} if run.guard else None,
        "seed": run.seed,
        "engine": run.engine,
        "plant": known.plant_kind,
        "watched_every": known.plant,
        "outcome": run.outcome.value,
        "robots": [{"from": time, "robot": words} for time, words in known.robots],
        **{key: of(run) for key, of in READINGS.items()},
        "figures": values_of(run, (item for item in FIGURES if not item.key)),
        "remarks": [asdict(item) for item in run.remarks],
        "provenance": {key: run.provenance.get(key) for key in PROVENANCE}
        | {key: run.provenance[key] for key in COUPLED if key in run.provenance},
    }
    return {key: json_safe(value) for key, value in values.items()}


def json_safe(value: object) -> object:
    """``value`` as plain dicts, lists, texts and numbers; null (None) for inf and NaN.

    NumPy scalars and arrays become numbers and lists.
    """
    if isinstance(value, Mapping):
        return {str(key): json_safe(item) for key, item in value.items()}
    if isinstance(value, np.generic | np.ndarray):
        return json_safe(value.tolist())
    if isinstance(value, list | tuple):
        return [json_safe(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


def run_frame(run: Run) -> pandas.DataFrame:
    """A column per logged number by element name, the time [s] as index ``t``.

    ``attrs`` has the labels and ``units`` (unit by column).  Raises MissingExtraError.
    """
    pandas = library("pandas")
    names = [signal.name for signal in run.elements if signal.name != TIME.name]
    index = pandas.Index(run.time, name=TIME.name)
    frame = pandas.DataFrame({name: run[name] for name in names}, index=index)
    frame.attrs = {**labels(run), "units": {s.name: s.unit for s in run.elements}}
    return frame


def table_frame(columns: Mapping[str, ArrayLike], units: Mapping[str, str]) -> pandas.DataFrame:
    """Columns of equal length as a table; units are in ``attrs["units"]``."""
    frame = library("pandas").DataFrame(dict(columns))
    frame.attrs = {"units": {name: units[name] for name in columns if name in units}}
    return frame


def labels(run: Run) -> dict[str, object]:
    """Identity of a run, as plain values."""
    return {
        "scenario": run.scenario, "law": run.law, "guard": int(run.guard), "seed": run.seed,
        "engine": run.engine, "outcome": run.outcome.value,
    }  # fmt: skip


def run_html(run: Run) -> str:
    """A run's labels, outcome, the figures that suit its base, and remarks."""
    guarded = ", guarded" if run.guard else ""
    figures = cast("list[tuple[str, str]]", late_bound("rows_of")(run))
    remarks = [(remark.key, remark.text) for remark in run.remarks]
    title = f"{run.law}{guarded} on {run.scenario}, seed {run.seed}, {run.engine} engine"
    return table_html(title, [("outcome", run.outcome.value), *figures, *remarks])


def table_html(title: str, rows: Iterable[Sequence[str]], header: Sequence[str] = ()) -> str:
    """A titled table; every cell is escaped."""
    head = f"<tr>{''.join(f'<th>{escape(cell)}</th>' for cell in header)}</tr>" if header else ""
    style = "text-align:left;vertical-align:top"
    cells = ("".join(f"<td style={style!r}>{escape(cell)}</td>" for cell in row) for row in rows)
    body = "".join(f"<tr>{row}</tr>" for row in cells)
    return f"<div><strong>{escape(title)}</strong><table>{head}{body}</table></div>"


def figure(value: object) -> str:
    """A number with four digits, a text unchanged, – for None."""
    if value is None:
        return ABSENT
    return f"{value:.4g}" if isinstance(value, float) else str(value)
