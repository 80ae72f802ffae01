"""``wmr-ctrl tune``: gains of a law for a scenario, found by search."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from wmr_ctrl.cli.console import print_json, say, wrapped
from wmr_ctrl.cli.failures import resumable
from wmr_ctrl.cli.options import (
    LawName,
    check_output,
    debug_option,
    examples,
    json_option,
    load,
    set_option,
)
from wmr_ctrl.cli.progress import Progress
from wmr_ctrl.fields.limits import SEED_END

if TYPE_CHECKING:
    from wmr_ctrl.tuning import Tuning


class SeedRange(click.ParamType):
    """Seeds A up to B - 1, as A:B."""

    name = "seeds"

    def convert(
        self, value: str | range, param: click.Parameter | None, ctx: click.Context | None
    ) -> range:
        """The range, or click's refusal of anything else."""
        if isinstance(value, range):
            return value
        first, _, end = value.partition(":")
        if not (first.isdecimal() and end.isdecimal() and int(first) < int(end) <= SEED_END):
            self.fail(f"{value!r} is not a range of seeds such as 1:4, which is 1, 2 and 3.")
        return range(int(first), int(end))


@click.command(
    short_help="Find gains of a law for a scenario.",
    epilog=examples(
        "wmr-ctrl tune safe-simulation --law prox --out mine.toml",
        "wmr-ctrl tune robot.toml --law kanayama --out mine.toml --trials 400 --json",
    ),
)
@click.argument("scenario")
@click.option(
    "--law", type=LawName(), required=True, metavar="NAME", help="Control law; see `wmr-ctrl laws`."
)
@click.option("--out", required=True, metavar="FILE", help="Scenario with the gains found: .toml.")
@click.option(
    "--seeds", type=SeedRange(), default="1:4", metavar="A:B", help="Trained on: A to B-1."
)
@click.option(
    "--test-seeds", type=SeedRange(), default="7101:7106", metavar="C:D", help="Tested with."
)
@click.option(
    "--trials",
    type=click.IntRange(min=1),
    default=200,
    metavar="N",
    help="Sets of gains that are tried; rounded up to whole generations.",
)
@click.option(
    "--weight",
    type=float,
    default=1e-3,
    metavar="W",
    help="Metres of position error that 1 N m of torque change from sample to sample is worth.",
)
@click.option(
    "--hold",
    multiple=True,
    metavar="KEY",
    help="A gain that stays, such as gains.kinematics.k, which laws share. May be repeated.",
)
@click.option("--jobs", type=click.IntRange(min=1), metavar="N", help="Runs at the same time.")
@set_option
@json_option("Print gains and figures, before and after, as one JSON document.")
@debug_option
def tune(
    scenario: str,
    law: str,
    out: str,
    seeds: range,
    test_seeds: range,
    trials: int,
    weight: float,
    hold: tuple[str, ...],
    jobs: int | None,
    assignments: tuple[str, ...],
    as_json: bool,
) -> None:
    """Search gains of a law that track with little torque, also if the robot's mass is another.

    Minimises the root of the mean of position_rms^2 + (W torque_change_rms)^2 over the training
    seeds, for the scenario's robot and for 0.6 and 1.6 times the believed mass, the guard off.
    Writes the scenario with these gains, and says how they do on test seeds and on references that
    were not trained on. An interrupted search goes on where it was when it is called again.
    """
    check_output(out, (".toml",), "--out")
    from wmr_ctrl import tuning
    from wmr_ctrl.tuning.search import trials_file

    with resumable(trials_file(Path(out))), Progress(f"tune {law}") as progress:
        better = tuning.tune(
            load(scenario, assignments), law, out,
            seeds=seeds, test_seeds=test_seeds, trials=trials, weight=weight, hold=hold,
            jobs=jobs, progress=progress,
        )  # fmt: skip
    say("wrote", str(better.out))
    if as_json:
        print_json(better.to_json())
    else:
        click.echo(_text(better))


def _text(better: Tuning) -> str:
    first, last = better.objective
    lines = [f"{key} = {', '.join(f'{number:g}' for number in value)}"
             for key, value in better.gains.items()]  # fmt: skip
    lines += [
        f"objective on the training seeds: {1e3 * first:.4g} mm before, {1e3 * last:.4g} mm after",
        "",
        f"{'test seeds':<20}{'position RMS [mm]':>23}{'torque change [N m]':>25}"
        f"{'worst |v|/limit':>20}",
        f"{'reference':<14}{'mass':>6}{'before':>14}{'after':>9}{'before':>16}{'after':>9}"
        f"{'before':>12}{'after':>8}",
    ]  # fmt: skip
    limits = better.scenario.limits.v_u1
    for old, new in zip(better.before, better.after, strict=True):
        worst = [max(v / u for v, u in zip(item.max_abs_v, limits, strict=True))
                 for item in (old, new)]  # fmt: skip
        lost = f"  {new.lost} runs ended early" if new.lost else ""
        names = (item.figure for item in better.worse
                 if (item.reference, item.mass) == (new.reference, new.mass))  # fmt: skip
        if worse := ", ".join(names):
            lost += f"  worse: {worse}"
        lines.append(
            f"{old.reference:<14}{old.mass:>6g}"
            f"{1e3 * old.position_rms:>14.3g}{1e3 * new.position_rms:>9.3g}"
            f"{old.torque_change_rms:>16.3g}{new.torque_change_rms:>9.3g}"
            f"{worst[0]:>12.3f}{worst[1]:>8.3f}{lost}"
        )
    if better.worse:
        lines += ["", wrapped(_WORSE)]
    return "\n".join(lines)


_WORSE = (
    "Figures of the test are worse than before, in the rows that say so. Take these gains only if "
    "the robot does not drive like that; or tune on that reference, or raise --weight where it is "
    "the torque."
)
