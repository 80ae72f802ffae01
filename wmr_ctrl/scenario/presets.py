"""The scenarios that come with the package: TOML files in the folder ``presets``."""

from __future__ import annotations

import tomllib
from functools import lru_cache
from importlib.resources import files
from importlib.resources.abc import Traversable

from wmr_ctrl.errors import UnknownNameError

SUFFIX = ".toml"


def _folder() -> Traversable:
    return files("wmr_ctrl.scenario") / "presets"


@lru_cache(maxsize=1)
def preset_names() -> tuple[str, ...]:
    """Return the names of all presets, those of the paper first."""
    names = [item.name.removesuffix(SUFFIX) for item in _folder().iterdir()]
    presets = [name for name in names if (_folder() / (name + SUFFIX)).is_file()]
    return tuple(sorted(presets, key=lambda name: (not name.startswith("paper"), name)))


def preset_text(name: str) -> str:
    """Return a preset's TOML text; raises UnknownNameError, which lists the near names."""
    if name not in preset_names():
        remedy = "A file of your own is named by its path, such as ./mine.toml."
        raise UnknownNameError("scenario", name, preset_names(), remedy)
    return (_folder() / (name + SUFFIX)).read_text(encoding="utf-8")


def preset_titles() -> dict[str, str]:
    """Return the one-line title of every preset, by name."""
    return {name: str(tomllib.loads(preset_text(name))["title"]) for name in preset_names()}
