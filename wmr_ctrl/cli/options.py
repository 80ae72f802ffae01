"""Commands as commands.toml describes them, and how their options and arguments are read."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from wmr_ctrl.core.data import data
from wmr_ctrl.core.errors import ArgumentError
from wmr_ctrl.core.fields.values import SEED_END
from wmr_ctrl.core.suffixes import RUNS as RUNS

from .console import say

if TYPE_CHECKING:
    from wmr_ctrl.world.scenario import Scenario

SCENARIO = "paper-simulation"
PLOTS, ANIMATIONS = (".png", ".svg", ".pdf"), (".gif", ".html")
COMMANDS = data(__package__, "commands.toml")
_PAIR = re.compile(r"[\w\[\]]+=.+")


def _remember_debug(ctx: click.Context, _parameter: click.Parameter, value: bool) -> None:
    if value:
        ctx.find_root().command.debug = True  # type: ignore[attr-defined]


debug_option = click.option(
    "--debug",
    is_flag=True,
    is_eager=True,
    expose_value=False,
    callback=_remember_debug,
    help="Show the traceback of an error.",
)


def one_law(_: click.Context, __: click.Parameter, value: str | None) -> str | None:
    """The name of one law, or a file; whether it exists is checked where it is used."""
    from wmr_ctrl.control.laws.given import law_name

    names = value.split(",") if value and not os.path.isfile(value) else []
    if len(names) > 1:
        listed = ", ".join(f'"{name.strip()}"' for name in names)
        raise click.BadParameter(
            f"{value!r} names {len(names)} laws, and this takes one. `wmr-ctrl compare SCENARIO "
            f"--law {value}` runs them side by side; `wmr-ctrl check --law {value}` judges each; "
            f"for many runs of several write a study: laws = [{listed}] in PLAN.toml, and "
            "`wmr-ctrl study PLAN.toml --out DIR`."
        )
    return law_name(value) if value else value


def _seed(_: click.Context, __: click.Parameter, value: str) -> int:
    try:
        seed = int(value)
    except ValueError:
        seed = -1
    if not 0 <= seed < SEED_END:
        raise click.BadParameter(f"{value!r} is not a whole number from 0 up, below {SEED_END}.")
    return seed


def _each_law(_: click.Context, __: click.Parameter, values: Sequence[str]) -> tuple[str, ...]:
    from wmr_ctrl.control.laws.given import law_names
    from wmr_ctrl.control.laws.registry import LAWS

    parts = ([value] if os.path.isfile(value) else value.split(",") for value in values)
    names = [name.strip() for part in parts for name in part]
    named = law_names(name for name in names if name != "all")
    return tuple(dict.fromkeys((*named, *(LAWS if "all" in names else ()))))


def _seeds(_: click.Context, __: click.Parameter, value: str) -> range:
    """Seeds A up to B - 1, as A:B."""
    first, _sign, end = value.partition(":")
    if not (first.isdecimal() and end.isdecimal() and int(first) < int(end) <= SEED_END):
        raise click.BadParameter(
            f"{value!r} is not a range of seeds such as 1:4, which is 1, 2 and 3."
        )
    return range(int(first), int(end))


def roles(topics: str | None) -> dict[str, str]:
    """Names by role, as in ``--topics``; raises ArgumentError unless all parts are ROLE=NAME."""
    pairs = [part.partition("=") for part in topics.split(",")] if topics else []
    if bad := ["".join(pair) for pair in pairs if not all(pair)]:
        raise ArgumentError(f"--topics: {bad[0]!r} must be ROLE=NAME, such as odom=/base/odom.")
    return {role.strip(): name.strip() for role, _, name in pairs}


def logs_and_columns(
    words: Sequence[str], columns: Sequence[str]
) -> tuple[tuple[str, ...], dict[str, str]]:
    """Split a command's words, and those of ``--columns``, into logs and columns by our names.

    Pairs are separated by blanks; raises ArgumentError for a word that is not a pair.
    """
    more = [word for word in words if columns and _PAIR.match(word) and not Path(word).exists()]
    pairs = [part for word in (*columns, *more) for part in re.split(r"\s+(?=[\w\[\]]+=)", word)]
    if bad := [part for part in pairs if not _PAIR.match(part)]:
        raise ArgumentError(f"--columns: {bad[0]!r} must be OURS=THEIRS, such as t=time_ms.")
    named = {name.strip(): theirs.strip() for name, _, theirs in (p.partition("=") for p in pairs)}
    return tuple(word for word in words if word not in more), named


TYPES = {"number": float, "count": click.IntRange(min=1)}
READERS = {"law": one_law, "laws": _each_law, "seed": _seed, "seeds": _seeds}
SUFFIXES = {"runs": RUNS, "plots": PLOTS, "animations": ANIMATIONS}


def command(name: str) -> Callable[[Callable[..., None]], click.Command]:
    """A command with its options, examples and line in the list of all, and ``--debug``.

    Its help is the docstring of its function.
    """
    about = COMMANDS[name]
    examples = "\n".join(("\b", "Examples:", *(f"  {line}" for line in about["examples"])))

    def made(function: Callable[..., None]) -> click.Command:
        item = click.command(
            name,
            params=[_parameter(about, key) for key in about["parameters"]],
            short_help=about["summary"],
            epilog=examples if about["examples"] else None,
        )
        return debug_option(item(function))

    return made


def _parameter(about: Mapping[str, Any], key: str) -> click.Parameter:
    """A parameter of a command: its common properties, and those that this command adds."""
    given = {**COMMANDS["shared"].get(key, {}), **about.get(key, {})}
    if "type" in given:
        given["type"] = TYPES[given["type"]]
    if "choices" in given:
        given["type"] = click.Choice(given.pop("choices"))
    if "reader" in given:
        given["callback"] = READERS[given.pop("reader")]
    if "files" in given:
        names = given.pop("files")
        *others, last = suffixes = SUFFIXES[names] if isinstance(names, str) else tuple(names)
        known = f"{', '.join(others)} or {last}" if others else last
        given["callback"] = partial(_checked, suffixes)
        given["help"] = given["help"].format(files=known)
    if "/" in key:  # neither on nor off
        given["default"] = None
    make = click.Option if key.startswith("-") else click.Argument
    return make(key.split(), **given)


def _checked(
    suffixes: Sequence[str], _: click.Context, option: click.Parameter, path: str | None
) -> str | None:
    """The file that an option names, checked by `check_output` before anything is run."""
    check_output(path, suffixes, option.opts[0])
    return path


def load(scenario: str, assignments: Sequence[str] = (), guard: bool | None = None) -> Scenario:
    """Load a preset or a file, apply ``KEY=VALUE`` texts, and check the scenario.

    ``guard`` switches the velocity guard on or off; None leaves it unchanged.
    """
    from wmr_ctrl.control.given import scenario_of
    from wmr_ctrl.world.scenario import parse_assignments

    return scenario_of(scenario, parse_assignments(assignments), guard)


def law_of(case: Scenario, law: str | None) -> str:
    """The named law, or else the scenario's default, which is announced on stderr."""
    from wmr_ctrl.control.given import default_law

    if law is not None:
        return law
    own = default_law(case)
    say(f"law {own.name}", own.why)
    return own.name


def note_idle(
    case: Scenario, scenario: str, assignments: Sequence[str], laws: Sequence[str]
) -> None:
    """Name on stderr the stated keys that these laws do not read."""
    from wmr_ctrl.world.scenario import parse_assignments
    from wmr_ctrl.world.scenario.toml_io import stated_keys

    from .check_sentences import idle_by_user, unread_k

    if idle := idle_by_user(case, scenario, assignments, laws):
        say("note", f"without effect here: {', '.join(idle)}.")
    for text in unread_k(case, laws, stated_keys(scenario, parse_assignments(assignments))):
        say("note", text)


def check_output(path: str | None, suffixes: Sequence[str], option: str) -> None:
    """Raise if a file cannot be written, has another suffix, or its format lacks a package."""
    from wmr_ctrl.results import check_writable

    if path is None:
        return
    suffix = Path(path).suffix.lower()
    if suffix not in suffixes:
        raise ArgumentError(
            f"{option} {path!r} must end in {' or '.join(suffixes)}: the suffix chooses the format."
        )
    check_writable(path)
    if suffix in RUNS:
        from wmr_ctrl.results.formats import check_format

        check_format(path)


def check_folder(path: str, option: str) -> None:
    """Raise if a folder cannot be made or written to, or is a file; nothing is changed on disk."""
    folder = Path(path)
    if folder.suffix.lower() in (*PLOTS, *ANIMATIONS) and not folder.is_dir():
        raise ArgumentError(
            f"{option} {path!r} is the name of a file, but several files are written, into a "
            f"folder. Name the folder, such as {folder.stem!r}."
        )
    nearest = next(item for item in (folder, *folder.absolute().parents) if item.exists())
    where = f"{option} {path!r}: {nearest}"
    if not nearest.is_dir():
        raise ArgumentError(f"{where} is a file. Name a folder.")
    if not os.access(nearest, os.W_OK | os.X_OK):
        raise ArgumentError(f"{where} may not be written to. Name another folder.")
