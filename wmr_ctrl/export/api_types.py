"""Types of the arguments and results of `wmr_ctrl.api`, for those who check their own code."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TypeAlias, TypedDict

from wmr_ctrl.control.given import Overrides as Overrides
from wmr_ctrl.control.laws.given import LawGiven as LawGiven
from wmr_ctrl.world.scenario import Scenario

Progress: TypeAlias = Callable[[float], None]
"""Called with the share that is done, 0 to 1."""


class CommonOptions(TypedDict, total=False):
    """Options of `export_fmu` for FMUs and for an SSP."""

    law: LawGiven
    scenario: str | Path | Scenario
    fmi: str | int
    target: str
    out: str | Path
    progress: Callable[[str], None] | None


class SspOptions(CommonOptions, total=False):
    """Options of `export_fmu` for an SSP, as in `wmr_ctrl.export.fmi.ssp.export_ssp`."""

    plant: str | Path | None
    controller: str | Path | None
    map_file: str | Path | None
    delay_known: bool
    flat: bool


class FmuOptions(CommonOptions, total=False):
    """Options of `export_fmu` for FMUs, as in `wmr_ctrl.export.fmi.fmu_files.export_fmu`."""

    arrays: bool


class ExportOptions(SspOptions, FmuOptions, total=False):
    """Options of `export_fmu` for any output."""


class CosimulationOptions(TypedDict, total=False):
    """Options of `cosimulate`, as in `wmr_ctrl.export.cosim.cosimulate`."""

    plant: str | Path | None
    controller: str | Path | None
    map_file: str | Path | None
    master: str
    delay_known: bool
    seed: int
    fmi: int
    compile_sources: bool
    progress: Progress | None


class PageOptions(TypedDict, total=False):
    """Options of `write_page`, as in `wmr_ctrl.export.page.write_page`."""

    laws: Sequence[LawGiven] | None
    seed: int
    progress: Progress | None


class Measurements(TypedDict):
    """Results of the benchmarks: ratios by name, with quartiles and targets.

    A ratio that could not be measured is None, with the reason. ``ns`` per step of each candidate;
    ``paper``: the paper's times and ours.
    """

    ratios: dict[str, float | None]
    reasons: dict[str, str]
    spread: dict[str, list[float] | None]
    targets: dict[str, str]
    ns: dict[str, float]
    paper: dict[str, object]


class BenchReport(Measurements):
    """The measurements, and ``text``: a table of them."""

    text: str
