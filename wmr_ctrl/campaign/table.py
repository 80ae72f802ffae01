"""The rows of a campaign, by scenario, law and seed."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from wmr_ctrl.campaign.figures import figure_named
from wmr_ctrl.campaign.rows import Row
from wmr_ctrl.campaign.statistics import Spread, spread
from wmr_ctrl.errors import UnknownNameError


class Table:
    """Rows in the order in which they were planned, and how to look numbers up in them."""

    def __init__(self, rows: Iterable[Row]) -> None:
        self.rows = tuple(rows)
        self._cases: dict[tuple[str, str], tuple[Row, ...]] = {}
        for row in self.rows:
            key = (row.scenario, row.law)
            self._cases[key] = (*self._cases.get(key, ()), row)

    @property
    def cases(self) -> tuple[tuple[str, str], ...]:
        """Every pair of scenario and law, in order."""
        return tuple(self._cases)

    @property
    def scenarios(self) -> tuple[str, ...]:
        """Names of the scenarios, in order."""
        return tuple(dict.fromkeys(scenario for scenario, _ in self._cases))

    @property
    def laws(self) -> tuple[str, ...]:
        """Names of the laws, in order."""
        return tuple(dict.fromkeys(law for _, law in self._cases))

    def case(self, scenario: str, law: str) -> tuple[Row, ...]:
        """The rows of a scenario and law, one per seed; raises UnknownNameError without any."""
        try:
            return self._cases[scenario, law]
        except KeyError:
            known = (f"{one} with {other}" for one, other in self._cases)
            raise UnknownNameError("case", f"{scenario} with {law}", known) from None

    def values(self, figure: str, scenario: str, law: str) -> dict[int, float | None]:
        """A figure by seed; raises UnknownNameError for names that are not there."""
        name = figure_named(figure).name
        return {row.seed: row.values[name] for row in self.case(scenario, law)}

    def spread(self, figure: str, scenario: str, law: str) -> Spread:
        """The spread of a figure over the seeds."""
        return spread(self.values(figure, scenario, law).values())

    def __iter__(self) -> Iterator[Row]:
        return iter(self.rows)

    def __len__(self) -> int:
        return len(self.rows)
