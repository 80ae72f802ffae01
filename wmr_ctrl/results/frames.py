"""Runs as tables of pandas and data sets of xarray, which are imported when somebody asks."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING

from wmr_ctrl.errors import MissingExtraError
from wmr_ctrl.signals import TIME

if TYPE_CHECKING:
    import pandas
    import xarray
    from numpy.typing import ArrayLike

    from wmr_ctrl.results.run import Run

INSTALL = "pip install 'wmr_ctrl[data]'"


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


def run_dataset(run: Run) -> xarray.Dataset:
    """A variable per signal over ``t`` [s]; vectors have a dimension ``NAME_element`` besides.

    Each variable has ``units`` and ``long_name``.  Raises MissingExtraError.
    """
    xarray = library("xarray")
    variables: dict[str, tuple[object, ...]] = {}
    coordinates: dict[str, tuple[object, ...]] = {}
    for signal in run.signals:
        about = {"units": signal.unit, "long_name": signal.meaning}
        if signal.name == TIME.name:
            coordinates[TIME.name] = (TIME.name, run.time, about)
        elif signal.size == 1:
            variables[signal.name] = (TIME.name, run[signal.name], about)
        else:
            along = f"{signal.name}_element"
            coordinates[along] = (along, list(signal.elements), {})
            variables[signal.name] = ((TIME.name, along), run[signal.name], about)
    return xarray.Dataset(variables, coordinates, labels(run))


def table_frame(columns: Mapping[str, ArrayLike], units: Mapping[str, str]) -> pandas.DataFrame:
    """Columns of equal length as a table; ``attrs["units"]`` has the unit of each that has one."""
    frame = library("pandas").DataFrame(dict(columns))
    frame.attrs = {"units": {name: units[name] for name in columns if name in units}}
    return frame


def labels(run: Run) -> dict[str, object]:
    """What tells one run from another, as plain values."""
    return {
        "scenario": run.scenario, "law": run.law, "guard": int(run.guard), "seed": run.seed,
        "engine": run.engine, "outcome": run.outcome.value,
    }  # fmt: skip


def library(name: str) -> ModuleType:
    """The library of that name; raises MissingExtraError where it is not installed."""
    try:
        return import_module(name)
    except ImportError:
        raise MissingExtraError(f"this needs {name}, which is not installed: {INSTALL}.") from None
