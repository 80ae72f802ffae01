"""``wmr-ctrl new``: the user's own scenario, with or without robot files."""

from __future__ import annotations

import os
import shlex
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import click

from wmr_ctrl.core.errors import ArgumentError

from . import options as opt
from .console import print_json, say, table, wrapped

if TYPE_CHECKING:
    from wmr_ctrl.world.robot_files import Found
    from wmr_ctrl.world.scenario.new import NewScenario

NOT_STATED = (
    "base velocity: not stated. It takes (v, omega), as cmd_vel has them; for one that takes wheel "
    "torques, add --base torque."
)


@opt.command("new")
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
    title = f"{Path(out).stem}, begun by wmr-ctrl new"
    made = new_scenario(sheet, base or "velocity", title)
    with atomic_text(out) as file:
        file.write(f"{made.text}\n\n# Next: wmr-ctrl check {shlex.quote(out)}\n")
    say("wrote", out)
    if base is None:
        say("note", NOT_STATED)
    for note in _notes(made):
        say("note", note)
    if as_json:
        every = {**made.found, **made.nodes}
        found = {key: {"value": it.value, "source": it.source} for key, it in every.items()}
        print_json({"found": found, "assumed": dict(made.assumed), "unknown": list(made.unknown)})
        return
    click.echo(_text(made))
    if made.nodes:
        click.echo(f"\n{wrapped(_for_nodes(made.nodes), hang='  ')}")
    click.echo(f"\nwmr-ctrl check {shlex.quote(out)}")


def _notes(made: NewScenario) -> Iterator[str]:
    """Notes on sizes on which the files disagree."""
    for other in made.unused:
        mine = made.found.get(other.key)
        if mine and other.key.startswith("robot."):
            also = f"{other.text} ({other.source})"
            yield f"{other.key} is {mine.text} ({mine.source}), or {also}. Measure it."


def _text(made: NewScenario) -> str:
    from wmr_ctrl.world.robot_files import shown
    from wmr_ctrl.world.scenario.new import HOW

    stated = {"found": made.found.values(), "not used": made.unused}
    rows = [
        (it.key, it.text, f"{label}: {it.source}") for label, its in stated.items() for it in its
    ]
    for label, values in (("assumed", made.assumed), ("unknown", made.unknown)):
        rows += [(key, shown(value), f"{label}: {HOW[key]}") for key, value in values.items()]
    return table(rows, ("key", "value", "from, or how to find it"))


def _for_nodes(nodes: Mapping[str, Found]) -> str:
    """Frames and topics as arguments of the ROS 2 nodes."""
    parts = []
    for key, item in nodes.items():
        name = key.removeprefix("ros.")
        parts.append(f"-{'r' if name in ('cmd_vel', 'odom') else 'p'} {name}:={item.text}")
    return f"For the ROS 2 nodes: --ros-args {' '.join(parts)}"
