"""``wmr-ctrl new``: the user's own scenario, from robot files where there are some."""

from __future__ import annotations

import os
import shlex
from pathlib import Path
from typing import TYPE_CHECKING

import click

from wmr_ctrl.core.errors import ArgumentError

from . import options as opt
from .console import print_json, say, table

if TYPE_CHECKING:
    from wmr_ctrl.world.robot_files import Found
    from wmr_ctrl.world.scenario.new import NewScenario


@opt.command(
    "Write a scenario of your own robot.",
    "wmr-ctrl new mine.toml",
    "wmr-ctrl new mine.toml --base torque",
    "wmr-ctrl new mine.toml --from robot.urdf.xacro controllers.yaml nav2_params.yaml",
)
@click.argument("paths", metavar="OUT.toml", nargs=-1, required=True)
@click.option(
    "--base",
    type=click.Choice(["velocity", "torque"]),
    help="What the base takes: (v, omega) as cmd_vel has them, or wheel torques.  "
    "[default: velocity]",
)
@click.option(
    "--from", "files", metavar="FILE ...", multiple=True,
    help="Files to read: URDF, xacro, SDF, controllers.yaml, nav2 parameters.",
)  # fmt: skip
@click.option("--force", is_flag=True, help="Replace OUT.toml if it is there.")
@opt.json_option("Print what was found, assumed and unknown as one JSON document.")
def new(
    paths: tuple[str, ...],
    base: str | None,
    files: tuple[str, ...],
    force: bool,
    as_json: bool,
) -> None:
    """Write OUT.toml, a scenario of your own robot: short, commented, ready for check and run.

    Without files every number is a cautious guess, and the file says how to measure it. With
    --from, numbers come from files of ROS and Gazebo: mass, inertia, wheels and track of a URDF
    or xacro; limits, ramps, time-out and period of a diff_drive_controller, of nav2 and of
    Gazebo. Where two disagree, the controller's counts, and both are printed. The file's key
    `assumed` names what nobody stated.
    """
    from wmr_ctrl.results import atomic_text
    from wmr_ctrl.world.robot_files import read_robot_files
    from wmr_ctrl.world.scenario.new import new_scenario

    out = next((path for path in paths if path.endswith(".toml")), paths[0])
    more = [path for path in paths if path != out]  # further values of --from
    if more and not files:
        raise click.UsageError(f"one file is written, and {more[0]!r} is one more: see --from.")
    opt.check_output(out, (".toml",), "OUT")
    if os.path.lexists(out) and not force:
        raise ArgumentError(f"{out} is there already, and is kept. Name another file, or --force.")
    sheet = read_robot_files([*files, *more])
    made = new_scenario(sheet, base or "velocity", f"{Path(out).stem}, begun by wmr-ctrl new")
    with atomic_text(out) as file:
        file.write(f"{made.text}\n\n# Next: wmr-ctrl check {shlex.quote(out)}\n")
    say("wrote", out)
    if base is None:
        say(
            "note",
            "base velocity: not stated. It takes (v, omega), as cmd_vel has them; for one that "
            "takes wheel torques, add --base torque.",
        )
    if as_json:
        print_json(_json(made))
    else:
        click.echo(_text(made))
        click.echo(f"\nwmr-ctrl check {shlex.quote(out)}")


def _json(made: NewScenario) -> dict[str, object]:
    every = {**made.found, **made.nodes}
    return {
        "found": {key: {"value": it.value, "source": it.source} for key, it in every.items()},
        "assumed": dict(made.assumed),
        "unknown": list(made.unknown),
    }


def _text(made: NewScenario) -> str:
    from wmr_ctrl.world.scenario.new import HOW

    rows = [_row(item, "found") for item in (*made.found.values(), *made.nodes.values())]
    rows += [_row(item, "not used") for item in made.unused]
    for values, label in ((made.assumed, "assumed"), (made.unknown, "unknown")):
        for key, value in values.items():
            shown = list(value) if isinstance(value, tuple) else value
            rows.append((key, str(shown), label, HOW[key]))
    return table(rows, ("key", "value", "", "from, or how to find it"))


def _row(item: Found, label: str) -> tuple[str, str, str, str]:
    return item.key, item.text, label, item.source
