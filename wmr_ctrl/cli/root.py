"""The group of all commands, and the handling of their errors."""

import io
import os
import sys
from collections.abc import Sequence
from contextlib import suppress
from typing import Any, NoReturn

import click

from wmr_ctrl.core.errors import UnknownNameError
from wmr_ctrl.core.fields.files import one_command
from wmr_ctrl.version import __version__

from .check import check
from .compare import compare
from .console import BROKEN_PIPE, Silence, explain
from .evidence import bench, dossier, linearize, prove, reproduce
from .exports import codegen, export, page
from .identify import identify
from .lists import laws, scenarios
from .new import new
from .options import debug_option
from .runs import cosim, run, show_saved
from .studies import study, tune

PROGRAM = "wmr-ctrl"

EPILOG = """\b
Examples:
  wmr-ctrl new mine.toml            a scenario of your own robot
  wmr-ctrl check safe-simulation    what theory and one run say of each law
  wmr-ctrl run far-start --law mb   one run
  wmr-ctrl compare --law prox,mb    laws side by side
  wmr-ctrl codegen nn --out nn_c    the network law as C
  wmr-ctrl reproduce --quick        the paper's Sections V and VI, 3 seeds
  wmr-ctrl run --help               options and examples of a command

\b
Exit codes:
  0    done
  1    `reproduce` or `prove` found other verdicts, `compare` a difference, or
       the guard refused every run of a `study`
  2    wrong input, explained in one paragraph on stderr
  3    `prove` lacks a proving package; in `cosim` or `run` an FMU failed
  70   a fault of wmr-ctrl itself
  130  interrupted
"""


class Root(click.Group):
    """Commands in the order in which they are listed; every error ends as one paragraph."""

    debug = False

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Names in the order of definition."""
        return list(self.commands)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """List the commands by groups."""
        for title, commands in GROUPS.items():
            with formatter.section(title):
                formatter.write_dl(
                    [(item.name or "", item.get_short_help_str(70)) for item in commands]
                )

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """The command of that name; raises UnknownNameError, with similar names, for unknown
        ones.
        """
        if args[0] not in self.commands and not args[0].startswith("-"):
            raise UnknownNameError("command", args[0], self.commands)
        return super().resolve_command(ctx, args)

    def invoke(self, ctx: click.Context) -> object:
        """Run the command; if the reader of its output went away (``| head``), end quietly."""
        try:
            result = super().invoke(ctx)
            sys.stdout.flush()
        except BrokenPipeError:
            with suppress(OSError, ValueError):  # the interpreter's last flush goes nowhere
                os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            raise click.exceptions.Exit(BROKEN_PIPE) from None
        return result

    def main(  # type: ignore[override]  # never returns
        self, args: Sequence[str] | None = None, prog_name: str | None = None, **extra: Any
    ) -> NoReturn:
        """Parse, run and exit; every exception becomes a message and an exit code."""
        self.debug = False
        Silence.broken()
        extra["standalone_mode"] = False
        try:
            with one_command():
                code = super().main(args, prog_name or PROGRAM, **extra)
        except Exception as error:  # whatever it is, the user gets a paragraph
            code = explain(error, debug=self.debug)
        sys.exit(code if isinstance(code, int) else 0)


@click.group(
    PROGRAM,
    cls=Root,
    invoke_without_command=True,
    epilog=EPILOG,
    context_settings={"help_option_names": ["-h", "--help"], "show_default": True},
)
@click.version_option(__version__, prog_name=PROGRAM, message="%(prog)s %(version)s")
@debug_option
@click.pass_context
def root(ctx: click.Context) -> None:
    """Simulate, check, prove and deploy controllers for wheeled robots with speed limits.

    A scenario (a preset or a TOML file) describes robot, limits and path. Start with `wmr-ctrl
    new` for your own robot, then `check`, `run` and `compare`. `reproduce` judges the claims of the
    paper that the project began with: Z. Chen et al., IEEE Transactions on Industrial Electronics,
    2021.
    """
    if ctx.invoked_subcommand is None:
        click.echo(ctx.get_help())


GROUPS = {
    "Robot": (new, scenarios, laws, check, run, compare, show_saved, study, tune, identify),
    "Take away": (codegen, export, cosim, page),
    "Analyse": (linearize, reproduce, prove, dossier, bench),
}
"""Commands by what they are for, in the order in which one meets them."""
for _group in GROUPS.values():
    for _command in _group:
        root.add_command(_command)


def main() -> NoReturn:
    """Entry point of ``wmr-ctrl``; characters that a terminal cannot show are replaced."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")
    root.main()
