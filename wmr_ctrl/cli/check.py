"""``wmr-ctrl check``: a scenario's validity, and what theory says against running it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import click

from wmr_ctrl.cli.console import print_json, wrapped
from wmr_ctrl.cli.options import debug_option, guard_option, json_option, load, set_option

if TYPE_CHECKING:
    from wmr_ctrl.checks import Warning
    from wmr_ctrl.scenario import Scenario

    Warned = Mapping[str, Sequence[Warning]]


@click.command(short_help="Validate a scenario without running it.")
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
@json_option("Print validity, longest stable periods and warnings as one JSON document.")
@debug_option
def check(
    scenario: str,
    chosen: tuple[str, ...],
    guard: bool | None,
    assignments: tuple[str, ...],
    as_json: bool,
) -> None:
    """Validate a scenario without running it, and say what theory has against it.

    SCENARIO is the name of a preset or a TOML file. The exit code is 0 if it is valid, whatever
    the warnings, and 2 if it is not.
    """
    from wmr_ctrl.checks import largest_stable_period, warnings_for
    from wmr_ctrl.control.setup import settle
    from wmr_ctrl.laws import LAWS

    case = load(scenario, assignments, guard)
    warned = {law: warnings_for(settle(case, law)) for law in chosen or LAWS}
    periods = {law: largest_stable_period(case, law) for law in warned}
    if as_json:
        print_json(_document(case, warned, periods))
    else:
        click.echo("\n".join(_lines(case, warned, periods)))


def _document(scenario: Scenario, warned: Warned, periods: Mapping[str, float]) -> dict[str, Any]:
    laws = {
        law: {
            "largest_stable_period": periods[law],
            "warnings": [asdict(warning) for warning in warnings],
        }
        for law, warnings in warned.items()
    }
    return {"scenario": scenario.name, "valid": True, "laws": laws}


def _lines(scenario: Scenario, warned: Warned, periods: Mapping[str, float]) -> list[str]:
    title = f" ({scenario.title})" if scenario.title else ""
    lines = [wrapped(f"{scenario.name} is valid{title}.")]
    shared = [warning for warning in next(iter(warned.values())) if _in_all(warning, warned)]
    if len(warned) > 1 and shared:
        lines += ["", "all laws", *(_item(warning) for warning in shared)]
    for law, warnings in warned.items():
        own = [warning for warning in warnings if len(warned) == 1 or warning not in shared]
        lines += ["", f"{law}, {_stable(periods[law])}"]
        lines += [_item(warning) for warning in own] or ["  - no objection"]
    return lines


def _in_all(warning: Warning, warned: Warned) -> bool:
    return all(warning in warnings for warnings in warned.values())


def _item(warning: Warning) -> str:
    return wrapped(f"- {warning}", indent="  ", hang="  ")


def _stable(period: float) -> str:
    if period == 0:
        return "stable around the reference at no control period"
    if period == float("inf"):
        return "stable around the reference at every control period that was tried"
    return f"stable around the reference up to clock.control = {period:.4g} s"
