"""Texts and numbers that are data, in TOML files beside the modules that read them."""

import tomllib
from collections.abc import Mapping
from importlib.resources import files
from typing import Any


def data(package: str, name: str) -> dict[str, Any]:
    """The table in the file ``name`` of a package."""
    return tomllib.loads(files(package).joinpath(name).read_text(encoding="utf-8"))


def with_tuples(row: Mapping[str, Any]) -> dict[str, Any]:
    """A table as arguments of a frozen dataclass: its arrays as tuples."""
    return {key: tuple(value) if isinstance(value, list) else value for key, value in row.items()}
