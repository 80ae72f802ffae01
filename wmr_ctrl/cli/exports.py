"""``wmr-ctrl export``, ``codegen`` and ``page``: files for other tools."""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path
from typing import TYPE_CHECKING, TypedDict, cast
from warnings import catch_warnings

import click

from . import options as opt
from .console import Progress, note_missing_proofs, say

if TYPE_CHECKING:
    from wmr_ctrl.export.api_types import ExportOptions
    from wmr_ctrl.world.scenario import Scenario

REFERENCE = "reference"
WITH_LAW = ("corridor", "closed-loop", "ssp", "simulink")
WITHOUT_LAW = ("plant", REFERENCE, "guard", "filter")
"""Outputs that hold the law of the option ``--law``, and none."""


class PackageOptions(TypedDict):
    """Options of every package of C."""

    float32: bool
    layout: str | None


@opt.command("export")
def export(
    what: str, scenario: str, assignments: tuple[str, ...], out: str, **options: object
) -> None:
    """Write wmr_WHAT.fmi2.fmu and wmr_WHAT.fmi3.fmu, wmr.ssp or WheeledRobot.mo into a folder.

    FMUs need no runtime and include their sources, a page of documentation and a reference result.
    The Modelica package has the plant, every law and a loop with each, as equations and functions.
    The Simulink kit has an S-function of one law and a script that builds the loop.
    """
    from wmr_ctrl import api
    from wmr_ctrl.control.laws.registry import LAWS
    from wmr_ctrl.export.outputs import read_by

    given = {name: value for name, value in options.items() if name in read_by(what)}
    if what in (*WITHOUT_LAW, *LAWS):
        given.pop("law", None)
    _refuse_unread(what, options.keys() - given)
    opt.check_folder(out, "--out")
    case = opt.load(scenario, assignments)
    if what in WITH_LAW:
        given["law"] = opt.law_of(case, cast("str | None", options["law"]))
    _note_idle(what, given.get("law"), case, scenario, assignments)
    given |= {"scenario": case, "out": out}
    with Progress(f"export {what}"), catch_warnings(record=True) as lacking:
        paths = api.export_fmu(what, **cast("ExportOptions", given))
    for path in paths:
        say("wrote", str(path))
    for warning in lacking:
        if warning.category is UserWarning:  # not what a library says of another
            say("note", str(warning.message))
    _ask_about_units(what, case)
    if what == "ssp":
        from wmr_ctrl.export.fmi.ssp import has_conversions

        if has_conversions(paths[0]):
            text = "connections convert units; FMPy reads that but converts none: see docs/fmu.md."
            say("note", f"{paths[0].name}: {text}")


def _note_idle(
    what: str, law: object, case: Scenario, scenario: str, assignments: tuple[str, ...]
) -> None:
    """Note keys that have no effect, unless the output is a filter alone, which any base may
    have.
    """
    from wmr_ctrl.codegen.package import FILTER
    from wmr_ctrl.control.laws.registry import LAWS

    own = what, law if what in WITH_LAW else None
    if what != FILTER:
        read = [name for name in LAWS if name in own or what == "modelica"]
        opt.note_idle(case, scenario, assignments, read)


def _ask_about_units(what: str, case: Scenario) -> None:
    """Ask about a filter's numbers that look like another unit, or that nobody stated."""
    from wmr_ctrl.codegen.package import FILTER
    from wmr_ctrl.control.filter.filter import filter_questions

    if what == FILTER:
        for question in filter_questions(case):
            say("note", question)


def _refuse_unread(what: str, names: Collection[str]) -> None:
    """Refuse options on the command line that this output would not read."""
    context = click.get_current_context()
    for item in context.command.params:
        source = context.get_parameter_source(str(item.name))
        if item.name in names and source is click.core.ParameterSource.COMMANDLINE:
            message = f"{what} does not use it. Leave it out."
            raise click.BadParameter(message, param_hint=item.opts[0])


@opt.command("codegen")
def codegen(
    law: str | None,
    scenario: str,
    assignments: tuple[str, ...],
    watched: str | None,
    float32: bool,
    layout: str | None,
    ros2: bool,
    params: tuple[str, ...],
    out: str,
) -> None:
    """Write a law as C99: header, source, example, test vectors and build files.

    Without LAW it is the scenario's own, else kanayama. A law of a base that takes velocities has
    the scenario's command filter inside. LAW may be `filter`: the command filter of
    a scenario with filter.kind = "clip", "governor" or "band"; or `corridor`: a monitor that says
    from when on the robot is in the certified corridor of --law, and whether it has left it; or
    `reference`: the scenario's path, x_d to v2_d_dot at any time, alone or beside a law's package.

    The code uses no heap, no input or output and no globals: the caller owns the law's memory.
    """
    from wmr_ctrl.codegen.package import CORRIDOR, FILTER

    opt.check_folder(out, "--out")
    if params and not ros2:
        raise click.BadParameter(
            "it works only with --ros2. Add --ros2, or leave --param out.", param_hint="--param"
        )
    case = opt.load(scenario, assignments)
    law = opt.law_of(case, law)
    unread = {CORRIDOR: ("float32", "ros2"), REFERENCE: ("watched", "ros2")}
    _refuse_unread(f"codegen {law}", unread.get(law, ("watched",)))
    if law == CORRIDOR:
        watched = opt.law_of(case, watched)
    if layout and {path.stem for path in Path(out).glob("src/wmr_*.c")} - {f"wmr_{law}"}:
        raise click.BadParameter(
            f"{out} is the library of another package. Name a folder of its own, such as "
            f"{Path(out).parent / f'wmr_{law}'}.",
            param_hint="--out",
        )
    _note_idle(law, watched, case, scenario, assignments)
    if not ros2:
        paths = _packaged(law, watched, case, Path(out), {"float32": float32, "layout": layout})
    elif law != FILTER or float32 or layout:
        raise click.BadParameter(
            "the node in C is available for the command filter in double precision only: write "
            "`codegen filter --ros2`, without --float32 and --layout.",
            param_hint="--ros2",
        )
    else:
        from wmr_ctrl.ros2.c_node import node_settings, write_node

        paths = [*write_node(Path(out), case, node_settings(params))]
    for path in paths:
        say("wrote", str(path))
    _ask_about_units(law, case)


def _packaged(
    law: str, watched: str | None, case: Scenario, out: Path, options: PackageOptions
) -> list[Path]:
    """Write a package of C; ``watched``: law of the monitor, else None."""
    from wmr_ctrl.codegen.package import CORRIDOR, files_of, package_files
    from wmr_ctrl.codegen.reference_package import reference_files
    from wmr_ctrl.results import write_all

    if watched is not None:
        from wmr_ctrl.theory.corridor import corridor_monitor

        files = files_of(CORRIDOR, corridor_monitor(case, watched), case, **options)
    elif law == REFERENCE:
        files = reference_files(case, **options)
    else:
        files = package_files(law, case, **options)
    return write_all(files, out)


@opt.command("page")
def page(
    out: str, scenario: str, assignments: tuple[str, ...], laws: tuple[str, ...], seed: int
) -> None:
    """Write one HTML file, without server or network, that runs the closed loop in a browser.

    It contains the compiled loop of this program and gives the same numbers bit for bit. For the
    paper's simulation it tells a story in five steps. For another scenario it shows that scenario,
    and for a base that takes velocities it compares several ways to limit the commands. The first
    page takes some 20 s of processor time to compile.
    """
    from wmr_ctrl import api
    from wmr_ctrl.export.page.scenes import is_story

    case = opt.load(scenario, assignments)
    note_missing_proofs()
    if not laws and not is_story(case):
        laws = (opt.law_of(case, None),)
    with Progress("compiling the page") as progress:
        api.write_page(out, case, laws=laws or None, seed=seed, progress=progress)
    say("wrote", out)
