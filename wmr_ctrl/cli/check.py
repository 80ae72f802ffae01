"""``wmr-ctrl check``: validity, what theory says against a scenario, and what one run shows."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, replace
from typing import TYPE_CHECKING, Any

import click

from wmr_ctrl.cli.check_limits import filter_lines, filter_numbers, guard_lines, guard_numbers
from wmr_ctrl.cli.console import print_json, say, wrapped
from wmr_ctrl.cli.options import debug_option, guard_option, json_option, load, set_option
from wmr_ctrl.cli.progress import Progress
from wmr_ctrl.errors import CompilerError

if TYPE_CHECKING:
    from wmr_ctrl.checks import Stability, Warning
    from wmr_ctrl.control.setup import Setup
    from wmr_ctrl.corridor import Corridor
    from wmr_ctrl.results import Run
    from wmr_ctrl.scenario import Scenario
    from wmr_ctrl.scenario.toml_io import InheritedValue

    Warned = Mapping[str, Sequence[Warning]]
    Runs = Mapping[str, Run]
    Tubes = Mapping[str, Corridor]
    Taken = Sequence[InheritedValue]

NOT_LINEAR = "on a base that takes velocities, where stability is not worked out"
MOST_STEPS = 2_000_000
"""Plant steps that one law is run for; twenty times what the paper's runs take."""


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
@json_option("Print validity, stable periods, corridors, warnings and nominal runs as JSON.")
@debug_option
def check(
    scenario: str,
    chosen: tuple[str, ...],
    guard: bool | None,
    assignments: tuple[str, ...],
    as_json: bool,
) -> None:
    """Validate a scenario, and say what theory and one run of each law have against it.

    SCENARIO is the name of a preset or a TOML file. Each law is run once, with seed 0, and for
    two million plant steps at most; how far off its path it can be pushed is certified. The exit
    code is 0 if the scenario is valid, whatever the warnings, and 2 if it is not.
    """
    from wmr_ctrl.checks import grip_warnings, stability, warnings_for
    from wmr_ctrl.control.setup import settle
    from wmr_ctrl.corridor import find_corridor
    from wmr_ctrl.laws import LAWS
    from wmr_ctrl.scenario import inherited, parse_assignments

    case = load(scenario, assignments, guard)
    taken = inherited(case, scenario, parse_assignments(assignments))
    names = chosen or tuple(LAWS)
    with Progress("what theory says") as progress:
        warned, stable, tubes, first = {}, {}, {}, settle(case, names[0])
        for count, law in enumerate(names):
            progress(count / len(names))
            setup = settle(case, law)
            grip = (replace(item, objects=False) for item in grip_warnings(setup))
            warned[law] = (*warnings_for(setup), *grip)
            tubes[law] = find_corridor(case, law)
            if not first.takes_velocity:
                stable[law] = stability(case, law)
        runs = _runs(case, warned, progress)
    if as_json:
        limited = {"guard": guard_numbers(first), "filter": filter_numbers(first)}
        shown = {"corridor": {law: tube.figures for law, tube in tubes.items()}}
        print_json({**_document(case, warned, stable, runs, taken), **limited, **shown})
    else:
        lines = *_head(case, first, taken), *_lines(case, warned, stable, runs, tubes)
        click.echo("\n".join(lines))


def _short(scenario: Scenario) -> Scenario:
    """The scenario, which ends after `MOST_STEPS` plant steps if it would not end before."""
    from wmr_ctrl.scenario import override

    clock, window = scenario.clock, scenario.metrics
    if clock.duration <= MOST_STEPS * clock.plant:
        return scenario
    end = int(MOST_STEPS * clock.plant / clock.control) * clock.control
    split = {} if window.split is None else {"metrics.split": min(window.split, end / 2)}
    first = {"metrics.rms_from": min(window.rms_from, end / 2)}
    return override(scenario, {"clock.duration": end, **split, **first})


def _runs(scenario: Scenario, laws: Mapping[str, object], progress: Progress) -> dict[str, Run]:
    """One run of each law; none where no compiler works, and stderr says so."""
    from wmr_ctrl import api

    runs = {}
    progress.start(len(laws), "one run of each law")
    try:
        short = _short(scenario)
        for law in laws:
            runs[law] = api.simulate(short, law)
            progress.advance()
        return runs
    except CompilerError as error:
        say("warning", f"no law was run: {error}")
        return {}


def _document(
    scenario: Scenario, warned: Warned, stable: Mapping[str, Stability], runs: Runs, taken: Taken
) -> dict[str, Any]:
    from wmr_ctrl.checks import reference_torque
    from wmr_ctrl.checks.outlook import verdict
    from wmr_ctrl.results import summary
    from wmr_ctrl.world.grip import grip

    shown = ("position_rms", "tracking", "tracked", "arrival", "guard_share", "outcome", "remarks")
    figures = {law: summary(run) for law, run in runs.items()}
    return {
        "scenario": scenario.name,
        "valid": True,
        "grip": {**asdict(grip(scenario)), "reference": reference_torque(scenario)},
        "warnings": [*_merged(warned), *_inherited_warning(taken)],
        "inherited": {item.key: item.value for item in taken},
        "nominal_duration": {law: run.settings.duration for law, run in runs.items()},
        "nominal": {law: {key: row[key] for key in shown} for law, row in figures.items()},
        "verdict": {law: verdict(theory, runs.get(law)) for law, theory in warned.items()},
        "min_period": {law: limits.shortest for law, limits in stable.items()},
        "max_period": {law: limits.period for law, limits in stable.items()},
        "max_delay": {law: limits.delay for law, limits in stable.items()},
        "mass_range": {law: limits.masses for law, limits in stable.items()},
        "arrival": scenario.reference.arrival,
        "laws": {
            law: {
                "largest_stable_period": stable[law].period if law in stable else None,
                "warnings": [asdict(warning) for warning in warnings],
            }
            for law, warnings in warned.items()
        },
    }


def _inherited_warning(taken: Taken) -> Iterator[dict[str, str | None]]:
    """The robot's numbers that were not stated, with where to state them."""
    if taken:
        listed = ", ".join(f"{item.key} = {item.value} {item.unit}".rstrip(" 1") for item in taken)
        text = (
            f"The file does not state {listed}: these are the paper's robot, or that of the preset "
            "which the file extends. State what is yours in its tables; `wmr-ctrl scenarios "
            "paper-simulation --toml` prints them with their meaning."
        )
        yield {"key": "inherited", "law": None, "text": text}


def _merged(warned: Warned) -> Iterator[dict[str, str | None]]:
    """Every warning once: without a law where it concerns all of several."""
    shared = _shared(warned)
    for warning in shared:
        yield {"key": warning.key, "law": None, "text": str(warning)}
    for law, warnings in warned.items():
        for warning in (item for item in warnings if item not in shared):
            yield {"key": warning.key, "law": law, "text": str(warning)}


def _shared(warned: Warned) -> list[Warning]:
    """Warnings that all of several laws get."""
    if len(warned) < 2:
        return []
    first = next(iter(warned.values()))
    return [item for item in first if all(item in warnings for warnings in warned.values())]


def _head(scenario: Scenario, setup: Setup, taken: Taken) -> list[str]:
    """Lines on the scenario, whatever the law."""
    title = f" ({scenario.title})" if scenario.title else ""
    lines = [wrapped(f"{scenario.name} is valid{title}.")]
    arrival, lasts = scenario.reference.arrival, scenario.clock.duration
    if arrival is not None:
        late = f"{arrival:.4g} s" if arrival < 3600 else f"{arrival:.0f} s, {arrival / 3600:.3g} h"
        early = f", but the run ends at {lasts:g} s: lengthen clock.duration"
        end = early if arrival > lasts else ""
        lines.append(wrapped(f"The desired motion comes to rest at its goal at t = {late}{end}."))
    inherited = [warning["text"] or "" for warning in _inherited_warning(taken)]
    return [*lines, *map(_item, (*guard_lines(setup), *filter_lines(setup), *inherited))]


def _lines(
    scenario: Scenario, warned: Warned, stable: Mapping[str, Stability], runs: Runs, tubes: Tubes
) -> list[str]:
    """Objections of theory and of one run to each law, and its corridor."""
    from wmr_ctrl.checks.surroundings import lost_poses, rounded_effects
    from wmr_ctrl.results import OBJECTED

    lines, shared = list[str](), _shared(warned)
    ignored = ", and ".join(filter(None, (lost_poses(scenario), rounded_effects(scenario))))
    rest = f" ({ignored})" if ignored else ""
    if any(run.settings.duration < scenario.clock.duration for run in runs.values()):
        short = f"Each law is run for {MOST_STEPS} plant steps alone, not to its end."
        lines += ["", wrapped(short)]
    if shared:
        lines += ["", "all laws", *(_item(_told(warning)) for warning in shared)]
    for law, warnings in warned.items():
        texts = [_told(warning) for warning in warnings if warning not in shared]
        if law in runs:
            seen = (item for item in runs[law].remarks if item.key != OBJECTED)
            texts += [f"{item.key}: {item.text}" for item in seen]
        periods = _stable(stable[law], scenario.clock.control) if law in stable else NOT_LINEAR
        said = wrapped(f"{law}, {periods}{rest}")
        lines += ["", said, *(map(_item, texts) if texts else ["  - no objection"])]
        sights = [_sight(runs[law])] if law in runs else []
        lines += map(_item, (*sights, tubes[law].sentence))
    return lines


def _told(warning: Warning) -> str:
    """A warning's text; of what is no objection, such as the grip of tyres, as a note."""
    return str(warning) if warning.objects else f"note: {warning}"


def _item(text: str) -> str:
    return wrapped(f"- {text}", indent="  ", hang="  ")


def _sight(run: Run) -> str:
    """One run in a sentence."""
    from wmr_ctrl.results import driving, percent, tracked
    from wmr_ctrl.results.measures import arrival, guard_share, tracking

    parts, shares, times = tracking(run), guard_share(run), arrival(run)
    away = " and ".join(
        f"{part['position_rms']:.3g} m RMS from its place in the {place}"
        for place, part in zip((driving(run), "end"), parts.values(), strict=True)
        if part is not None and part["position_rms"] is not None
    )
    away = away or ("it ended early" if run.monitor.stopped else "over before it could be judged")
    verdict = "tracked" if tracked(run) else "not tracked"
    held = ""
    if run.guard and shares is not None:
        thrusts, moments = map(percent, shares)
        held = f", the guard changed {thrusts} of the thrusts and {moments} of the moments"
    goal = f", at its goal from {times['robot']:.4g} s on" if times and times["robot"] else ""
    return f"run once with seed 0: {run.outcome.value}, {verdict}, {away}{goal}{held}"


def _stable(limits: Stability, period: float) -> str:
    if limits.period == 0:
        shorter = " and all shorter periods that were tried" if limits.tried < period else ""
        return f"unstable around the reference at {period:g} s{shorter}"
    limit = f"up to clock.control = {limits.period:.4g} s"
    if limits.shortest > 0:
        limit = f"for clock.control = {limits.shortest:.4g} to {limits.period:.4g} s"
    if limits.period == float("inf"):
        limit = "at every control period that was tried"
    parts = []
    if limits.delay is not None and limits.delay < float("inf"):
        parts.append(f"up to a delay of {limits.delay:.3g} s")
    if limits.masses is not None:
        parts.append(f"for a mass of {limits.mass_words}")
    here = f"; at {period:g} s {' and '.join(parts)}" if parts else ""
    return f"stable around the reference {limit}{here}"
