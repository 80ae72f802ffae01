"""`identify`: from a log to a scenario with intervals, or a paragraph on why that fails."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from wmr_ctrl.control.setup import check_scenario
from wmr_ctrl.core.errors import ArgumentError
from wmr_ctrl.core.fields.arguments import checks_arguments
from wmr_ctrl.results import RecordedDrive, Run
from wmr_ctrl.world.command_loss import CommandLoss
from wmr_ctrl.world.encoder import COUNTS, Encoder
from wmr_ctrl.world.scenario import Scenario, missing_text, override, sections
from wmr_ctrl.world.speed_loop import KINDS, BaseKind

from .bounds import (
    DETERMINED,
    UNDETERMINED,
    BaseIdentification,
    Estimate,
    GuardBounds,
    Traces,
    informative_seconds,
    mixtures,
    sizes,
    verdict,
)
from .estimate import (
    FREE_RUN,
    bare_scenario,
    coloured_if_likelier,
    cut_of,
    score_of,
    seconds_begin,
    surest,
    white_fit,
)
from .fit import PHYSICAL, Fit, LogProblem, intervals_of
from .kalman import INDEX, CompiledFilter
from .logs import lint
from .logs.log import (
    COMMAND,
    KNOWN,
    TORQUES,
    Log,
    LogError,
    Names,
    joined,
    log_of,
    seen_by,
    with_counts,
    with_torques,
)
from .logs.mended import mended
from .logs.rows import Rows, usable
from .logs.samples import Samples, held_range, motion_of
from .refuted import explaining, guard_bounds, held_out, usable_speeds
from .stated import (
    NOT_SHOWN,
    believed,
    beyond,
    not_found,
    refusal,
    too_far,
    undetermined,
    with_limits,
    written,
)
from .velocity_base import of_velocities
from .written import four_digits

Progress = Callable[[float], None]
OneLog = str | Path | Run | RecordedDrive | Mapping[str, list[float]]
READ = 0.1
"""Share of the work until a log is read, for the progress shown."""
SHORTEST = {"torque": 10.0, "velocity": 2.0}
"""Least length of a log [s]."""
ROBOT = ("robot.r", "robot.l")
COUNTED, TIMEOUT = "encoder.counts", "base.timeout"


@dataclass(frozen=True)
class Identification(BaseIdentification):
    """Results for a base that takes torques.

    ``fit`` is the reported fit, ``white`` the one whose residuals give the bounds, and ``trained``
    the fit to the first two thirds only.
    """

    bounds: GuardBounds
    fit: Fit
    white: Fit
    trained: Fit


def _curves(white: Fit, trained: Fit) -> Traces:
    """Measured and predicted speeds, and residuals as forces; by two passes over the log."""
    problem, log = white.problem, white.problem.log
    mean = problem.read(trained.theta, slopes=False).mean
    first = np.union1d(log.first, seconds_begin(log.t))
    foretold = problem.foretold(replace(log, first=first), trained.theta, mean[first])[:, 2:4]
    foretold[log.t < log.t[0] + FREE_RUN] = np.nan
    q = np.exp(white.theta[[INDEX["q1"], INDEX["q2"]]])
    force = np.where(problem.counts[:, None], q * white.last.sizes, np.nan)
    return Traces(log.t, mean[:, 2:4], foretold, force, cut_of(log))


@checks_arguments
def identify(
    log: OneLog | Sequence[OneLog],
    *,
    base: str = "torque",
    known: str | Path | Scenario | None = None,
    overrides: Mapping[str, object] | None = None,
    topics: Mapping[str, str] | None = None,
    columns: Mapping[str, str] | None = None,
    torque_constant: float | None = None,
    resistance: float | None = None,
    progress: Progress | None = None,
) -> BaseIdentification:
    """Identify a robot from a CSV file, a bag, a drive, a run, or columns by ``name [unit]``.

    Several logs of one robot count as one. ``base`` is what the base takes: "torque", or "velocity"
    (v, omega). ``known`` is a scenario with the known values (robot.r, robot.l, encoder.counts,
    limits); ``overrides`` are applied to it; ``topics`` names a bag's topics by role, and
    ``columns`` a table's columns by ours, perhaps with a unit; ``torque_constant`` [N.m/A] turns
    motor currents into torques, and with a motor's ``resistance`` [ohm] voltages. Raises LogError
    for a faulty or uninformative log, ScenarioError, ArgumentError, ResultFileError,
    MissingExtraError, CompilerError.
    """
    commands = TORQUES if base == "torque" else COMMAND
    raw = _one_log(log, base, topics, columns)
    if base == "torque" or torque_constant is not None:
        raw = with_torques(raw, torque_constant, resistance)
    scenario, sure, origin = believed(raw, known, overrides or {})
    raw, counts = with_counts(raw, scenario.section(Encoder).counts if COUNTED in sure else None)
    if counts is not None:
        scenario, sure = override(scenario, {COUNTED: counts}), {*sure, COUNTED}
    raw = mended(raw)
    remarks = [*raw.remarks, *(note.text for note in raw.notes)]
    samples, scenario = _samples(raw, scenario, sure, remarks, commands)
    timeout = scenario.section(CommandLoss).timeout if TIMEOUT in sure else None
    rows = usable(samples, timeout, base)
    samples, remarks = rows.samples, [*remarks, *(note.text for note in rows.notes)]
    if np.ptp(samples.command, axis=0).any():
        lint.check_motion(raw.name, samples, scenario.robot.l, SHORTEST[base])
    if base == "torque":
        lint.check_torques(raw.name, samples, scenario.robot.l)
    lint.check_poses(raw.name, raw, samples)
    scenario, words = with_limits(scenario, sure, samples, base, remarks)
    period, own = float(f"{samples.period:.4g}"), scenario.clock.control
    if "clock.control" in sure and period != own:
        remarks.append(f"clock.control = {own:.4g} s becomes {period:.4g} s, the log's step.")
    if progress:
        progress(READ)
    fit = _of_torques if base == "torque" else of_velocities
    fitted = fit(raw.name, samples, scenario, remarks)
    found = _finished(fitted, scenario, sure, rows, words)
    if progress:
        progress(1.0)
    return replace(found, origin=origin, notes=(*raw.notes, *rows.notes))


def _one_log(
    log: OneLog | Sequence[OneLog],
    base: str,
    topics: Mapping[str, str] | None,
    columns: Mapping[str, str] | None,
) -> Log:
    """Join all logs, for the kind of base that the caller names."""
    if base not in KINDS:
        raise ArgumentError(f"base = {base!r} must be one of {', '.join(KINDS)}.")
    several = log if isinstance(log, list | tuple) else (log,)
    if not several:
        raise ArgumentError("no log is given. Give at least one.")
    raw = joined([log_of(item, topics, columns) for item in several])
    if raw.base is not None and raw.base.takes_velocity != (base == "velocity"):
        kind = raw.base.section(BaseKind).kind
        raise ArgumentError(
            f'{raw.name}: the base of this run takes a {kind} (base.kind). Give base = "{kind}", '
            f"on the command line --base {kind}."
        )
    return raw


def _finished(
    found: BaseIdentification, scenario: Scenario, sure: set[str], rows: Rows, words: dict[str, str]
) -> BaseIdentification:
    """The results, completed by known values where nothing was found, and with the missing keys.

    ``words``: keys to write, with comments on some.
    """
    samples, remarks = rows.samples, found.remarks
    vague = [key for key in undetermined(found.parameters) if key in sure]
    kept = {key: scenario.value(key)[0] for key in vague}
    if rows.timeout is not None and TIMEOUT not in sure:
        words, kept = words | {TIMEOUT: ""}, kept | {TIMEOUT: round(rows.timeout, 3)}
    result = written(override(found.scenario, kept))
    missing = not_found(sure, samples, found.parameters)
    if missing:
        remarks = (*remarks, missing_text(missing, sections()))
        result = replace(result, assumed=tuple(dict.fromkeys((*result.assumed, *missing))))
    unshown = (key for key in result.assumed if key.startswith(("filter.", "guard.")))
    return replace(
        found, scenario=result, remarks=remarks, missing=missing, range=held_range(samples),
        words=words | dict.fromkeys(unshown, NOT_SHOWN), left_out=rows.left_out,
        seconds=float(samples.t[-1] - samples.t[0]),
    )  # fmt: skip


def _samples(
    raw: Log, scenario: Scenario, sure: set[str], remarks: list[str], commands: Names
) -> tuple[Samples, Scenario]:
    """Samples of path length and rotation, or of speeds, with torques; and the scenario, with wheel
    sizes from poses if they are not known.

    Raises LogError where something is missing.
    """
    if not raw.has(commands):
        names = " and ".join(f"{name} [{KNOWN[name]}]" for name in commands)
        other = COMMAND if commands == TORQUES else TORQUES
        hint = "velocity" if commands == TORQUES else "torque"
        raise LogError(
            f"{raw.name}: it has no commands. Add the columns {names}, as they were sent to the "
            "base; of a bag name their topic, as in --topics "
            f"{'cmd' if hint == 'torque' else 'effort'}=NAME."
            + (f" Its {' and '.join(other)} can be used with --base {hint}." * raw.has(other))
        )
    source = seen_by(raw)
    of_wheels = source in (COUNTS.name, "wheel_speed")
    if source == COUNTS.name and not (COUNTED in sure and scenario.section(Encoder).counts):
        raise LogError(
            f"{raw.name} has encoder counts, but the number per turn of a wheel is not known. Give "
            "it, all four edges counted, as in --set encoder.counts=4096."
        )
    missing = [key for key in ROBOT if key not in sure]
    if missing and (commands == TORQUES or of_wheels):
        trial = override(scenario, dict.fromkeys(ROBOT, 1.0))
        poses = (
            lint.pose_ratios(raw, motion_of(raw, trial, source, commands)) if of_wheels else None
        )
        if poses is None or not np.isfinite(poses).all():
            raise LogError(
                f"{raw.name}: {' and '.join(missing)} must be known, and there are no poses that "
                "turn with the wheels to find them from. Give the wheels' radius and half the "
                "track, as in --set robot.r=0.08 --set robot.l=0.2, or a scenario that has them: "
                "--robot known.toml."
            )
        r, half_track = poses[0], poses[0] / poses[1]
        remarks.append(
            f"r = {r:.4g} m and l = {half_track:.4g} m by poses against the wheels' turn."
        )
        scenario = override(scenario, {"robot.r": r, "robot.l": half_track})
    samples = motion_of(raw, scenario, source, commands)
    if not of_wheels:
        remarks.append(f"the motion is read from {source}; encoder counts are more precise.")
    return samples, scenario


def _of_torques(name: str, log: Samples, scenario: Scenario, remarks: list[str]) -> Identification:
    robot = scenario.robot
    known = np.array([robot.r, robot.l, robot.g, robot.v_s, log.period])
    problem = LogProblem(log, CompiledFilter(scenario), known)
    white = white_fit(problem)
    fit = coloured_if_likelier(white)
    if not all(np.isfinite(x.nll) and np.isfinite(x.information()).all() for x in (white, fit)):
        raise LogError(
            f"{name}: no model of the robot explains the log: what it says about the parameters is "
            "not finite where they are likeliest. Check its time stamps, which may be off by some "
            "milliseconds, its units, and the robot's known numbers."
        )
    fit = surest(fit)
    widths, estimates = intervals_of(fit), {}
    speed = np.sqrt(np.mean(white.last.mean[:, 2:4] ** 2, axis=0))
    values = {key: item[0] for key, item in widths.items()}
    scale = sizes(values, speed, log.period)
    for key, (value, low, high) in widths.items():
        place = INDEX[key]
        seconds = informative_seconds(log.t, fit.last.fisher[:, place, place])
        share = (high - low) / 2 / max(scale[key], 1e-300)
        estimates[key] = Estimate(value, low, high, verdict(share), seconds, share)
    vague = {key for key, item in estimates.items() if item.verdict != DETERMINED}
    count = len(PHYSICAL)
    remarks += mixtures(PHYSICAL, fit.last.fisher.sum(axis=0)[:count, :count], vague)
    if widths["Fv"][2] < 0:
        remarks.append(
            "friction falls with speed (Fv < 0), as stiction makes it: Coulomb friction and Fv are "
            "not covered by their intervals."
        )
    if all(item.verdict == UNDETERMINED for item in estimates.values()):
        remarks.append(
            "the log determines nothing about the robot. Change the speed of each wheel, at "
            "different times."
        )
    unknown = all(estimates[key].verdict == UNDETERMINED for key in ("m", "I"))
    bare = bare_scenario(scenario, log, remarks)
    clocked = replace(bare, actuator=replace(bare.actuator, tau_max=scenario.actuator.tau_max))
    bounds = guard_bounds(white, widths, clocked)
    trained, refuted = held_out(white, fit, clocked)
    bounds = replace(explaining(white, bounds), refuted=refuted, wide=bounds.wide or unknown)
    far = beyond(clocked, log)
    identified = _scenario(name, clocked, values, bounds, far, remarks)
    curves = _curves(white, trained)
    score = score_of(curves)
    price = usable_speeds(override(identified, {"guard.enabled": True}))
    if price:
        score = replace(score, usable_speed=price[0], one_newton_more=price[1])
    return Identification(
        name, estimates, bounds, tuple(remarks), score, identified, curves, fit, white, trained
    )


def _scenario(
    name: str,
    base: Scenario,
    values: Mapping[str, float],
    bounds: GuardBounds,
    far: Sequence[float],
    remarks: list[str],
) -> Scenario:
    """The robot's scenario; its guard is on if the numbers for it are valid and can be met.

    ``far`` (2,): each limit divided by the largest speed of the log.
    """
    r, half_track, step = base.robot.r, base.robot.l, base.clock.plant
    values = {name: four_digits(x) for name, x in values.items()}
    weight = values["m"] * base.robot.g
    std = four_digits(max(bounds.q[0], bounds.q[1] / half_track) * r / math.sqrt(2))
    most = min(bounds.dbar[0], bounds.dbar[1] / half_track) * r / 2
    rolling = four_digits(2 * max(values["c"], 0.0) / weight)
    delay = max(round(values["delay"] / step), 0) * step
    base = replace(base, title=f"identified from {name}")
    result = override(base, {
        "robot.m": values["m"], "robot.I": values["I"],
        "robot.mu": four_digits(max(values["Fc"], 0.0) / weight),
        "resistance.viscous": [max(values["Fv"], 0.0), max(values["Mv"], 0.0)],
        "resistance.rolling": [rolling, rolling],
        "actuator.delay": min(max(delay, 0.0), bounds.delay[1]), "actuator.lag": values["lag"],
        "disturbance.std": std, "disturbance.truncate": four_digits(most / std, up=False),
        **{f"guard.{key}": list(pair) for key, (pair, _) in bounds.pairs().items()},
        "guard.dbar": [four_digits(x * d, up=True)
                       for x, d in zip(far, bounds.dbar, strict=True)],
        **({"guard.delay": None} if bounds.wide else {}),
    })  # fmt: skip
    founded, result = result, replace(result, assumed=(*result.assumed, "guard.dbar"))
    guarded = override(result, {"guard.enabled": True})
    if reason := _against(guarded, bounds, far):
        remarks.append(f"the guard is off: {reason}")
        return result
    if max(far) == 1:
        return replace(guarded, assumed=founded.assumed)
    wider = guarded.value("guard.dbar")
    remarks.append(
        f"limits.v_u1 is up to {100 * max(far) - 100:.0f} % beyond the fastest motion of the log: "
        "pushes are taken to grow with speed, so guard.dbar is "
        f"[{wider[0]:.3g}, {wider[1]:.3g}] in the scenario."
    )
    return guarded


def _against(guarded: Scenario, bounds: GuardBounds, far: Sequence[float]) -> str:
    """Reason for which a guard cannot be based on the log; "" if there is none."""
    if bounds.refuted:
        return (
            "a part of the log contradicts what the rest of it gives. "
            f"{'; '.join(bounds.refuted)}. Robot, load, floor or lateness changed: take a log of "
            "each, or state bounds for all."
        )
    if bounds.wide:
        (low, high), (least, most) = bounds.delay, bounds.masses[0]
        lacking = (
            f"a delay known to a control period, and this one lies between {1e3 * low:.3g} and "
            f"{1e3 * high:.3g} ms"
            if high - low > guarded.clock.control * (1 + 1e-9)
            else "a mass or an inertia that the log determines, and m lies between "
            f"{least:.3g} and {most:.3g} kg"
        )
        return f"it takes {lacking}. A better drive determines it."
    return too_far(guarded, far) or refusal(guarded, check_scenario)
