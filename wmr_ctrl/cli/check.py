"""``wmr-ctrl check``: validity of a scenario, predictions of theory, findings of one run."""

from math import inf

import click

from . import options as opt
from .console import note_missing_proofs, print_json


@opt.command("check")
def check(
    scenario: str,
    chosen: tuple[str, ...],
    verbose: bool,
    only: str | None,
    corridors: bool,
    guard: bool | None,
    assignments: tuple[str, ...],
    as_json: bool,
) -> None:
    """Validate a scenario, and say what theory and one run of its law predict.

    SCENARIO is the name of a preset or a TOML file. Without --law its own law is judged, else
    kanayama; `--law all` compares all. Each is run once, with seed 0, for at most two million plant
    steps. The output begins with values that look like another unit, and with what is guaranteed;
    a table of the laws and what to change follow. A corridor is computed of one law that --law
    names, or with --corridor. An answer that takes much work is "not checked"; stable ranges have
    no such limit for laws that --law names. The exit code is 0 if the scenario is valid, whatever
    the warnings, and 2 if it is not.
    """
    from wmr_ctrl.control.laws import LAWS
    from wmr_ctrl.theory.checks.budget import OF_LAW
    from wmr_ctrl.world.scenario import inherited

    from . import check_answers as about

    case = opt.load(scenario, assignments, guard)
    taken = inherited(case)
    named = chosen or ((only,) if only and only in LAWS else ())
    every = named == tuple(LAWS)
    laws = about.laws_for(case) if every else named or (opt.law_of(case, None),)
    work = inf if named and not every else OF_LAW
    opt.note_idle(case, scenario, assignments, laws)
    note_missing_proofs()
    subject = None if as_json else only
    whole = subject in (None, *named)
    corridors = corridors or subject == "corridor" or (whole and len(named) == 1)
    answers = about.find_answers(case, laws, taken, subject, work, named, corridors=corridors)
    if as_json:
        print_json(about.document(answers))
    elif only:
        click.echo(about.listed(about.about(answers, only)))
    else:
        details = ("", about.listed(about.findings(answers))) if verbose else ()
        lines = (*about.head(answers, verbose), "", *about.law_table(answers), *details)
        click.echo("\n".join(lines))
