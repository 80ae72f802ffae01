"""The report as one page that needs nothing but itself."""

from __future__ import annotations

import tomllib
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path

from jinja2 import Environment
from jinja2.runtime import LoopContext

from wmr_ctrl.campaign import BARRIER_LAWS, STUDIES, Campaign, FigureTable
from wmr_ctrl.proofs.ledger import Entry, load
from wmr_ctrl.report.claims import RULE, Verdict
from wmr_ctrl.report.data_files import CITATION
from wmr_ctrl.report.drawing import Drawing
from wmr_ctrl.report.guarantee_figures import STRESS
from wmr_ctrl.report.guard_section import GuardSection
from wmr_ctrl.report.measure_figures import HIDDEN
from wmr_ctrl.report.paper_figures import switch_time
from wmr_ctrl.report.reproduction import Reproduction
from wmr_ctrl.report.rigid_section import RigidSection
from wmr_ctrl.report.style import ABSENT, shown
from wmr_ctrl.report.tables import TextTable, scenario_table, stress_table, times_table
from wmr_ctrl.report.web import page_environment, picture
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
_STATED_CASES = {
    "as-stated": "the paper’s start, a sample every 0.1 ms",
    "as-stated-fast-start": "a start at 0.99 of both limits, 0.1 ms",
    "as-stated-far-start": "the far start, 0.1 ms",
    "as-stated-farther-start": "a start 22 m away, 0.1 ms",
    "farther-start-1ms": "the same start, a sample every 1 ms",
}
_SIGNS = {
    Verdict.HOLDS: "✓",
    Verdict.UNBROKEN: "○",
    Verdict.IN_PART: "◐",
    Verdict.FAILS: "✗",
    Verdict.STAND_IN: "✓",
    Verdict.STAND_IN_PART: "◐",
    Verdict.STAND_IN_FAILS: "✗",
}
_SLUGS = {
    Verdict.HOLDS: "holds",
    Verdict.UNBROKEN: "unbroken",
    Verdict.IN_PART: "part",
    Verdict.FAILS: "fails",
}
_ALWAYS_COUNTED = (Verdict.HOLDS, Verdict.IN_PART, Verdict.FAILS)


@dataclass(frozen=True, slots=True)
class PagePart:
    """A part of the page: its address, its title, and what the navigation calls it."""

    id: str
    title: str
    short: str


_SECTIONS = (
    PagePart("verdicts", "What holds, what does not", "Verdicts"),
    PagePart("simulation", "Section V: the simulation", "Section V"),
    PagePart("experiment", "Section VI: the experiment, simulated", "Section VI"),
    PagePart("measure", "What the paper’s measure hides", "What the measure hides"),
    PagePart("guarantee", "Where the guarantee ends", "Where the guarantee ends"),
    PagePart("ours", "Past the paper: the guard and our law", "Past the paper"),
    PagePart("rigid", "On tyres: the robot as a rigid body", "On tyres"),
    PagePart("ledger", "The mathematics, checked by machine", "Proofs"),
    PagePart("readings", "What was read into the paper", "Readings"),
    PagePart("made", "How it was made", "How it was made"),
    PagePart("evidence", "Appendix A. Evidence, claim by claim", "A. Evidence"),
    PagePart("tables", "Appendix B. All figures", "B. All figures"),
    PagePart("ledger-tables", "Appendix C. What is refuted, what is open", "C. Refuted and open"),
)


@dataclass(frozen=True)
class Page:
    """All that goes into the page; pictures are the SVG files of the folder ``figures``.

    ``guard`` is the content of the section past the paper, ``rigid`` that of the section on the
    rigid body; None where that was not run.
    """

    reproduction: Reproduction
    drawings: Sequence[Drawing]
    figures: Path
    guard: GuardSection | None = None
    rigid: RigidSection | None = None


@dataclass(frozen=True, slots=True)
class LedgerSection:
    """What the page shows of the committed proof ledger; ``stale`` as in `Facts`."""

    tally: tuple[tuple[str, int], ...]
    refuted: tuple[Entry, ...]
    unproved: tuple[Entry, ...]
    stale: Sequence[str] | None


def write_page(path: Path, page: Page) -> None:
    """Render the page into one file, whole or not at all."""
    text = report_environment().get_template("report.html.j2").render(_content(page))
    with atomic_write(path, text=True) as file:
        file.write(text)


def report_environment() -> Environment:
    """The templates with the report's filters."""
    environment = page_environment()
    environment.filters.update(
        shown=shown, thousandths=_thousandths, comma=_comma, sign=_SIGNS.__getitem__, slug=_slug
    )
    return environment


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
    counted = Counter(one.verdict for one in judged)
    return {
        "citation": CITATION,
        "rule": RULE,
        "judged": judged,
        "counts": [(v, counted[v]) for v in Verdict if counted[v] or v in _ALWAYS_COUNTED],
        "changed": [one for one in judged if not one.as_expected],
        "seeds": _seeds(table),
        "runs": len(table),
        "picture": lambda name: picture(page.figures / f"{name}.svg"),
        "panels": {n: [d for d in page.drawings if _is_panel(d.name, n)] for n in (3, 5)},
        "hidden": [pictures[name] for name in HIDDEN],
        "stress": [pictures[name] for name in STRESS],
        "tables": _tables(campaign, facts.timings),
        "readings": load_readings(),
        "rounds": facts.rounds,
        "titles": facts.titles,
        "versions": facts.versions,
        "scenarios": _scenarios(campaign),
        "guard": page.guard,
        "rigid": page.rigid,
        "ledger": ledger_section(facts.stale),
        "sections": {one.id: one for one in _SECTIONS if one.id not in _absent(page)},
    }


def _absent(page: Page) -> set[str]:
    """Addresses of the parts that were not run."""
    wanted = {"ours": page.guard, "rigid": page.rigid}
    return {name for name, section in wanted.items() if section is None}


def _tables(campaign: Campaign, timings: Mapping[str, float]) -> dict[str, TextTable]:
    table, spread = campaign.table, "median (least … greatest) over the seeds"
    whole = {
        "simulation": ("paper-simulation", f"Section V: {spread}"),
        "control": (
            "paper-simulation-no-switch",
            f"Section V without the change at 40 s: {spread}",
        ),
        "experiment": ("paper-experiment", f"Section VI, simulated: {spread}"),
    }
    scenario_tables = {
        f"{key}{'_short' if short else ''}": scenario_table(
            table,
            scenario,
            caption,
            changes=switch_time(campaign.runs[scenario, table.laws[0]]) is not None,
            short=short,
        )
        for key, (scenario, caption) in whole.items()
        for short in (False, True)
    }
    return {
        **scenario_tables,
        "stated": stress_table(table, _STATED_CASES, BARRIER_LAWS),
        "stress": stress_table(table, _STRESS_CASES),
        "times": times_table(timings, table.laws),
    }


def _seeds(table: FigureTable) -> str:
    seeds = sorted({row.seed for row in table})
    return f"seed {seeds[0]}" if len(seeds) == 1 else f"seeds {seeds[0]} to {seeds[-1]}"


def _scenarios(campaign: Campaign) -> list[dict[str, str | int]]:
    """Name, title, seeds and hash of every scenario, for the record."""
    titles, table = preset_titles(), campaign.table
    own = {study.scenario: study.title for study in STUDIES if study.title}
    first = dict(reversed(table.cases))
    return [
        {
            "name": name,
            "title": own.get(name) or titles.get(name, ""),
            "seeds": len(table.case(name, first[name])),
            "hash": campaign.runs[name, first[name]].provenance.get("scenario_hash", ""),
        }
        for name in table.scenarios()
    ]


def _is_panel(name: str, number: int) -> bool:
    return name.startswith(f"fig{number}") and not name.endswith("_sheet")


def _slug(verdict: Verdict) -> str:
    return _SLUGS.get(verdict, "stand-in")


def _thousandths(value: float | None) -> str:
    return ABSENT if value is None else shown(1e3 * value, 2)


def _comma(loop: LoopContext) -> str:
    """What follows an item of a list within a sentence."""
    return "" if loop.last else " and " if loop.revindex == 2 else ", "
