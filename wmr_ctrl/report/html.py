"""The report as one page that needs nothing but itself."""

from __future__ import annotations

import base64
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined

from wmr_ctrl.campaign import Campaign, Table
from wmr_ctrl.report.citation import CITATION
from wmr_ctrl.report.claims import Judged, Verdict
from wmr_ctrl.report.claims.judge import RULE
from wmr_ctrl.report.drawing import Drawing
from wmr_ctrl.report.extras import HIDDEN, STRESS
from wmr_ctrl.report.ledger_section import ledger_section
from wmr_ctrl.report.tables import scenario_table, stress_table, times_table
from wmr_ctrl.report.wording import shown
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
    """All that goes into the report: what was found, the figures, and facts from the caller.

    ``ours`` is the content of the section past the paper, if there is one.
    """

    campaign: Campaign
    judged: Sequence[Judged]
    drawings: Sequence[Drawing]
    figures: Path
    readings: Sequence[Mapping[str, Any]]
    facts: Mapping[str, Any]
    ours: Mapping[str, Any] | None = None


def write_report(path: Path, page: Page) -> None:
    """Render the page into one file; pictures are taken from the SVG files of ``page.figures``."""
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


def _content(page: Page) -> dict[str, Any]:
    table, facts = page.campaign.table, page.facts
    pictures = {drawing.name: drawing for drawing in page.drawings}
    return {
        "citation": CITATION,
        "rule": RULE,
        "judged": page.judged,
        "counts": [(v, sum(1 for one in page.judged if one.verdict == v)) for v in Verdict],
        "changed": [one for one in page.judged if not one.as_expected],
        "seeds": _seeds(table),
        "runs": len(table),
        "picture": lambda name: _picture(page.figures / f"{name}.svg"),
        "drawings": pictures,
        "panels": {n: [d for d in page.drawings if _is_panel(d.name, n)] for n in (3, 5)},
        "hidden": [pictures[name] for name in HIDDEN],
        "stress": [pictures[name] for name in STRESS],
        "tables": _tables(table, facts),
        "readings": page.readings,
        "fields": facts.get("readings", ()),
        "titles": facts.get("titles", {}),
        "versions": facts.get("versions", {}),
        "scenarios": _scenarios(page.campaign),
        "ours": page.ours,
        "ledger": ledger_section(facts.get("stale")),
    }


def _tables(table: Table, facts: Mapping[str, Any]) -> dict[str, Any]:
    spread = "median (least … greatest) over the seeds"
    return {
        "simulation": scenario_table(table, "paper-simulation", f"Section V: {spread}"),
        "control": scenario_table(
            table, "paper-simulation-no-switch", f"The same without the change at 40 s: {spread}"
        ),
        "experiment": scenario_table(table, "paper-experiment", f"Section VI, simulated: {spread}"),
        "stress": stress_table(table, _STRESS_CASES),
        "times": times_table(facts.get("timings") or {}, table.laws),
    }


def _seeds(table: Table) -> str:
    seeds = sorted({row.seed for row in table})
    return f"seed {seeds[0]}" if len(seeds) == 1 else f"seeds {seeds[0]} to {seeds[-1]}"


def _scenarios(campaign: Campaign) -> list[dict[str, Any]]:
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
