"""``wmr-ctrl identify``: from a log to a scenario."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from . import options as opt
from .console import Progress, print_json, say, table, wrapped

if TYPE_CHECKING:
    from wmr_ctrl.identification import BaseIdentification


@opt.command("identify")
def identify(
    logs: tuple[str, ...],
    base: str,
    out: str | None,
    robot: str | None,
    assignments: tuple[str, ...],
    topics: str | None,
    columns: tuple[str, ...],
    torque_constant: float | None,
    resistance: float | None,
    plot: str | None,
    report: str | None,
    nav2: str | None,
    propose: str | None,
    floor: float,
    as_json: bool,
) -> None:
    """Fit mass, inertia, friction, delay and lag to LOGs, with 95 % intervals.

    With --base velocity, fit the base's own speed loop: gain, time constant (or frequency and
    damping), delay, acceleration limit and peak gain. The log then needs v_command [m/s] and
    omega_command [rad/s] as well as the measured motion.

    LOG is a CSV file, a ROS 2 bag (its folder, .mcap or .db3; extra `logs`) or a saved run. Columns
    of a CSV file have the names of a run's columns, with units: t [s], wheel_counts[1] [1] (right),
    wheel_counts[2] [1] (left), tau_right [N.m], tau_left [N.m]; or v1_measured [m/s] and
    omega_measured [rad/s]. Several logs count as one. For each parameter the output says whether
    they determine it: "determined", "roughly", "undetermined", or "not explained" where no model
    that is known explains them. The scenario written by --out is for check, run, tune and codegen;
    it extends that of --robot and has what was found. A faulty log ends with exit code 2.
    """
    from pathlib import Path

    from wmr_ctrl.export.nav2 import nav2_of
    from wmr_ctrl.identification import identify as identify_log
    from wmr_ctrl.world.scenario import parse_assignments

    logs, named = opt.logs_and_columns(logs, columns)
    with Progress(f"identify {', '.join(logs)}") as progress:
        result = identify_log(
            logs[0] if len(logs) == 1 else logs,
            base=base,
            known=robot,
            overrides=parse_assignments(assignments),
            topics=opt.roles(topics),
            columns=named,
            torque_constant=torque_constant,
            resistance=resistance,
            progress=progress,
        )
    # A result that one of the files cannot hold writes none of them.
    drive, texts = None, dict[str, str]()
    if out:
        texts[out] = result.to_toml(Path(out).resolve().parent)
    if nav2:
        texts[nav2] = nav2_of(result)
    if propose:
        from wmr_ctrl.identification.propose import propose as propose_drive

        drive = propose_drive(result, floor)
        texts[propose] = drive.to_csv()
    _write(texts)
    if plot or report:
        from wmr_ctrl.report.identified import write_identification

        with Progress("report and picture"):
            write_identification(result, report, plot, drive)
        for path in filter(None, (plot, report)):
            say("wrote", path)
    if as_json:
        print_json(result.to_json())
    else:
        click.echo(_text(result))


def _write(texts: dict[str, str]) -> None:
    from wmr_ctrl.results import atomic_text

    for path, text in texts.items():
        with atomic_text(path) as file:
            file.write(text)
        say("wrote", path)


def _text(result: BaseIdentification) -> str:
    from math import isfinite

    from wmr_ctrl.identification.bounds import UNITS

    rows = [
        (name, f"{item.value:.5g}", f"{item.low:.4g} to {item.high:.4g}", UNITS[name], item.verdict)
        for name, item in result.parameters.items()
    ]
    lines = [table(rows, ("", "value", "95 % interval", "unit", "by this log")), ""]
    lines += [wrapped(item.sentence, hang="  ") for item in result.judgements]
    stretches = [
        f"{name} {item.seconds[0]:.3g} to {item.seconds[1]:.3g} s"
        for name, item in result.parameters.items()
        if item.seconds[1]
    ]
    if stretches:
        text = f"where the log says most: {', '.join(stretches)}"
        lines += [wrapped(text, hang="  "), ""]
    limited, score = result.bounds.section, result.score
    for name, (value, _) in result.bounds.pairs().items():
        label = "peak gain" if name == "peak_gain" else f"{limited}.{name}"
        lines.append(f"{label} = [{value[0]:.4g}, {value[1]:.4g}]")
    bound, how = ("dbar", "over 1 s each") if limited == "guard" else ("d", "from commands")
    texts = [f"{bound}: {result.bounds.sentence}."]
    texts += [
        f"the last third of {axis}, predicted {how} by a fit of the rest: {100 * told:.1f} % of "
        f"its variance (by a constant velocity {100 * held:.1f} %)"
        for axis, told, held in zip(
            ("v1", "omega"), score.foretold, score.constant_velocity, strict=True
        )
        if isfinite(told)
    ]
    if score.usable_speed is not None and score.one_newton_more is not None:
        texts.append(
            f"usable speed with these numbers: {score.usable_speed:.3g} m/s; one newton more of "
            f"dbar costs {1e3 * score.one_newton_more:.2g} mm/s"
        )
    texts += (f"- {text}" for text in result.remarks)
    return "\n".join((*lines, *(wrapped(text, hang="  ") for text in texts)))
