"""``wmr-ctrl reproduce``, ``prove``, ``linearize``, ``bench``: claims judged, proved, measured."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from wmr_ctrl.core.errors import ArgumentError, MissingExtraError

from . import options as opt
from .console import (
    DIFFERENCE,
    Progress,
    json_text,
    note_missing_proofs,
    print_json,
    say,
    width,
)

if TYPE_CHECKING:
    from wmr_ctrl.world.scenario import Scenario

SEEDS, QUICK = 20, 3


@opt.command("reproduce")
@click.pass_context
def reproduce(
    ctx: click.Context,
    quick: bool,
    seeds: int | None,
    jobs: int | None,
    with_ours: bool,
    with_physics: bool,
    out: str,
) -> None:
    """Rerun the paper's Sections V and VI with all laws, and judge its claims.

    Writes DIR/report.html (one self-contained file), every panel of Fig. 3 and Fig. 5 as SVG and
    PNG, table.csv and claims.json. --with-ours adds ours.csv, its figures and ours.txt on results
    beyond the paper, --with-physics rigid.csv and rigid.txt on the robot as a rigid body on tyres.
    The exit code is 0 if every verdict equals the one committed with this release, and 1 if not.
    """
    opt.check_folder(out, "--out")
    from wmr_ctrl import api

    note_missing_proofs()
    with Progress("reproduce") as progress:
        verdicts = api.reproduce(
            out,
            seeds=seeds or SEEDS,
            quick=quick and seeds is None,
            jobs=jobs,
            with_ours=with_ours,
            with_physics=with_physics,
            progress=progress,
        )
    say("wrote", str(verdicts.report))
    click.echo(str(verdicts))
    if not verdicts.as_expected:
        ctx.exit(DIFFERENCE)


@opt.command("prove")
def prove(
    only: tuple[str, ...],
    file: str | None,
    folder: str | None,
    certified: str | None,
    examine: bool,
) -> None:
    """Prove or refute the paper's numbered equations and theorems, and our own results.

    Claims are about the expressions from which the C is generated. Every verdict is derived again,
    and so are the functions that an entry names. The exit code is 1 if a verdict differs from the
    committed one, and 3 without the extra proofs, which has the solvers.
    """
    from wmr_ctrl.results.ledger import UNCHECKED
    from wmr_ctrl.theory.door import proofs

    try:
        runner = proofs("runner")
    except MissingExtraError as error:
        say("error", str(error))
        raise click.exceptions.Exit(UNCHECKED) from None
    if folder is not None:
        runner.run_export(Path(folder), only)
        return
    if certified is not None:
        raise click.exceptions.Exit(runner.run_certificates(Path(certified), only))
    opt.check_output(file, (".json",), "--json")
    with Progress("proofs") as progress:
        target = Path(file) if file else None
        code = runner.run_prove(only, target, lambda share, _: progress(share), examine)
    raise click.exceptions.Exit(code)


@opt.command("dossier")
def dossier(scenario: str, out: str, as_json: bool) -> None:
    """Write one page with the argument for a scenario's speed limit, for whoever has to sign.

    Function, assumptions with a table to sign, argument down to the entries of the ledger, response
    times, faults with their tests, and what is not covered. The exit code is 2 where nothing is
    promised: neither guard nor filter, a bound of 0, a broken assumption, or an entry that does not
    hold for the graphs of today.
    """
    from wmr_ctrl.control.setup import settle

    from . import dossier as page

    case = opt.load(scenario)
    opt.check_output(out, (".html",), "--out")
    with Progress("dossier"):
        document = page.document(settle(case, opt.law_of(case, None)), scenario)
        page.write(document, scenario, out)
    say("wrote", out)
    if as_json:
        print_json(document)


@opt.command("linearize")
@click.pass_context
def linearize(
    ctx: click.Context,
    scenario: str,
    laws: tuple[str, ...],
    assignments: tuple[str, ...],
    at: float | None,
    guard: bool,
    plot: str | None,
    against_run: bool,
    as_json: bool,
) -> None:
    """Linearise the closed loop along the reference, exactly: poles, margins, stability limits.

    On a circle or a line the loop is time-invariant in error coordinates. On other references,
    poles and margins are those at one time, which is printed. The spectral radius (without --at)
    and the largest stable period cover a whole period of the reference, or its worst point if it
    does not repeat. With --against-run, none of that is computed: runs that start farther and
    farther off the reference are compared with the linear loop's prediction.
    """
    case = opt.load(scenario, assignments)
    if against_run:
        if at is not None:
            raise ArgumentError("--at has no meaning with --against-run, which begins at 0 s.")
        _against_run(case, laws or (opt.law_of(case, None),), guard, plot, as_json)
        return
    from wmr_ctrl.theory.linear import report_linear

    law = opt.one_law(ctx, ctx.command.params[1], ",".join(laws) or None)
    if plot:
        opt.check_folder(plot, "--plot")
    chosen = opt.law_of(case, law)
    opt.note_idle(case, scenario, assignments, [chosen])
    with Progress(f"{chosen}, linearised") as progress:
        report = report_linear(case, chosen, at, guard=guard, progress=progress)
    with Progress("pictures") as progress:
        paths = report.plots(plot, progress) if plot else ()
    if as_json:
        print_json(report.to_json())
    else:
        click.echo(report.table(width()))
    for path in paths:
        say("wrote", str(path))


def _against_run(
    case: Scenario, laws: tuple[str, ...], guard: bool, plot: str | None, as_json: bool
) -> None:
    from wmr_ctrl import api

    opt.check_output(plot, opt.PLOTS, "--plot")
    with Progress("linear loop against runs") as progress:
        found = api.linear_against_run(case, laws, guard=guard or None, progress=progress)
    if as_json:
        print_json(found.to_json())
    else:
        click.echo(found.table())
    if plot:
        say("wrote", str(found.plot(plot)))


@opt.command("bench")
def bench(file: str | None) -> None:
    """Measure generated C against hand-written C and NumPy, interleaved in one run.

    Ratios are comparable between machines, times are not; FILE has both.
    """
    opt.check_output(file, (".json",), "--json")
    click.echo("compiling and measuring: about a minute on an idle machine", err=True)
    with Progress("benchmarks") as progress:
        from wmr_ctrl import api

        measured = api.bench(progress=progress)
    if file:
        from wmr_ctrl.results import atomic_text

        with atomic_text(file) as stream:
            stream.write(json_text(measured) + "\n")
        say("wrote", file)
    click.echo(measured["text"])
