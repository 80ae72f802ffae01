"""Loading of scenarios: presets by name, users' files by path, both with ``extends``."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from copy import deepcopy
from functools import lru_cache
from pathlib import Path

from wmr_ctrl.errors import ScenarioError, UnknownNameError
from wmr_ctrl.fields.arguments import checks_arguments
from wmr_ctrl.fields.files import decode, parse_toml, read_text
from wmr_ctrl.fields.problems import show
from wmr_ctrl.scenario.merge import Raw, merge
from wmr_ctrl.scenario.overrides import absolute, apply
from wmr_ctrl.scenario.presets import SUFFIX, preset_names, preset_text
from wmr_ctrl.scenario.raw import from_dict
from wmr_ctrl.scenario.scenario import Scenario


@checks_arguments
def load_scenario(
    name_or_path: str | os.PathLike[str], overrides: Mapping[str, object] | None = None
) -> Scenario:
    """Return a preset, or the scenario of a TOML file, with ``overrides`` put on it.

    A text is a path if it ends in ``.toml``, holds a separator, or names an existing file that is
    no preset.  The scenario is named after the preset or the file's stem.  Overrides map keys such
    as ``"clock.duration"`` to TOML text or plain values.

    Raises UnknownNameError for a preset that does not exist, ScenarioError for anything that is
    wrong inside; the message starts with the file or the key.
    """
    source = os.fspath(name_or_path)
    raw = _resolved(source, Path(), ())
    if "scenario" in raw:
        raise ScenarioError(
            f"{source} is a plan of a study, no scenario: it names one. Run it by `wmr-ctrl study "
            f"{source} --out FOLDER`, or give the scenario that it names."
        )
    name = Path(source).stem if is_path(source) else source
    with naming_file(source, overrides or {}):
        return from_dict(apply(raw, overrides or {}), name)


@contextmanager
def naming_file(source: object, overrides: Mapping[str, object]) -> Iterator[None]:
    """End an error in what a file says with the file's name; those of overrides stay as they are.

    ``source`` may be anything else than a file's path; then nothing is added.
    """
    try:
        yield
    except (ScenarioError, UnknownNameError) as error:
        said, file = str(error), os.fspath(source) if isinstance(source, str | os.PathLike) else ""
        ours = any(said.startswith(key.partition("[")[0]) for key in overrides)
        if isinstance(file, str) and file and is_path(file) and file not in said and not ours:
            error.args = (f"{said} (In {file}.)",)
        raise


@checks_arguments
def loads_scenario(
    text: str | bytes, name: str = "unnamed", folder: str | os.PathLike[str] = "."
) -> Scenario:
    """Return the scenario of TOML text; relative files in it are relative to ``folder``."""
    if isinstance(text, bytes):
        text = decode(text, name)
    return from_dict(_extended(parse(text, name), Path(folder), ()), name)


def is_path(source: str) -> bool:
    """Tell whether a text is the path of a scenario's file, not a preset's name."""
    separators = [os.sep, os.altsep or os.sep]
    if source.endswith(SUFFIX) or any(separator in source for separator in separators):
        return True
    return source not in preset_names() and os.path.exists(source)


def parse(text: str, what: str | Path) -> Raw:
    """Return TOML text as a dictionary; errors start with ``what``."""
    remedy = "`wmr-ctrl scenarios paper-simulation --toml` prints a valid scenario to start from."
    return parse_toml(text, what, remedy)


def _resolved(source: str, folder: Path, seen: tuple[str, ...]) -> Raw:
    """Return the raw dictionary of a preset or file with everything that it extends."""
    if not is_path(source):
        return _extended(deepcopy(_preset(source)), folder, (*seen, source))
    path = folder / source
    mark = os.path.abspath(path) if "\0" not in source else source
    if mark in seen:
        raise ScenarioError(f"extends = {show(source)} leads back to the same file: {path.name}.")
    return _extended(parse(read_text(path, "scenario"), path), path.parent, (*seen, mark))


@lru_cache
def _preset(name: str) -> Raw:
    """The dictionary of a preset, read once."""
    return parse(preset_text(name), name)


def _extended(raw: Raw, folder: Path, seen: tuple[str, ...]) -> Raw:
    reference = raw.get("reference")
    if isinstance(reference, dict) and "file" in reference:
        reference["file"] = absolute(reference["file"], folder)
    if "extends" not in raw:
        return raw
    base = raw.pop("extends")
    if not isinstance(base, str):
        raise ScenarioError(
            f"extends = {show(base)} must be a preset's name or a TOML file's path."
        )
    return merge(_resolved(base, folder, seen), raw)
