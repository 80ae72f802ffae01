"""A run's verdict and figures for people; a robot's drive as ``show`` and ``compare`` print it."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict
from itertools import chain, islice
from typing import Any

import click
import numpy as np

from wmr_ctrl import results
from wmr_ctrl.core.errors import ArgumentError
from wmr_ctrl.core.fields.units import sized
from wmr_ctrl.results import RigidMonitor, Run
from wmr_ctrl.results.drive import NEVER, RecordedDrive, drive_of
from wmr_ctrl.results.frames import FMUS
from wmr_ctrl.results.measures import heading_rms
from wmr_ctrl.theory.checks.outlook import scenario_of_run
from wmr_ctrl.theory.checks.unknown_zero import FINE, finest, promise_of_run

from .check_sentences import remedy
from .console import print_json, say, table, wrapped, write_file
from .options import check_output

UNITS = ("m", "m", "rad")
MISSING = "- (not reached)"
Row = tuple[str, str]
"""Name of a figure, and its value with what it means."""
TOO_FAST = ": TOO FAST"
MOST_ROWS = 8
"""Rows of the short answer."""


def summary_text(run: Run, verbose: bool = False) -> str:
    """Law, scenario and engine of a run, its verdict, and the figures that matter for its base.

    ``verbose``: remarks in full, what the guard relies on, and all figures.
    """
    guarded = ", guarded" if run.guard else ""
    rigid = "" if run.monitor.rigid is None else f", {run.settings.plant_kind} plant"
    head = [f"{run.law}{guarded} on {run.scenario}, seed {run.seed}, {run.engine} engine{rigid}"]
    head += map(wrapped, changes_of(run))
    labels = {name: run.provenance.get(f"fmu_{name}") for name in FMUS}
    if _theirs(run):
        labels["plant"] = f"{labels['plant']}; watched every {run.settings.plant:g} s"
    head += [wrapped(f"{name}: {label}", hang="  ") for name, label in labels.items() if label]
    warned = {name: run.provenance.get(f"warned_{name}") for name in FMUS}
    head += [
        wrapped(f"{name} warned in {said}", hang="  ") for name, said in warned.items() if said
    ]
    remarks = [wrapped(f"- {text}", hang="  ") for text in _unsaid(run, verbose)]
    exact = filter(None, (promise_of_run(run),))
    counted = _counted(run) if verbose else ()
    said = (wrapped(run.explanation), *map(wrapped, exact), *remarks, *counted)
    return "\n\n".join(("\n".join(head), "\n".join(said), table(rows_of(run, verbose))))


def rows_of(run: Run, verbose: bool = False) -> list[Row]:
    """The figures that matter for the base of a run, at most `MOST_ROWS`; or all."""
    figures = results.summary(run)
    shown = [*islice(_rows(run, figures), MOST_ROWS)]
    others = chain(_rows(run, figures), _details(run, figures)) if verbose else ()
    return [*shown, *(row for row in others if row not in shown)]


def changes_of(run: Run) -> list[str]:
    """How the robot changed during a run, a sentence for each time, as far as is known."""
    case = scenario_of_run(run)
    return [] if case is None else [item.sentence for item in case.changes]


def _theirs(run: Run) -> bool:
    """True if the plant was somebody else's."""
    return run.settings.plant_kind == "fmu"


def _unsaid(run: Run, verbose: bool) -> Iterator[str]:
    """Remarks that are not the outcome's own sentence, and objections of `check`, each once.

    By their short remedy where there is one, unless ``verbose``.
    """
    said = {item.key: item.text for item in run.remarks}
    objections = run.outlook.objections if run.outlook else ()
    texts = {key: text for key, text in said.items() if key not in (run.outcome, results.OBJECTED)}
    texts |= {item.key: item.sentence for item in objections}
    for key, text in texts.items():
        yield f"{key}: {(not verbose and remedy(key)) or text}"


def _rows(run: Run, figures: dict[str, Any]) -> Iterator[Row]:
    """What matters for the base of a run, the most important first."""
    yield from _position(run, figures)
    yield from _velocities(run, figures)
    if run.monitor.rigid is not None:
        yield from _rigid(run.monitor.rigid)
    if run.guard:
        yield from (row for row in _usable(run) if row[1].endswith(TOO_FAST))
        yield _changed("guard", ("thrust", "moment"), figures)
    if "filter_flags" in run:
        yield _changed("filter", ("v", "omega"), figures)
    yield from _disturbance(run, figures) if run.monitor.bounds_left else ()
    if not takes_velocities(run):
        yield from _torque(run, figures)


def takes_velocities(run: Run) -> bool:
    """Whether the base of a run takes velocities, whose wheel torques nobody commands."""
    return "v_command" in run.columns


def _torque(run: Run, figures: dict[str, Any]) -> Iterator[Row]:
    least, most = (_number(figures[key], "N m") for key in ("tau_rms", "tau_peak"))
    at_limit, when = figures["saturated_share"], results.labouring(run)
    limited = f"; at its limit in {results.percent(at_limit)} of the {when}" if at_limit else ""
    yield "wheel torque", f"{least} RMS, at most {most}{limited}"


def _details(run: Run, figures: dict[str, Any]) -> Iterator[Row]:
    """Figures for those who compare runs."""
    whole, least = figures["position_rms"]["all"], finest(scenario_of_run(run))
    robots = results.robots_over(run.settings)
    yield "position error, whole run", _about(f"{_small(whole, 'm', least)} RMS", robots)
    yield from _errors(run, figures)
    yield from _usable(run)
    yield from _disturbance(run, figures)
    if (seen := run.monitor.rigid) is not None:
        yield "wheel speed, largest", _number(seen.max_wheel_speed, "rad/s")
        margin = _number(seen.least_tip_margin)
        yield "tip margin, least", f"{margin}, 1 over the axle, 0 on an edge"
    if takes_velocities(run):
        return
    changed, when = figures["torque_change_rms"], results.labouring(run)
    yield "wheel torque, change", f"{_number(changed, 'N m')} RMS per sample, {when}"
    needed = "RMS, by the motion" + (" of the scenario's robot" if _theirs(run) else "")
    value = _number(figures["torque_needed_rms"], "N m")
    yield "wheel torque, needed", f"{value} {needed}, {when}"


def _changed(by: str, axes: tuple[str, str], figures: dict[str, Any]) -> Row:
    """Shares of the samples that guard or filter changed."""
    shares = figures[f"{by}_share"] or (None, None)
    parts = (
        f"{axis} in {MISSING if share is None else results.percent(share)}"
        for axis, share in zip(axes, shares, strict=True)
    )
    return f"{by} changed", f"{' and '.join(parts)} of the samples"


def _counted(run: Run) -> Iterator[str]:
    """The guard's assumptions in a sentence."""
    known = run.settings
    if not run.guard or known.masses is None or known.nbar is None:
        return
    named = zip(("M", "I"), *known.masses, ("kg", "kg m2"), strict=True)
    masses = ("{} {:.4g} to {:.4g} {}".format(*item) for item in named)
    dbar = "" if known.dbar is None else f"dbar {_force(known.dbar)}; "
    rest = f"{dbar}nbar {results.speeds(known.nbar)}; alpha {_number(known.alpha, '1/s')}"
    yield wrapped(f"The guard relies on {', '.join(masses)}; {rest}.")


def _usable(run: Run) -> Iterator[Row]:
    usable, asked = run.settings.usable, run.settings.asked
    if usable is not None and asked is not None:
        beyond = TOO_FAST if any(a > u for a, u in zip(asked, usable, strict=True)) else ""
        wanted = f"reference {results.speeds(asked)}{beyond}"
        yield "usable with the guard", f"{results.speeds(usable)}; {wanted}"


def _rigid(seen: RigidMonitor) -> Iterator[Row]:
    since = "" if seen.slipped is None else f": SLIPPED, from {seen.slipped:.4g} s on"
    yield "tread over ground", f"at most {_number(seen.max_slip, 'm/s')}{since}"
    fell = "" if seen.tipped is None else f": TIPPED at {seen.tipped:.4g} s"
    yield "tilt", f"at most {_number(seen.max_tilt, 'rad')}{fell}"


def _position(run: Run, figures: dict[str, Any]) -> Iterator[Row]:
    """The headline: how far the robot was from where it should have been."""
    parts, tolerance = figures["tracking"], run.settings.tolerance
    least = finest(scenario_of_run(run))
    windows = {"drive": results.driving(run), "end": "after arrival"}
    for part, when in windows.items():
        if parts[part] is not None and parts[part]["position_rms"] is not None:
            rms, most = (parts[part][key] for key in ("position_rms", "position_max"))
            near = tolerance is not None and rms <= tolerance
            word = "tracked" if near else "NOT TRACKED"
            verdict = "" if tolerance is None else f" of {_small(tolerance, 'm')} allowed: {word}"
            yield "position error", f"{_small(rms, 'm', least)} RMS{verdict}, {when}"
            yield "position error, largest", f"{_small(most, 'm', least)}, {when}"
    if figures["arrival"]:
        robot, desired = (figures["arrival"][key] for key in ("robot", "reference"))
        stays = "" if tolerance is None else f", within {_small(tolerance, 'm')} from then on"
        yield "arrival", f"{_number(robot, 's')}{stays}; desired {desired:.4g} s"


def _errors(run: Run, figures: dict[str, Any]) -> Iterator[Row]:
    ise, split, least = figures["ise"], run.settings.split, finest(scenario_of_run(run))
    _, turns = heading_rms(run, 0.0, run.settings.duration) or (0.0, False)
    unit = f"m2 s + rad2 s{', with whole turns' if turns else ''}"
    yield "ISE", f"{_digits(ise['total'])} {unit}"
    windows = [(window, values) for window, values in figures["e_rms"].items() if values]
    if _changes_there(run):
        before, after = (results.robots_over(run.settings, *span)
                         for span in ((0.0, split), (split, run.settings.duration)))  # fmt: skip
        yield f"ISE before {split:g} s", _about(_digits(ise["before"]), before)
        yield f"ISE from {split:g} s on", _about(_digits(ise["after"]), after)
    else:
        windows = windows[-1:]
    yield "ISE of the position", f"{_digits(ise['position'])} m2 s"
    for window, values in windows:
        errors = (_small(value, unit, least) for value, unit in zip(values, UNITS, strict=True))
        robots = results.robots_over(run.settings, *map(float, window.split("-")))
        text = _about(f"{', '.join(errors)}; Eq. (8)", robots)
        yield f"RMS of e, {window} s", f"{text}{_without_turns(run, window)}"


def _about(text: str, robots: str) -> str:
    """A figure, and the robots that it is about where they change."""
    return ", ".join(filter(None, (text, robots)))


def _without_turns(run: Run, window: str) -> str:
    """The heading error without whole turns, where it has some."""
    begin, end = map(float, window.split("-"))
    angle, turns = heading_rms(run, begin, end) or (0.0, False)
    return f"; {_small(angle, 'rad')} without whole turns" if turns else ""


def _changes_there(run: Run) -> bool:
    """True if the robot changes at the time that splits the run, as far as is known."""
    split, robots = run.settings.split, run.settings.robots
    return scenario_of_run(run) is None or any(time == split for time, _ in robots)


def _velocities(run: Run, figures: dict[str, Any]) -> Iterator[Row]:
    named = (("|v1|", "m/s"), ("|omega|", "rad/s"))
    limits = run.settings.v_u1
    for (name, unit), value, limit in zip(named, figures["max_abs_v"], limits, strict=True):
        verdict = "kept" if run.rows == run.settings.samples else "kept until it ended"
        if value is None or (value > limit and figures["violations"]):
            verdict = "BROKEN"
        elif value < limit:
            verdict += f", {results.percent(1 - value / limit)} to spare"
        yield f"largest {name}", f"{_number(value, unit)}, limit {limit:g} {unit}: {verdict}"
    yield from _rims(run)
    if figures["violations"]:
        steps = f"{figures['violations']} plant steps of {run.settings.plant:g} s"
        yield "beyond a limit", steps


def _rims(run: Run) -> Iterator[Row]:
    """The faster wheel at the samples, where the scenario of a run limits it."""
    from wmr_ctrl.world.speed_loop import takes_velocity

    case, first = scenario_of_run(run), run.monitor.first_violation
    if case is None or not takes_velocity(case) or (limit := case.filter.wheel_speed) is None:
        return
    most = float(np.max(abs(run["v1"]) + case.robot.l * abs(run["omega"]), initial=0.0))
    broken = most > limit * (1 + 1e-9) or (first is not None and first[1] == 3)
    verdict = ": BROKEN" if broken else ": kept" if first is None else ""
    yield "largest of a wheel", f"{_number(most, 'm/s')} at samples, limit {limit:g} m/s{verdict}"


def _disturbance(run: Run, figures: dict[str, Any]) -> Iterator[Row]:
    least, bound = figures["d_least"], figures["dbar"]
    if least is None or bound is None:
        return
    left = run.monitor.bounds_left
    verdict = "within" if left is None else f"from {left[0]:.4g} s on BEYOND"
    late = run.provenance.get("master") == "jacobi" and "delay" not in run.provenance
    why = "; torques acted a period late, untold" if late else ""
    yield "disturbance, at least", f"{_force(least)}, {verdict} dbar {_force(bound)}{why}"


def _number(value: float | None, unit: str = "") -> str:
    return MISSING if value is None else sized(value, unit)


def _digits(value: float | None) -> str:
    return MISSING if value is None else f"{value:.4g}"


def _small(value: float | None, unit: str, least: float = FINE) -> str:
    """An error [m, rad] in thousandths where it is below one."""
    if value is None or value >= 1:
        return _number(value, unit)
    if 0 < value < least:
        return f"below {1e3 * least:g} m{unit}"
    return f"{1e3 * value:.3g} m{unit}"


def _force(values: Sequence[float | None]) -> str:
    return ", ".join(_number(value, unit) for value, unit in zip(values, ("N", "N m"), strict=True))


COLUMNS = ("", "samples", "to [s]", "gap [ms]", "least", "largest")
FIGURES = (
    ("way [m]", "way"), ("|v1|", "max_abs_v1"), ("|omega|", "max_abs_v2"), ("torque", "tau_peak"),
)  # fmt: skip
"""Columns of a comparison's table."""
NOTHING_JUDGED = f"A bag has no {NEVER}, so nothing is judged."


def show_drive(drive: RecordedDrive, as_json: bool, **files: str | None) -> None:
    """Save, draw and film a drive, each where a file is named, and print it; as `write_run`."""
    out = files["out"]
    check_output(out, (".csv",), "--out of a drive")
    if files["film"]:
        raise ArgumentError(
            "--film simulates a run again on the rigid body, and a recorded drive cannot be "
            "simulated. Use --animate."
        )
    _draw([drive], files["plot"], files["animate"])
    if out:
        drive.save(out)
        say("wrote", out)
    if as_json:
        print_json(drive.summary())
    else:
        click.echo(drive_text(drive))


def compare_sources(
    sources: Mapping[str, Run | RecordedDrive],
    tolerance: float,
    plot: str | None,
    animate: str | None,
    as_json: bool,
) -> bool:
    """Print drives beside each other, runs as their bases tell them; False where two differ."""
    from wmr_ctrl.results.compare import compare

    drives = [_named(name, one) for name, one in sources.items()]
    _draw(drives, plot, animate)
    pair = compare(drives[0], drives[1], tolerance) if len(drives) == 2 else None
    if not as_json:
        text = drives_text(drives)
        click.echo(text if pair is None else f"{pair}\n\n{text}")
    else:
        print_json([drive.summary() for drive in drives] if pair is None else asdict(pair))
    return pair is None or pair.verdict in ("equal", "agree")


def _named(name: str, one: Run | RecordedDrive) -> RecordedDrive:
    if isinstance(one, Run):
        return drive_of(one, name)
    return RecordedDrive(name, one.times, one.columns, one.remarks)


def _draw(drives: list[RecordedDrive], plot: str | None, animate: str | None) -> None:
    write_file(animate, "animate_drives", drives, "animation")  # it may have nothing to show
    write_file(plot, "plot_drives", drives)


def drive_text(drive: RecordedDrive) -> str:
    """Columns of a drive with their times, longest gaps and ranges, and what is missing."""
    rows = [
        (f"{name} [{fact.unit}]", str(fact.samples), f"{fact.last:.4g}",
         f"{1e3 * fact.longest_gap:.3g}", f"{fact.least:.4g}", f"{fact.largest:.4g}")
        for name, fact in drive.facts().items()
    ]  # fmt: skip
    way = drive.figures()["way"]
    driven = "" if way is None else f", {way:.4g} m by its poses"
    parts = [f"{drive.name}: a drive of {drive.duration:.4g} s{driven}", table(rows, COLUMNS)]
    parts.append("\n".join((wrapped(NOTHING_JUDGED), *_notes(drive))))
    return "\n\n".join(parts)


def drives_text(drives: list[RecordedDrive]) -> str:
    """Figures of drives as a table, then what each lacks and what is said of it."""
    rows = []
    for drive in drives:
        figures = drive.figures()
        values = [figures[key] for _, key in FIGURES]
        cells = ("-" if value is None else f"{value:.4g}" for value in values)
        rows.append((drive.name, f"{drive.duration:.4g}", *cells))
    lines = [table(rows, ("drive", "time [s]", *(word for word, _ in FIGURES))), ""]
    lines.append(wrapped(NOTHING_JUDGED))
    for drive in drives:
        lines += [wrapped(f"{drive.name}:"), *_notes(drive)]
    return "\n".join(lines)


def _notes(drive: RecordedDrive) -> Iterator[str]:
    lacks = [f"not there: {', '.join(drive.missing)}"] if drive.missing else []
    return (wrapped(f"- {text}", hang="  ") for text in (*lacks, *drive.remarks))
