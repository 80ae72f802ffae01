"""The report as one self-contained page; its texts are in the templates."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

from jinja2 import Environment

from wmr_ctrl.core.paper import CITATION, PAPER_TIMES
from wmr_ctrl.results.ledger import load
from wmr_ctrl.results.windows import BEFORE, LATE, seconds
from wmr_ctrl.simulation.campaign import Campaign
from wmr_ctrl.simulation.campaign.paper_runs import BARRIER_LAWS, STUDIES
from wmr_ctrl.world.scenario import preset_titles

from .drawing import Drawing, write_html
from .paper_claims import RULE, Judged, Verdict, load_readings
from .style import page_environment, picture, shown
from .tables import headed, ranged, scenario_table, stress_table

_ALWAYS_COUNTED = (Verdict.HOLDS, Verdict.IN_PART, Verdict.FAILS)


@dataclass(frozen=True)
class Facts:
    """Contents of a report besides the runs' numbers.

    ``titles``: law -> text; ``timings``: law -> s per 10,000 evaluations, the least of ``rounds``,
    empty if not measured; ``versions``: name -> text; ``stale``: ids of the proof ledger whose
    graph has changed since, None if not compared.
    """

    titles: Mapping[str, str] = field(default_factory=dict)
    timings: Mapping[str, float] = field(default_factory=dict)
    rounds: int = 0
    versions: Mapping[str, str] = field(default_factory=dict)
    stale: Sequence[str] | None = None


@dataclass(frozen=True)
class Reproduction:
    """Content of a report: finished runs, the resulting verdicts, and facts."""

    campaign: Campaign
    judged: tuple[Judged, ...]
    facts: Facts = field(default_factory=Facts)


def write_page(
    path: Path, reproduction: Reproduction, drawings: Sequence[Drawing], figures: Path
) -> None:
    """Render the page into one file, atomically.

    Pictures are the SVG files of the folder ``figures``; among ``drawings`` those with a title are
    panels of Fig. 3 and Fig. 5.
    """
    campaign, judged, facts = reproduction.campaign, reproduction.judged, reproduction.facts
    count = Counter(one.verdict for one in judged)
    write_html(
        path, "report.html.j2", report_environment(),
        citation=CITATION, rule=RULE, judged=judged, facts=facts, table=campaign.table,
        counts=[(v, count[v]) for v in Verdict if count[v] or v in _ALWAYS_COUNTED],
        changed=[one for one in judged if not one.as_expected],
        picture=lambda name: picture((figures / f"{name}.svg").read_text("utf-8")),
        panels=[one for one in drawings if one.title],
        figures_of=partial(scenario_table, campaign),
        stress=partial(stress_table, campaign.table),
        barrier_laws=BARRIER_LAWS, paper_times=PAPER_TIMES, readings=load_readings(),
        scenarios=_scenarios(campaign),
        ledger=load(),
    )  # fmt: skip


def report_environment() -> Environment:
    """The templates with the report's filters."""
    environment = page_environment()
    environment.globals |= {"before": seconds(*BEFORE), "late": seconds(*LATE)}
    environment.filters |= {"headed": headed, "ranged": ranged}
    environment.filters["thousandths"] = lambda value: shown(value and 1e3 * value, 2)
    return environment


def _scenarios(campaign: Campaign) -> list[dict[str, str | int]]:
    """Name, title, seeds and hash of every scenario, for the record."""
    table = campaign.table
    titles = {**preset_titles(), **{one.label: one.title for one in STUDIES if one.title}}
    first = dict(reversed(table.cases))
    return [
        {
            "name": name,
            "title": titles.get(name, ""),
            "seeds": table.case(name, first[name]).rows,
            "hash": campaign.runs[name, first[name]].provenance.get("scenario_hash", ""),
        }
        for name in table.different("case")
    ]
