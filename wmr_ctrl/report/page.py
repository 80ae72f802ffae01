"""The report as one page that needs nothing but itself."""

from __future__ import annotations

import base64
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path

from jinja2 import Environment, PackageLoader, StrictUndefined

from wmr_ctrl.campaign import Campaign, FigureTable
from wmr_ctrl.proofs.ledger import Entry, load
from wmr_ctrl.report.claims import RULE, Verdict
from wmr_ctrl.report.comparison_text import GuardSection
from wmr_ctrl.report.data_files import CITATION
from wmr_ctrl.report.drawing import Drawing
from wmr_ctrl.report.guarantee_figures import STRESS
from wmr_ctrl.report.measure_figures import HIDDEN
from wmr_ctrl.report.reproduction import Reproduction
from wmr_ctrl.report.style import shown
from wmr_ctrl.report.tables import TextTable, scenario_table, stress_table, times_table
from wmr_ctrl.results import atomic_write
from wmr_ctrl.scenario import preset_titles

_STRESS_CASES = {
    "far-start": "far start, exact model",
    "far-start-friction-overestimated": "far start, friction believed 50 % too high",
    "far-start-drop": "far start, mass and friction drop at 3 s",
    "outside-start": "start outside the limits",
    "paper-experiment-literal": "Section VI, torque held for 100 ms",
    "fast-reference": "reference at 0.9 m/s",
}
_SIGNS = {Verdict.HOLDS: "✓", Verdict.IN_PART: "◐", Verdict.FAILS: "✗"}


@dataclass(frozen=True)
class Page:
    """All that goes into the page; pictures are the SVG files of the folder ``figures``.

    ``guard`` is the content of the section past the paper, None where that was not run.
    """

    reproduction: Reproduction
    drawings: Sequence[Drawing]
    figures: Path
    guard: GuardSection | None = None


@dataclass(frozen=True, slots=True)
class LedgerSection:
    """What the page shows of the committed proof ledger; ``stale`` as in `Facts`."""

    tally: tuple[tuple[str, int], ...]
    refuted: tuple[Entry, ...]
    unproved: tuple[Entry, ...]
    stale: Sequence[str] | None


def write_page(path: Path, page: Page) -> None:
    """Render the page into one file, whole or not at all."""
    environment = Environment(
        loader=PackageLoader("wmr_ctrl.report", "templates"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters.update(shown=shown, sign=_SIGNS.__getitem__, slug=_slug)
    text = environment.get_template("report.html.j2").render(_content(page))
    with atomic_write(path, text=True) as file:
        file.write(text)


def load_readings() -> list[dict[str, object]]:
    """What had to be read into the paper, from the file beside this one.

    Entries have ``topic``, ``said``, ``reading``, ``why`` and the scenario's ``keys``.
    """
    text = files("wmr_ctrl.report").joinpath("readings.toml").read_text(encoding="utf-8")
    return list(tomllib.loads(text)["reading"])


def ledger_section(stale: Sequence[str] | None) -> LedgerSection:
    """Counts, refuted entries, and those that no program closed."""
    ledger = load()
    return LedgerSection(
        tally=tuple(ledger.tally().items()),
        refuted=tuple(entry for entry in ledger.entries if entry.verdict == "REFUTED"),
        unproved=tuple(entry for entry in ledger.entries if entry.verdict in ("HAND", "OPEN")),
        stale=stale,
    )


def _content(page: Page) -> dict[str, object]:
    campaign, judged = page.reproduction.campaign, page.reproduction.judged
    facts, table = page.reproduction.facts, campaign.table
    pictures = {drawing.name: drawing for drawing in page.drawings}
    return {
        "citation": CITATION,
        "rule": RULE,
        "judged": judged,
        "counts": [(v, sum(1 for one in judged if one.verdict == v)) for v in Verdict],
        "changed": [one for one in judged if not one.as_expected],
        "seeds": _seeds(table),
        "runs": len(table),
        "picture": lambda name: _picture(page.figures / f"{name}.svg"),
        "panels": {n: [d for d in page.drawings if _is_panel(d.name, n)] for n in (3, 5)},
        "hidden": [pictures[name] for name in HIDDEN],
        "stress": [pictures[name] for name in STRESS],
        "tables": _tables(table, facts.timings),
        "readings": load_readings(),
        "titles": facts.titles,
        "versions": facts.versions,
        "scenarios": _scenarios(campaign),
        "guard": page.guard,
        "ledger": ledger_section(facts.stale),
    }


def _tables(table: FigureTable, timings: Mapping[str, float]) -> dict[str, TextTable]:
    spread = "median (least … greatest) over the seeds"
    return {
        "simulation": scenario_table(table, "paper-simulation", f"Section V: {spread}"),
        "control": scenario_table(
            table, "paper-simulation-no-switch", f"The same without the change at 40 s: {spread}"
        ),
        "experiment": scenario_table(table, "paper-experiment", f"Section VI, simulated: {spread}"),
        "stress": stress_table(table, _STRESS_CASES),
        "times": times_table(timings, table.laws),
    }


def _seeds(table: FigureTable) -> str:
    seeds = sorted({row.seed for row in table})
    return f"seed {seeds[0]}" if len(seeds) == 1 else f"seeds {seeds[0]} to {seeds[-1]}"


def _scenarios(campaign: Campaign) -> list[dict[str, str | int]]:
    """Name, title, seeds and hash of every scenario, for the record."""
    titles, table = preset_titles(), campaign.table
    return [
        {
            "name": name,
            "title": titles.get(name, ""),
            "seeds": len(table.case(name, table.laws[0])),
            "hash": campaign.runs[name, table.laws[0]].provenance.get("scenario_hash", ""),
        }
        for name in table.scenarios
    ]


def _is_panel(name: str, number: int) -> bool:
    return name.startswith(f"fig{number}") and not name.endswith("_sheet")


def _picture(path: Path) -> str:
    """An SVG file as the address of an image, so that the page needs no other file."""
    return "data:image/svg+xml;base64," + base64.b64encode(path.read_bytes()).decode("ascii")


def _slug(verdict: Verdict) -> str:
    return {Verdict.HOLDS: "holds", Verdict.IN_PART: "part", Verdict.FAILS: "fails"}[verdict]
