"""FMUs for these tests, each exported once a session."""

import os
import subprocess
import sys
from functools import cache
from pathlib import Path

import pytest
from fmpy import extract

from tests.export.cosim.foreign import CONTROLLER, CONTROLLER_MAP, PLANT, PLANT_MAP
from tests.export.fmi.raw import Fmu
from wmr_ctrl.export.fmi.fmu_files import export_fmu

MADE = "WMR_TESTS_FMUS"
"""Environment variable that names a folder of FMUs which are taken as they are."""


@pytest.fixture(scope="session")
def exported(tmp_path_factory):
    """A function (what, version, scenario, law) -> path of that FMU."""
    ready = Path(os.environ.get(MADE, "nowhere"))

    @cache
    def export(what, version, scenario="paper-simulation", law="nn", **options):
        made = ready / f"wmr_{what}.fmi{version}.fmu"
        if made.is_file():
            return made
        out = tmp_path_factory.mktemp("fmu")
        return export_fmu(what, law=law, scenario=scenario, fmi=version, out=out, **options)[0]

    return export


@pytest.fixture(scope="session")
def raw(exported, tmp_path_factory):
    """Export an FMU and load its library, which is driven without FMPy's help."""

    @cache
    def load(what, version, *given, **options):
        path = exported(what, version, *given, **options)
        return Fmu(path, extract(str(path), str(tmp_path_factory.mktemp("unpacked"))), version)

    return load


@pytest.fixture(scope="session")
def foreign(tmp_path_factory):
    """A function: source text of a PythonFMU slave -> its FMU, built once by that exporter."""
    pytest.importorskip("pythonfmu", reason="PythonFMU builds the foreign FMUs")

    @cache
    def build(name, text):
        folder = tmp_path_factory.mktemp("foreign")
        source = folder / f"{name}.py"
        source.write_text(text, "utf-8")
        command = [sys.executable, "-m", "pythonfmu", "build", "-f", str(source), "-d", str(folder)]
        subprocess.run(command, check=True, capture_output=True)
        return next(folder.glob(f"{name}.fmu"))

    return build


@pytest.fixture
def mapped(tmp_path):
    """A function: text of a map -> its file."""

    def write(text):
        path = tmp_path / "map.toml"
        path.write_text(text, "utf-8")
        return path

    return write


@pytest.fixture
def their_plant(foreign, mapped):
    """Somebody else's plant, and its map."""
    return {"plant": foreign("TheirRobot", PLANT), "map_file": mapped(PLANT_MAP)}


@pytest.fixture
def their_controller(foreign, mapped):
    """Somebody else's controller, and its map."""
    return {
        "controller": foreign("TheirController", CONTROLLER),
        "map_file": mapped(CONTROLLER_MAP),
    }
