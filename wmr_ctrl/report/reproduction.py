"""What a report is made of, and what writing it hands back."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from wmr_ctrl.campaign import Campaign, FigureTable
from wmr_ctrl.report.claims import Judged, Verdict


@dataclass(frozen=True, slots=True)
class Facts:
    """What stands in a report beside the runs' numbers.

    ``titles``: law -> text; ``timings``: law -> s per 10,000 evaluations, the least of ``rounds``,
    empty where they were not taken; ``versions``: name -> text; ``stale``: ids of the proof ledger
    whose graph has changed since, None where that was not compared.
    """

    titles: Mapping[str, str] = field(default_factory=dict)
    timings: Mapping[str, float] = field(default_factory=dict)
    rounds: int = 0
    versions: Mapping[str, str] = field(default_factory=dict)
    stale: Sequence[str] | None = None


@dataclass(frozen=True)
class Reproduction:
    """Finished runs, the verdicts that follow from them, and facts: all that a report shows.

    ``comparison`` is the one past the paper, ``rigid`` that with the rigid body; without rows where
    they were not run.
    """

    campaign: Campaign
    judged: tuple[Judged, ...]
    facts: Facts = field(default_factory=Facts)
    comparison: FigureTable = field(default_factory=FigureTable)
    rigid: Campaign = field(default_factory=Campaign)


@dataclass(frozen=True)
class Verdicts:
    """The verdict on every claim, the table behind them, and the files that were written."""

    judged: tuple[Judged, ...]
    table: FigureTable
    folder: Path
    files: tuple[Path, ...]

    @property
    def changed(self) -> tuple[Judged, ...]:
        """Claims whose verdict is not the committed one."""
        return tuple(one for one in self.judged if not one.as_expected)

    @property
    def as_expected(self) -> bool:
        """Whether every verdict is the committed one."""
        return not self.changed

    @property
    def ok(self) -> bool:
        """Short for :attr:`as_expected`."""
        return self.as_expected

    @property
    def report(self) -> Path:
        """The page to open."""
        return self.folder / "report.html"

    def count(self, verdict: Verdict) -> int:
        """Number of claims with this verdict."""
        return sum(1 for one in self.judged if one.verdict == verdict)

    def __str__(self) -> str:
        """One line per claim, then a summary; lines on changed verdicts if there are any."""
        wide = max((len(one.verdict.value) for one in self.judged), default=0)
        lines = [
            f"{one.verdict.value:<{wide}} {one.claim.section:<18} {one.claim.title}"
            for one in self.judged
        ]
        counts = ", ".join(f"{self.count(v)} {v.value}" for v in Verdict if self.count(v))
        changed = [
            f"CHANGED: {one.claim.id} is {one.verdict.value}, committed is {one.claim.expected}."
            for one in self.changed
        ]
        return "\n".join((*lines, "", f"{len(self.judged)} claims: {counts}.", *changed))
