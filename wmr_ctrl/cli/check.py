"""``wmr-ctrl check``: validity, what theory says against a scenario, and what one run shows."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import click

from wmr_ctrl.cli.console import print_json, say, wrapped
from wmr_ctrl.cli.options import debug_option, guard_option, json_option, load, set_option
from wmr_ctrl.errors import CompilerError

if TYPE_CHECKING:
    from wmr_ctrl.checks import Warning
    from wmr_ctrl.results import Run
    from wmr_ctrl.scenario import Scenario

    Warned = Mapping[str, Sequence[Warning]]
    Runs = Mapping[str, Run]


@click.command(short_help="Validate a scenario, and say what to expect of it.")
@click.argument("scenario")
@click.option(
    "--law",
    "chosen",
    metavar="NAME",
    multiple=True,
    help="Ask about this law only. May be given several times.  [default: all]",
)
@guard_option
@set_option
@json_option("Print validity, longest stable periods, warnings and nominal runs as JSON.")
@debug_option
def check(
    scenario: str,
    chosen: tuple[str, ...],
    guard: bool | None,
    assignments: tuple[str, ...],
    as_json: bool,
) -> None:
    """Validate a scenario, and say what theory and one run of each law have against it.

    SCENARIO is the name of a preset or a TOML file. Each law is run once, with seed 0. The exit
    code is 0 if the scenario is valid, whatever the warnings, and 2 if it is not.
    """
    from wmr_ctrl.checks import largest_stable_period, warnings_for
    from wmr_ctrl.control.setup import settle
    from wmr_ctrl.laws import LAWS

    case = load(scenario, assignments, guard)
    warned = {law: warnings_for(settle(case, law)) for law in chosen or LAWS}
    periods = {law: largest_stable_period(case, law) for law in warned}
    runs = _runs(case, warned)
    if as_json:
        print_json(_document(case, warned, periods, runs))
    else:
        click.echo("\n".join(_lines(case, warned, periods, runs)))


def _runs(scenario: Scenario, laws: Iterable[str]) -> dict[str, Run]:
    """One run of each law; none where no compiler works, and stderr says so."""
    from wmr_ctrl import api

    try:
        return {law: api.simulate(scenario, law) for law in laws}
    except CompilerError as error:
        say("warning", f"no law was run: {error}")
        return {}


def _document(
    scenario: Scenario, warned: Warned, periods: Mapping[str, float], runs: Runs
) -> dict[str, Any]:
    laws = {
        law: {
            "largest_stable_period": periods[law],
            "warnings": [asdict(warning) for warning in warnings],
        }
        for law, warnings in warned.items()
    }
    return {
        "scenario": scenario.name,
        "valid": True,
        "warnings": list(_merged(warned)),
        "nominal": {law: _nominal(run) for law, run in runs.items()},
        "max_period": dict(periods),
        "laws": laws,
    }


def _merged(warned: Warned) -> Iterator[dict[str, str | None]]:
    """Every warning once: without a law where it concerns all of several."""
    shared = _shared(warned)
    for warning in shared:
        yield {"key": warning.key, "law": None, "text": str(warning)}
    for law, warnings in warned.items():
        for warning in warnings:
            if warning not in shared:
                yield {"key": warning.key, "law": law, "text": str(warning)}


def _nominal(run: Run) -> dict[str, Any]:
    from wmr_ctrl.results import summary

    figures = summary(run)
    keys = ("position_rms", "tracked", "guard_share", "outcome", "remarks")
    return {key: figures[key] for key in keys}


def _lines(
    scenario: Scenario, warned: Warned, periods: Mapping[str, float], runs: Runs
) -> list[str]:
    title = f" ({scenario.title})" if scenario.title else ""
    lines = [wrapped(f"{scenario.name} is valid{title}.")]
    shared = _shared(warned)
    if shared:
        lines += ["", "all laws", *(_item(str(warning)) for warning in shared)]
    for law, warnings in warned.items():
        own = [str(warning) for warning in warnings if warning not in shared]
        lines += ["", f"{law}, {_stable(periods[law])}", *_of_law(own, runs.get(law))]
    return lines


def _of_law(warnings: Sequence[str], run: Run | None) -> list[str]:
    """What is said of one law: theory's objections, then what its run showed."""
    seen = [f"{item.key}: {item.text}" for item in run.remarks] if run else []
    lines = [_item(text) for text in (*warnings, *seen)] or ["  - no objection"]
    return [*lines, _item(_sight(run))] if run else lines


def _sight(run: Run) -> str:
    """What one run showed, in a sentence."""
    from wmr_ctrl.results import guard_share, position_rms, tracked

    late, shares = position_rms(run)["last_quarter"], guard_share(run)
    away = "it ended early" if late is None else f"{late:.3g} m RMS from its place at the end"
    verdict = "tracked" if tracked(run) else "not tracked"
    held = ""
    if run.guard and shares is not None:
        held = ", the guard changed {:.2g} % of the thrusts and {:.2g} % of the moments".format(
            *(100 * share for share in shares)
        )
    return f"run once with seed 0: {run.outcome.value}, {verdict}, {away}{held}"


def _shared(warned: Warned) -> list[Warning]:
    """Warnings that all of several laws get."""
    if len(warned) < 2:
        return []
    first = next(iter(warned.values()))
    return [item for item in first if all(item in warnings for warnings in warned.values())]


def _item(text: str) -> str:
    return wrapped(f"- {text}", indent="  ", hang="  ")


def _stable(period: float) -> str:
    if period == 0:
        return "stable around the reference at no control period"
    if period == float("inf"):
        return "stable around the reference at every control period that was tried"
    return f"stable around the reference up to clock.control = {period:.4g} s"
