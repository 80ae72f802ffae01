"""Words and numbers that are data, in TOML files beside the modules that read them."""

import tomllib
from importlib.resources import files
from typing import Any


def data(package: str, name: str) -> dict[str, Any]:
    """The table in the file ``name`` of a package."""
    return tomllib.loads(files(package).joinpath(name).read_text(encoding="utf-8"))
