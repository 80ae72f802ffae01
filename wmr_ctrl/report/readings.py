"""What had to be read into the paper, from the file beside this one."""

from __future__ import annotations

import tomllib
from importlib.resources import files
from typing import Any


def load_readings() -> list[dict[str, Any]]:
    """Entries with ``topic``, ``said``, ``reading``, ``why`` and the scenario's ``keys``."""
    text = files("wmr_ctrl.report").joinpath("readings.toml").read_text(encoding="utf-8")
    return list(tomllib.loads(text)["reading"])
