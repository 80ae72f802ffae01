"""Scenarios as TOML: presets by name, users' files by path, both with ``extends``, and out again.

What is written is complete, each field with its unit and meaning as a comment.
"""

import hashlib
import os
import tomllib
from collections.abc import Container, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import lru_cache
from importlib.resources import files
from pathlib import Path
from typing import Any, TypeAlias

import tomlkit
from tomlkit.items import Item, Table

from wmr_ctrl.core.errors import ScenarioError, UnknownNameError, show
from wmr_ctrl.core.fields.arguments import checks_arguments
from wmr_ctrl.core.fields.files import AnyPath, decode, parse_toml, read_text
from wmr_ctrl.core.fields.orientation import PAPER, described, field_outward
from wmr_ctrl.core.fields.section import Section, quantities
from wmr_ctrl.core.fields.unstated import Unstated
from wmr_ctrl.world.references import REFERENCES

from .raw import (
    Raw,
    apply,
    copied,
    frames_of,
    from_dict,
    in_frames,
    merge,
    raw_with_units,
    scenario_dict,
    stated_in,
    with_defaults,
)
from .scenario import OTHER_KEYS, Scenario, sections
from .sections import Change
from .unstated import KIND, guessed_keys

_SUFFIX = ".toml"
_PRESETS = files("wmr_ctrl.world.scenario") / "presets"


@lru_cache(maxsize=1)
def preset_names() -> tuple[str, ...]:
    """Return the names of all presets; the paper's come first."""
    names = (item.name for item in _PRESETS.iterdir() if item.is_file())
    presets = [name.removesuffix(_SUFFIX) for name in names if name.endswith(_SUFFIX)]
    return tuple(sorted(presets, key=lambda name: (not name.startswith("paper"), name)))


@lru_cache
def preset_titles() -> Mapping[str, str]:
    """Return the one-line title of every preset, by name."""
    return {name: str(tomllib.loads(_preset_text(name))["title"]) for name in preset_names()}


def title_of(scenario: Scenario) -> str:
    """A scenario's title; for a modified preset, also which preset that is."""
    named = [name for name, title in preset_titles().items() if title == scenario.title]
    if not named or replace(scenario, name=named[0]) == load_scenario(named[0]):
        return scenario.title
    return f"{named[0]}, changed"


def _no_scenario(name: str) -> ScenarioError:
    """Error for a file whose name does not end in .toml."""
    return ScenarioError(f"{name} must end in {_SUFFIX}: a scenario is a TOML file.")


def _preset_text(name: str) -> str:
    """A preset's TOML text; raises UnknownNameError, which lists the near names."""
    if name not in preset_names():
        if Path(name).suffix:
            raise _no_scenario(name)
        remedy = "A file of your own is named by its path, such as ./mine.toml."
        raise UnknownNameError("scenario", name, preset_names(), remedy)
    return (_PRESETS / (name + _SUFFIX)).read_text(encoding="utf-8")


@checks_arguments
def load_scenario(name_or_path: AnyPath, overrides: Mapping[str, object] | None = None) -> Scenario:
    """Return a preset, or the scenario of a TOML file, with ``overrides`` applied.

    A text is a path if it ends in ``.toml``, contains a separator, or names an existing file and
    no preset.  The scenario is named after the preset or the file's stem.  Overrides map keys such
    as ``"clock.duration"`` to TOML text or plain values.

    Raises UnknownNameError for a preset that does not exist, and ScenarioError for anything wrong
    inside; the message starts with the file or the key.
    """
    source = os.fspath(name_or_path)
    raw = _resolved(source, Path(), ())
    if "scenario" in raw:
        raise ScenarioError(
            f"{source} is a study plan, not a scenario. Run it with `wmr-ctrl study {source} --out "
            "FOLDER`, or give the scenario that it names."
        )
    name = Path(source).stem if is_path(source) else source
    with naming_file(source, overrides or ()):
        return from_dict(apply(raw, overrides or {}), name)


@contextmanager
def naming_file(source: object, overrides: Iterable[str] = ()) -> Iterator[None]:
    """Context that appends the file's name to an error, unless an override caused it.

    If ``source`` is not a file's path, nothing is appended.
    """
    try:
        yield
    except (ScenarioError, UnknownNameError) as error:
        said, file = str(error), os.fspath(source) if isinstance(source, str | os.PathLike) else ""
        ours = any(said.startswith(key.partition("[")[0]) for key in overrides)
        named = file in said or "(In " in said  # a plan's scenario names its own
        if isinstance(file, str) and is_path(file) and not (ours or named):
            error.args = (f"{said} (In {file}.)",)
        raise


@checks_arguments
def loads_scenario(text: str | bytes, name: str = "unnamed", folder: AnyPath = ".") -> Scenario:
    """Return the scenario of TOML text; relative files in it are relative to ``folder``."""
    if isinstance(text, bytes):
        text = decode(text, name)
    return from_dict(_extended(_parse(text, name), Path(folder), ()), name)


def is_path(source: str) -> bool:
    """Tell whether a text is the path of a scenario's file, not a preset's name."""
    separators = [os.sep, os.altsep or os.sep]
    if source.endswith(_SUFFIX) or any(separator in source for separator in separators):
        return True
    return source not in preset_names() and os.path.exists(source)


def _parse(text: str, what: str | Path) -> Raw:
    remedy = "`wmr-ctrl scenarios paper-simulation --toml` prints a valid scenario to start from."
    return raw_with_units(parse_toml(text, what, remedy))


def _resolved(source: str, folder: Path, seen: tuple[str, ...]) -> Raw:
    """Return the raw dictionary of a preset or file with everything that it extends."""
    if not is_path(source):
        return _extended(copied(_preset(source)), folder, (*seen, source))
    path = folder / source
    mark = os.path.abspath(path) if "\0" not in source else source
    if mark in seen:
        way = " -> ".join(Path(one).name for one in (*seen[seen.index(mark) :], mark))
        raise ScenarioError(
            f"extends = {show(source)} leads back to where it came from: {way}. Take one of them "
            "out."
        )
    if path.suffix != _SUFFIX and path.suffix:
        raise _no_scenario(source)
    text = read_text(path, "scenario")
    return _extended(_parse(text, path), path.parent, (*seen, mark))


@lru_cache
def _preset(name: str) -> Raw:
    """The dictionary of a preset, read once."""
    return _parse(_preset_text(name), name)


def _extended(raw: Raw, folder: Path, seen: tuple[str, ...]) -> Raw:
    reference = raw.get("reference")
    if isinstance(reference, dict) and isinstance(reference.get("file"), str):
        reference["file"] = str(folder / reference["file"])
    law = raw.get("law")
    if isinstance(law, str) and law.endswith(".py"):
        raw["law"] = str(folder / law)
    if "extends" not in raw:
        return raw
    base = raw.pop("extends")
    if not isinstance(base, str):
        raise ScenarioError(
            f"extends = {show(base)} must be a preset's name or a TOML file's path."
        )
    extended = _resolved(base, folder, seen)
    return merge(in_frames(extended, raw.get("frames", frames_of(extended))), raw)


@dataclass(frozen=True)
class InheritedValue:
    """A field that nobody states: key, value in effect, unit, meaning."""

    key: str
    value: object
    unit: str
    doc: str


def inherited(scenario: Scenario) -> tuple[InheritedValue, ...]:
    """Fields that the scenario lists as assumed, and unstated fields of the base."""
    values = []
    for key in dict.fromkeys((*scenario.assumed, *guessed_keys(scenario))):
        table, _, name = key.partition(".")
        if key == KIND:
            kind = scenario.reference_kind.name
            values.append(InheritedValue(KIND, kind, "", "kind of the desired motion"))
            continue
        what = dict(quantities(sections()[table]))[name]
        stated = getattr(scenario.table(table), name)
        value = field_outward(stated, what.orientation, scenario.frames)
        doc = described(what.doc, scenario.frames)
        values.append(InheritedValue(key, value, what.unit, doc))
    return tuple(values)


def raw_of(source: str) -> Raw:
    """Raw dictionary of a preset or file, including everything that it extends."""
    return _resolved(source, Path(), ())


def notes(source: str) -> dict[str, str]:
    """Comments beside the keys of a preset or file and of its bases; the nearest file takes
    precedence.
    """
    text = read_text(Path(source), "scenario") if is_path(source) else _preset_text(source)
    document, found = tomlkit.parse(text), dict[str, str]()
    if base := document.get("extends"):
        found = notes(str(Path(source).parent / base) if is_path(base) else base)
    tables = ((name, part) for name, part in document.items() if isinstance(part, Table))
    items = ((f"{name}.{key}", item) for name, part in tables for key, item in part.items())
    return found | {
        key: item.trivia.comment.lstrip("# ") for key, item in items if isinstance(item, Item)
    }


def stated_keys(source: str, overridden: Iterable[str] = ()) -> set[str]:
    """Keys stated by overrides, by the file ``source`` or files that it extends; not presets."""
    keys = {key.partition("[")[0] for key in overridden}
    return keys | _stated(Path(source)) if is_path(source) else keys


def _stated(file: Path) -> set[str]:
    """Keys of a file that was loaded before, and of the files that it extends."""
    raw = _parse(read_text(file, "scenario"), file)
    keys = stated_in(raw)
    base = raw.get("extends")
    return keys | _stated(file.parent / base) if isinstance(base, str) and is_path(base) else keys


GainsDocs: TypeAlias = Mapping[str, Mapping[str, tuple[Any, str, str]]]
"""By law and gain: default value, unit, meaning."""
MARK = "YOURS?"
"""Begins the comment on a value that is of the scenario's robot, path or gains, and no default."""
ORDER = ("robot", "model", "limits", "gains", "initial", "reference")


def to_toml(
    scenario: Scenario,
    comments: bool = True,
    gains_docs: GainsDocs | None = None,
    only: Container[str] | None = None,
    marked: bool = False,
) -> str:
    """Return TOML text that loads back to an equal scenario (the name is the file's).

    ``gains_docs``: the laws' gains; those that the scenario does not state are then also written,
    with their defaults, so that the text holds every gain of a run.  ``only``: keys to write, in
    addition to those whose values differ from the defaults.  ``marked``: comments on values that
    differ from the defaults begin with `MARK`.
    """
    mark = f"{MARK} " * marked
    raw: dict[str, Any] = scenario_dict(scenario)
    if only is not None:
        raw = _sparse(raw, scenario, only)
    document = tomlkit.document()
    document.add("title", tomlkit.item(scenario.title))
    _add_or_tell(
        document,
        "law",
        scenario.law,
        f"{mark * bool(scenario.law)}law that drives where none is named" * comments,
    )
    if comments or "frames" in raw:
        note = "how orientations are stated: paper (0 along +Y), rep103 (0 along +X)"
        _add(document, "frames", scenario.frames, note * comments)
    if scenario.assumed:
        note = "keys that nobody stated; take one away when you have stated it"
        _add(document, "assumed", list(scenario.assumed), note * comments)
    rest = [key for key in raw if key not in (*ORDER, *OTHER_KEYS)]
    for key in (*(key for key in ORDER if key in raw), *rest):
        if key == "gains":
            document.add(key, _gains(raw[key], gains_docs or {}, comments, mark))
            continue
        table = tomlkit.table()
        if key == "reference":
            _add(
                table, "kind", raw[key]["kind"], f"{mark}one of {', '.join(REFERENCES)}" * comments
            )
        part = scenario.model if key == "model" else scenario.table(key)
        _fields(table, part, raw[key], comments, scenario.frames, only is None, mark)
        document.add(key, table)
    if raw["changes"]:
        array = tomlkit.aot()
        for change, values in zip(scenario.changes, raw["changes"], strict=True):
            array.append(_fields(tomlkit.table(), change, values, comments, mark=mark))
        document.add("changes", array)
    elif comments and only is None:
        head = "[[changes]]  # one such table for each sudden change; none here"
        fields = (f"{name} = ...  # {_note(w.unit, w.doc)}" for name, w in quantities(Change))
        document.add(tomlkit.nl())
        for line in (head, *fields):
            document.add(tomlkit.comment(line))
    return tomlkit.dumps(document)


LATER = (
    "changing = false",
    "free_age = 0.2",
    "nearing = 0.0",
    "leave = 1",
    "\n[world]\nobstacles = []\nwall = []",
)
"""Lines that a hash leaves out: keys that came later, with values that change nothing."""


@lru_cache(maxsize=64)
def scenario_hash(scenario: Scenario) -> str:
    """First 16 digits of the SHA-256 of the scenario as TOML without comments."""
    text = to_toml(scenario, comments=False)
    for line in LATER:
        text = text.replace(f"{line}\n", "")
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def _sparse(raw: Mapping[str, Any], scenario: Scenario, only: Container[str]) -> dict[str, Any]:
    """The keys in ``only``, and those whose values differ from the defaults."""
    kind = {"kind": scenario.reference_kind.name}
    defaults: Raw = with_defaults({"frames": scenario.frames, "reference": kind}, raw)
    sparse: dict[str, Any] = {}
    for table, part in raw.items():
        usual = defaults.get(table)
        if isinstance(part, dict) and isinstance(usual, dict):
            part = {
                name: value
                for name, value in part.items()
                if f"{table}.{name}" in only or usual.get(name) != value
            }
        if table == "reference":
            part = kind | part
        if part or table in (*scenario.effects, "changes"):
            sparse[table] = part
    return sparse


def _fields(
    table: Table,
    part: Section,
    raw: Mapping[str, Any],
    comments: bool,
    frames: str = PAPER,
    tell: bool = True,
    mark: str = "",
) -> Table:
    """Fields of a section that are in ``raw``; with ``tell``, the others as comments."""
    for name, what in quantities(type(part)):
        usual = vars(part)[name] == what.default and not isinstance(what.default, Unstated)
        own = mark * (name in raw and not usual)
        note = own + _note(what.unit, described(what.doc, frames)) if comments else ""
        if tell or name in raw:
            _add_or_tell(table, name, raw.get(name), note)
    return table


def _note(unit: str, doc: str) -> str:
    return f"[{unit}] {doc}" if unit else doc


def _add_or_tell(table: Table | tomlkit.TOMLDocument, name: str, value: Any, note: str) -> None:
    """Add a field, or a comment for an omitted one if comments are on."""
    if value is not None:
        _add(table, name, value, note)
    elif note:
        table.add(tomlkit.comment(f"{name} = ...  # {note}"))


def _add(table: Table | tomlkit.TOMLDocument, name: str, value: Any, note: str) -> None:
    item = tomlkit.item(value)
    if isinstance(value, list) and len(value) > 2 and isinstance(value[0], list):
        item.multiline(True)
    if note:
        item.comment(note)
    table.add(name, item)


def _gains(raw: Mapping[str, Any], docs: GainsDocs, comments: bool, mark: str) -> Table:
    gains = tomlkit.table(is_super_table=bool(docs or raw))
    for law in dict.fromkeys([*docs, *raw]):
        table = tomlkit.table()
        known = docs.get(law, {})
        for name in dict.fromkeys([*known, *raw.get(law, {})]):
            default, unit, doc = known.get(name, (None, "", ""))
            stated = raw.get(law, {})
            value = stated.get(name, default)
            listed = list(value) if isinstance(value, tuple) else value
            note = mark * (name in stated) + _note(unit, doc)
            _add_or_tell(table, name, listed, note * comments)
        gains.add(law, table)
    if comments and not gains:
        gains.add(
            tomlkit.comment("by law, as in [gains.mb]; those left out are the law's defaults")
        )
    return gains
