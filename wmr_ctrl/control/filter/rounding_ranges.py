"""Ranges of numbers for which the filter's margin provably covers its rounding errors."""

from collections.abc import Iterator

from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.world.scenario import Scenario

from .governor import Schedule
from .governor_step import schedules

OLDEST = 60.0
"""Largest age of odometry, over the least time constant."""
SHORTEST = 2.0**-13
"""Least period for each piece of time that it is cut into, over the largest time constant."""
SHORTEST_SINGLE = 2.0**-8
"""Least such period in single precision; shorter ones are refused."""


def unproved_roundings(scenario: Scenario) -> Iterator[tuple[str, str]]:
    """Key and sentence for each number outside the proved range of the rounding margin.

    The ranges are those of `filter.rounding.governor`; every scenario satisfies its other
    hypotheses.
    """
    if scenario.filter.kind != "governor":
        return
    for key, number, bound in dict.fromkeys(_of_long_times(scenario)):
        yield (
            key,
            f"{number} is beyond {bound}: up to there the share of the limit that the filter "
            "keeps back is proved to cover its roundings; beyond, the limit is proved for exact "
            "arithmetic only.",
        )


def _of_long_times(scenario: Scenario) -> Iterator[tuple[str, str, str]]:
    settings, T = scenario.filter, scenario.clock.control
    if (jitter := settings.jitter) > T / 2:
        yield (
            "filter.jitter",
            f"filter.jitter = {jitter:g} s",
            f"half of clock.control, {T / 2:g} s",
        )
    for axis, plan in enumerate(schedules(scenario)):
        fastest, slowest = settings.intervals("tau")[axis]
        if settings.age > (most := OLDEST * fastest):
            bound = f"{OLDEST:g} {settings.place('tau', axis, 1)}, {most:g} s"
            yield "filter.age", f"filter.age = {settings.age:g} s", bound
        if (pieces := _most_pieces(plan)) * SHORTEST * slowest > T:
            bound = (
                f"clock.control 2^13/{pieces}, {T / pieces / SHORTEST:g} s, {pieces} being the "
                "pieces into which changes of the acting command divide a period"
            )
            yield "filter.tau", f"{settings.place('tau', axis, 2)} = {slowest:g} s", bound


def check_single_precision(scenario: Scenario) -> None:
    """Raise ScenarioError for a governor whose bounds rise by less than a float's rounding."""
    settings, T = scenario.filter, scenario.clock.control
    if settings.is_told:
        raise ScenarioError(
            "filter.changing, filter.free_error and filter.rest need double precision: there "
            "is no bound on how single precision's roundings lengthen a stop. Write the package "
            "without --float32."
        )
    for axis, plan in enumerate(schedules(scenario)):
        _, slowest = settings.intervals("tau")[axis]
        longest = T / (SHORTEST_SINGLE * _most_pieces(plan))
        if slowest > longest:
            raise ScenarioError(
                f"{settings.place('tau', axis, 2)} = {slowest:g} s is beyond {longest:.4g} s, the "
                "longest time constant of a governor in single precision at clock.control = "
                f"{T:g} s: what the base gains in a period gets lost in a float's rounding. Write "
                "the package in double precision, or lengthen clock.control."
            )


def _most_pieces(plan: Schedule) -> int:
    """Largest number of pieces in a sample, before the latest takeover, or in a period before
    it.
    """
    back = plan.pieces(-plan.age, 0.0, 1)
    ahead = plan.pieces(0.0, 1 + plan.jitter, 0, 1 - plan.jitter)
    taken = plan.pieces(0.0, plan.delay[1], 1, plan.delay[0])
    looked = (sum(b.start < a.start + 1 and b.end > a.start for b in back) for a in back)
    return max(len(ahead), len(taken), *looked)
