"""Figures of a run that suit its base, as rows of a name and a text."""

from collections.abc import Iterator, Sequence
from itertools import chain, islice
from typing import Any

import numpy as np

from wmr_ctrl import results
from wmr_ctrl.core.fields.units import limits_in_words, sized
from wmr_ctrl.results import RigidMonitor, Run
from wmr_ctrl.results.obstacles import nearest
from wmr_ctrl.theory.checks.outlook import scenario_of_run
from wmr_ctrl.theory.checks.unknown_zero import FINE, finest

UNITS = ("m", "m", "rad")
MISSING = "- (not reached)"
Row = tuple[str, str]
"""Name of a figure, and its value with what it means."""
TOO_FAST = ": TOO FAST"
AT_LIMIT = 1e-9
"""Share of a limit that is nothing to spare."""
MOST_ROWS = 8
"""Rows of the short answer."""


def is_foreign(run: Run) -> bool:
    """True if the plant was a foreign one."""
    return run.settings.plant_kind == "fmu"


def rows_of(run: Run, verbose: bool = False) -> list[Row]:
    """The figures that suit the base of a run, at most `MOST_ROWS`; or all."""
    figures = results.summary(run)
    rows = _rows(run, figures)
    if not verbose:
        return [*islice(rows, MOST_ROWS)]
    return [*dict.fromkeys(chain(rows, _details(run, figures)))]


def guard_relies_on(run: Run) -> str:
    """Sentence on the guard's assumptions; empty without guard."""
    known = run.settings
    if not run.guard or known.masses is None or known.nbar is None:
        return ""
    named = zip(("M", "I"), *known.masses, ("kg", "kg m2"), strict=True)
    masses = ("{} {:.4g} to {:.4g} {}".format(*item) for item in named)
    dbar = "" if known.dbar is None else f"dbar {_force(known.dbar)}; "
    rest = f"{dbar}nbar {results.speeds(known.nbar)}; alpha {_number(known.alpha, '1/s')}"
    return f"The guard relies on {', '.join(masses)}; {rest}."


def _rows(run: Run, figures: dict[str, Any]) -> Iterator[Row]:
    """Rows that suit the base of a run, the most important first."""
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
    """True if the base of a run takes velocities, so that no wheel torques are commanded."""
    return "v_command" in run.columns


def _torque(run: Run, figures: dict[str, Any]) -> Iterator[Row]:
    mean, most = figures["tau_rms"], _number(figures["tau_peak"], "N m")
    at_limit, when = figures["saturated_share"], results.labouring(run)
    limited = f"; at its limit in {results.percent(at_limit)} of the {when}" if at_limit else ""
    rms = "" if mean is None else f"{_number(mean, 'N m')} RMS, "
    yield "wheel torque", f"{rms}at most {most}{limited}"


def _details(run: Run, figures: dict[str, Any]) -> Iterator[Row]:
    """Further figures, for comparisons of runs."""
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
    needed = "RMS, by the motion" + (" of the scenario's robot" if is_foreign(run) else "")
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
    """The main figure: distance of the robot from its desired position."""
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
    yield "ISE", f"{_digits(ise['total'])} m2 s + rad2 s"
    windows = [(window, values) for window, values in figures["e_rms"].items() if values]
    changes = any(time == split for time, _ in run.settings.robots)
    if changes or scenario_of_run(run) is None:
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
        yield f"RMS of e, {window} s", _about(f"{', '.join(errors)}; Eq. (8)", robots)


def _about(text: str, robots: str) -> str:
    """A figure, with the robots that it belongs to, if they change."""
    return ", ".join(filter(None, (text, robots)))


def _velocities(run: Run, figures: dict[str, Any]) -> Iterator[Row]:
    sides, most = run.settings.sides, figures["max_abs_v"]
    margins = figures["least_margin"] or [
        None if value is None else high - value
        for value, (_, high) in zip(most, sides, strict=True)
    ]
    limits = limits_in_words(sides).split(" and ")
    for i, name in enumerate(("|v1|", "|omega|")):
        margin, (low, high), unit = margins[i], sides[i], ("m/s", "rad/s")[i]
        verdict = "kept" if run.rows == run.settings.samples else "kept until it ended"
        if most[i] is None or margin is None or (margin < 0 and figures["violations"]):
            verdict = "BROKEN"
        elif figures["kept"] is None and run.rows == run.settings.samples:
            verdict = "NOT KNOWN, as the pose contradicts it"
        elif margin > AT_LIMIT * (high - low):
            spare = results.percent(margin / high) if low == -high else _number(margin, unit)
            verdict += f", {spare} to spare"
        yield f"largest {name}", f"{_number(most[i], unit)}, limit {limits[i]}: {verdict}"
    yield from _rims(run)
    if (near := nearest(run)) is not None:
        gap, place, time = near
        touched = ": TOUCHED" if gap < 0 else ""
        yield "nearest obstacle", f"{_number(gap, 'm')}, obstacle {place} at {time:.4g} s{touched}"
    if figures["violations"]:
        steps = f"{figures['violations']} plant steps of {run.settings.plant:g} s"
        yield "beyond a limit", steps


def _rims(run: Run) -> Iterator[Row]:
    """Speed of the faster wheel at the samples, if the run's scenario limits it."""
    case, first = scenario_of_run(run), run.monitor.first_violation
    if case is None or not case.takes_velocity or (limit := case.filter.wheel_speed) is None:
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
    """An error [m, rad], in thousandths if it is below one of them."""
    if value is None or value >= 1:
        return _number(value, unit)
    if 0 < value < least:
        return f"below {1e3 * least:g} m{unit}"
    return f"{1e3 * value:.3g} m{unit}"


def _force(values: Sequence[float | None]) -> str:
    return ", ".join(_number(value, unit) for value, unit in zip(values, ("N", "N m"), strict=True))
