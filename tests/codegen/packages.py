"""Packages of C in a folder, as `wmr-ctrl codegen` writes them."""

from __future__ import annotations

from pathlib import Path

from wmr_ctrl.codegen.package import package_files
from wmr_ctrl.results import write_all
from wmr_ctrl.world.scenario import Scenario


def write_package(law: str, out: Path, scenario: Scenario, *, float32: bool = False) -> list[Path]:
    return write_all(package_files(law, scenario, float32=float32), out)
