"""Reference pages from the program itself: each function returns the Markdown of one part.

They need no Sphinx, so that tests can call them without it.
"""

from __future__ import annotations

import inspect
import tomllib
from collections.abc import Callable, Iterable, Mapping
from importlib import import_module
from importlib.resources import files
from typing import Any

from markdown import code, number, table

import wmr_ctrl
from wmr_ctrl import extend
from wmr_ctrl.cli.lists import gains_docs
from wmr_ctrl.cli.root import root
from wmr_ctrl.control.laws import LAWS
from wmr_ctrl.control.setup import following_gains
from wmr_ctrl.core import errors, signals
from wmr_ctrl.core.fields.section import REQUIRED, Section, quantities
from wmr_ctrl.core.fields.units import OTHERS, USUAL, written
from wmr_ctrl.core.fields.unstated import Unknown, Unstated
from wmr_ctrl.core.fields.values import Quantity, Range
from wmr_ctrl.core.signals import Signal
from wmr_ctrl.results import FIGURES
from wmr_ctrl.results.outcomes import Outcome
from wmr_ctrl.results.remarks import SHORT
from wmr_ctrl.world.references import REFERENCES
from wmr_ctrl.world.registry import EFFECTS
from wmr_ctrl.world.scenario import load_scenario, preset_titles, sections
from wmr_ctrl.world.scenario.sections import Change
from wmr_proofs.paper import equations, symbols


def summary(thing: object) -> str:
    """First paragraph of a docstring, in one line."""
    return " ".join((inspect.getdoc(thing) or "").split("\n\n")[0].split()).replace("``", "`")


# --- the scenario file ---------------------------------------------------------------------------


def scenario_keys() -> str:
    """Every table of a scenario with its fields."""
    parts = [_section(key, cls) for key, cls in sections().items()]
    return "\n\n".join([*parts, _section("changes", Change, "[[changes]]")])


def _section(key: str, cls: type[Section], written: str = "") -> str:
    return "\n\n".join([f"### `{written or f'[{key}]'}`", summary(cls), fields(cls)])


def fields(cls: type[Section]) -> str:
    """A section's fields: key, default, unit, range, meaning."""
    header = ("key", "default", "unit", "range", "meaning")
    return table(header, (_field(name, what) for name, what in quantities(cls)))


def _field(name: str, what: Quantity) -> tuple[str, ...]:
    unknown = what.default is REQUIRED or isinstance(what.default, Unknown)
    follows = isinstance(what.default, Unstated)
    default = code(number(what.default))
    if unknown or follows:
        default = "must be given, see above" if unknown else "follows"
    usual = f"usual {written(what.usual)}" if what.usual else ""
    sides = filter(None, (_range(what.bounds), usual))
    allowed = ", ".join(map(code, what.options)) or "; ".join(sides)
    return code(name), default or "left out", what.unit, allowed, what.doc


def _range(bounds: Range) -> str:
    sides = (
        ("above", bounds.above),
        ("from", bounds.minimum),
        ("below", bounds.below),
        ("to", bounds.maximum),
    )
    return " ".join(f"{word} {value:g}" for word, value in sides if value is not None)


def usual_sizes() -> str:
    """Size from which on `check` asks about a value, and units in which it may have been meant."""
    rows = ((u, written(USUAL[u]), ", ".join(sign for _, sign in OTHERS.get(u, ()))) for u in USUAL)
    return table(("unit", "usual size", "asked for"), rows)


def references() -> str:
    """Every kind of reference with its fields and an example."""
    return "\n\n".join(_reference(kind) for kind in REFERENCES)


def _reference(kind: str) -> str:
    entry = REFERENCES[kind]
    parts = [f'### `kind = "{kind}"`', summary(entry.section), fields(entry.section)]
    example = [f"```toml\n{entry.example.strip()}\n```"] if entry.example else []
    return "\n\n".join(parts + example)


def gains() -> str:
    """Gains of Eq. (7) and of every law."""
    header = ("key", "default", "unit", "meaning")
    return "\n\n".join(
        f"### `[gains.{law}]`\n\n"
        + (f"{LAWS[law].title}.\n\n" if law in LAWS else "The velocities of Eq. (7).\n\n")
        + table(
            header,
            (
                (code(k), "follows" if k in following_gains(law) else code(number(d)), unit, doc)
                for k, (d, unit, doc) in rows.items()
            ),
        )
        for law, rows in gains_docs(load_scenario("paper-simulation")).items()
    )


def presets() -> str:
    """Scenarios in the package (presets)."""
    return table(("preset", "what it is"), ((code(k), v) for k, v in preset_titles().items()))


def laws() -> str:
    """The laws and what they are."""
    return table(("law", "what it is"), ((code(law), LAWS[law].title) for law in LAWS))


def effects() -> str:
    """Sensors, disturbances and drives, with the table that switches them on."""
    rows = ((e.name, e.role.value, code(f"[{e.section.KEY}]"), summary(e.section)) for e in EFFECTS)
    return table(("effect", "role", "table", "what its fields are"), rows)


# --- signals -------------------------------------------------------------------------------------

GROUPS: Mapping[str, str] = {
    "Time and samples": "TIME SAMPLE STEP",
    "True state": "PLANT_STATE PSI TRAVEL SKID PATH",
    "Measured": "MEASURED_POSE MEASURED_VELOCITY ODOMETRY_AGE",
    "Desired motion": "REFERENCE",
    "Torque and force": "TORQUE TORQUE_NOISE BODY_FORCE TAU_APPLIED FORCE",
    "Commands to a base that takes velocities": "COMMAND ASKED SENT_BEFORE",
    "Error and diagnostics": "TRACKING_ERROR DIAGNOSTICS D_HAT",
    "Guard and monitor": "GUARD_DIAGNOSTICS GUARD_ACTED REFUSED",
    "Rigid body": "RIGID",
}
"""Names of `wmr_ctrl.core.signals` by heading; a test checks that none is missing."""


def catalogue() -> dict[str, list[Signal]]:
    """Signals by heading."""
    return {
        head: _flat(getattr(signals, n) for n in names.split()) for head, names in GROUPS.items()
    }


def _flat(items: Iterable[Signal | tuple[Signal, ...]]) -> list[Signal]:
    return [s for item in items for s in ((item,) if isinstance(item, Signal) else item)]


def signal_tables() -> str:
    """The glossary of signals."""
    return "\n\n".join(
        f"### {head}\n\n" + table(("signal", "size", "unit", "meaning"), map(_signal, rows))
        for head, rows in catalogue().items()
    )


def _signal(signal: Signal) -> tuple[str, ...]:
    return code(signal.name), str(signal.size), signal.unit, signal.meaning


def columns() -> str:
    """Columns of every run's log, in order."""
    return ", ".join(code(name) for item in signals.LOG_HEAD for name in item.elements)


def paper_symbols() -> str:
    """The paper's letters and the names that the code has for them."""
    header = ("in the paper", "in the code", "unit", "meaning")
    return table(header, ((s.symbol, code(s.code), s.unit, s.meaning) for s in symbols()))


# --- results -------------------------------------------------------------------------------------


def figures() -> str:
    """Columns of tables of many runs."""
    rows = ((code(c.name), c.unit, c.meaning) for c in FIGURES)
    return table(("column", "unit", "meaning"), rows)


def outcomes() -> str:
    """The words for how a run ended, and the further remarks."""
    ended = ", ".join(code(outcome.value) for outcome in Outcome)
    remarks = table(("remark", "in short"), ((code(key), text) for key, text in SHORT.items()))
    return f"Outcomes: {ended}.\n\n{remarks}"


def failures() -> str:
    """Exceptions that a user can cause."""
    public = (getattr(wmr_ctrl, name) for name in wmr_ctrl.__all__)
    found = [e for e in public if inspect.isclass(e) and issubclass(e, errors.WmrError)]
    return table(("exception", "what it is"), ((code(e.__name__), summary(e)) for e in found))


# --- the paper -----------------------------------------------------------------------------------


def errata() -> str:
    """Equations that are not correct as printed."""
    found = (e for e in equations() if e.status != "as printed")
    return "\n".join(f"- **({e.number}) {e.title}**, *{e.status}.* {e.note}" for e in found)


def readings() -> str:
    """Choices where the paper is silent or unclear."""
    text = files("wmr_ctrl.report").joinpath("readings.toml").read_text(encoding="utf-8")
    return "\n\n".join(map(_reading, tomllib.loads(text)["reading"]))


def _reading(row: Mapping[str, Any]) -> str:
    keys = ", ".join(map(code, row["keys"]))
    said = (("The paper", row["said"]), ("Read as", row["reading"]), ("Why", row["why"]))
    return "\n".join(
        [f"### {row['topic']}", "", *(f"- *{head}:* {text}" for head, text in said)]
        + ([f"- *Keys:* {keys}"] if keys else [])
    )


def errata_count() -> str:
    """Number of equations that are correct as printed, and number of the others."""
    stand = sum(e.status == "as printed" for e in equations())
    fixed = sum(e.status == "corrected" for e in equations())
    rest = len(equations()) - stand - fixed
    return (
        f"Of the {len(equations())} numbered equations {stand} stand as printed, {fixed} had to be "
        f"corrected, {rest} are stated and not needed in that form."
    )


# --- commands and Python -------------------------------------------------------------------------


def commands() -> str:
    """Help of every command, as click prints it."""
    lines = (".. click:: wmr_ctrl.cli.root:root", "   :prog: wmr-ctrl", "   :nested: full")
    return "\n".join(("```{eval-rst}", *lines, "```"))


def command_table() -> str:
    """The commands in one line each."""
    rows = ((f"`wmr-ctrl {name}`", item.short_help or "") for name, item in root.commands.items())
    return table(("command", "what it does"), rows)


def public_names() -> str:
    """Functions of the package, documented."""
    return "\n\n".join(_documented(f"wmr_ctrl.{name}") for name in _public(classes=False))


def results() -> str:
    """Public types: arguments and results of the functions."""
    return "\n\n".join(_documented(f"wmr_ctrl.{name}") for name in _public(classes=True))


def building() -> str:
    """Public names for authors of extensions, without the constants."""
    names = (name for name in extend.__all__ if callable(getattr(extend, name)))
    return "\n\n".join(_documented(f"wmr_ctrl.extend.{name}") for name in names)


def _public(classes: bool) -> list[str]:
    """Public names that are functions, or classes without the exceptions."""
    things = {name: getattr(wmr_ctrl, name) for name in wmr_ctrl.__all__}
    wanted = inspect.isclass if classes else inspect.isfunction
    return [
        name
        for name, thing in things.items()
        if wanted(thing) and not (inspect.isclass(thing) and issubclass(thing, errors.WmrError))
    ]


def _documented(path: str) -> str:
    module, _, name = path.rpartition(".")
    if inspect.isclass(getattr(import_module(module), name)):
        text = f".. autoclass:: {path}\n   :members:"
    else:
        text = f".. autofunction:: {path}"
    return f"```{{eval-rst}}\n{text}\n```"


TABLES: Mapping[str, Callable[[], str]] = {
    "scenario-keys": scenario_keys,
    "usual-sizes": usual_sizes,
    "references": references,
    "gains": gains,
    "presets": presets,
    "laws": laws,
    "effects": effects,
    "signals": signal_tables,
    "columns": columns,
    "symbols": paper_symbols,
    "figures": figures,
    "outcomes": outcomes,
    "errors": failures,
    "readings": readings,
    "errata": errata,
    "errata-count": errata_count,
    "commands": commands,
    "command-table": command_table,
    "public-names": public_names,
    "results": results,
    "building": building,
}
"""Functions that write a part, by the name that pages use."""
