"""The public interface as lines of text, and docs/reference/stable.txt, which promises them.

``python -m tests.packaging.interface`` adds new names to that file and removes none.
"""

import inspect
import json
import re
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from pathlib import Path

import click
from click.testing import CliRunner

import wmr_ctrl
from tests.architecture.tree import ROOT
from wmr_ctrl import extend
from wmr_ctrl.cli import console
from wmr_ctrl.cli.lists import gains_docs
from wmr_ctrl.cli.root import root
from wmr_ctrl.control.laws import LAWS
from wmr_ctrl.control.setup import settle
from wmr_ctrl.core import signals
from wmr_ctrl.core.fields.section import quantities
from wmr_ctrl.export.fmi.blocks import guard_model, law_model, plant_model, reference_model
from wmr_ctrl.export.fmi.closed_loop import closed_loop_model
from wmr_ctrl.results.figures import FIGURES
from wmr_ctrl.results.outcomes import Outcome
from wmr_ctrl.results.remarks import SHORT
from wmr_ctrl.world.references import REFERENCES
from wmr_ctrl.world.scenario import load_scenario, preset_names
from wmr_ctrl.world.scenario.scenario import sections
from wmr_ctrl.world.scenario.sections import Change

STABLE = ROOT / "docs" / "reference" / "stable.txt"
GROUPS = ("effects", "figures", "laws", "references")
CODES = ("DIFFERENCE", "WRONG_INPUT", "FMU_FAILED", "FAULT", "INTERRUPTED", "BROKEN_PIPE")
SHORT_RUN = ("--set", "clock.duration=0.2")
DOCUMENTS = {
    "run": ("run", "safe-simulation", "--law", "prox", "--engine", "numpy", *SHORT_RUN),
    "check": ("check", "safe-simulation", "--law", "prox", *SHORT_RUN),
    "linearize": ("linearize", "paper-simulation-nominal", "--law", "pid"),
}
"""Commands whose JSON is written down, with arguments that cost little."""
OPEN = ("figures", "provenance", "sources")
"""Keys below which others may come and go, or which are listed by themselves."""


def lines():
    """Every name that a script, a file or another package may use."""
    yield from _commands(root, "wmr-ctrl")
    yield from (f"exit code {getattr(console, name)}: {name}" for name in CODES)
    yield from _scenario()
    for word, names in (
        ("preset", preset_names()),
        ("law", LAWS),
        ("figure", (item.heading for item in FIGURES)),
        ("outcome", Outcome),
        ("remark", SHORT),
        ("column", (name for item in signals.LOG_HEAD for name in item.elements)),
        ("entry points", (f"wmr_ctrl.{name}" for name in GROUPS)),
    ):
        yield from (f"{word}: {name}" for name in names)
    for name, command in DOCUMENTS.items():
        yield from (f"{name} --json: {key}" for key in _keys(_document(*command)))
    yield from _python()
    yield from _headers()
    yield from _variables()


def _commands(command, name):
    yield f"command: {name}"
    for item in command.params:
        yield from (f"option: {name} {form}" for form in (*item.opts, *item.secondary_opts))
    if isinstance(command, click.Group):
        for child, below in command.commands.items():
            yield from _commands(below, f"{name} {child}")


def _scenario():
    yield from (f"scenario: {name}" for name in ("title", "frames", "assumed"))
    kinds = {f'reference (kind = "{kind}")': REFERENCES[kind].section for kind in REFERENCES}
    for place, section in {**sections(), "changes": Change, **kinds}.items():
        yield from (f"scenario: {place}.{name}" for name, _ in quantities(section))
    for law, gains in gains_docs(load_scenario("paper-simulation")).items():
        yield from (f"scenario: gains.{law}.{name}" for name in gains)


def _document(*command):
    done = CliRunner().invoke(root, [*command, "--json"])
    assert done.exit_code == 0, done.output
    return json.loads(done.stdout)


def _keys(value, path=""):
    """Keys of a document; names of laws among them as LAW, elements of lists as []."""
    if isinstance(value, list) and value:
        yield from _keys(value[0], f"{path}[]")
    elif isinstance(value, Mapping):
        for key, item in value.items():
            name = f"{path}.{'LAW' if key in LAWS else key}".lstrip(".")
            yield name
            yield from () if key in OPEN else _keys(item, name)


def _python():
    for module in (wmr_ctrl, extend):
        for name in module.__all__:
            yield from _members(f"{module.__name__}.{name}", getattr(module, name))


def _members(path, thing):
    """Name, arguments by name, and of a class its fields, methods and properties."""
    yield f"python: {path}"
    if not inspect.isclass(thing):
        if not inspect.isfunction(thing):  # a constant, or CasADi
            return
        yield from (f"python: {path}({name})" for name in inspect.signature(thing).parameters)
        return
    own = {item.name for item in fields(thing)} if is_dataclass(thing) else set[str]()
    own |= {name for each in thing.__mro__[:-1] for name in vars(each)}
    for name in sorted(item for item in own if not item.startswith("_")):
        yield f"python: {path}.{name}"
        member = inspect.getattr_static(thing, name, None)
        if inspect.isfunction(member):
            given = [item for item in inspect.signature(member).parameters if item != "self"]
            yield from (f"python: {path}.{name}({argument})" for argument in given)


def _headers():
    """Functions and struct members of the committed generated packages."""
    for header in sorted((ROOT / "fmu" / "golden" / "c").glob("*-double/wmr_*.h")):
        code = re.sub(r"/\*.*?\*/", "", header.read_text("utf-8"), flags=re.DOTALL)
        names = re.findall(r"wmr_real (\w+)(?:\[\d+\])?;|\b(wmr_\w+)\(|\} (\w+);", code)
        yield from (f"C, {header.name}: {''.join(found)}" for found in names)


def _variables():
    """Variables of FMUs, except elements that follow from a vector's size."""
    case = load_scenario("safe-simulation")
    setup = settle(case, "nn")
    models = plant_model(case), reference_model(case), law_model(setup), guard_model(setup)
    for model in (*models, closed_loop_model(setup)):
        yield from (f"FMU, {model.what}: {item.name}" for item in model.variables)


def promised():
    """The lines of the committed file."""
    return STABLE.read_text("utf-8").splitlines()


def main():
    """Add new names."""
    known = promised() if Path(STABLE).exists() else []
    every = sorted({*known, *lines()})
    STABLE.write_text("\n".join(every) + "\n", "utf-8")
    print(f"{len(every) - len(known)} new, {len(every)} in all: {STABLE}")


if __name__ == "__main__":
    main()
