"""FMUs for these tests, each exported once a session."""

import os
import subprocess
import sys
from functools import cache
from pathlib import Path

import pytest
from fmpy import extract

from tests.export.fmi.raw import Fmu
from wmr_ctrl.export.fmi.fmu_files import export_fmu

MADE = "WMR_TESTS_FMUS"
"""Environment variable that names a folder of FMUs which are taken as they are."""


@pytest.fixture(scope="session")
def exported(tmp_path_factory):
    """A function (what, version, scenario, law) -> path of that FMU."""
    made = {}

    def export(what, version, scenario="paper-simulation", law="nn"):
        key = (what, str(version), scenario, law)
        if key not in made:
            ready = Path(os.environ.get(MADE, "")) / f"wmr_{what}.fmi{version}.fmu"
            if MADE in os.environ and ready.is_file():
                return ready
            out = tmp_path_factory.mktemp("fmu")
            (made[key],) = export_fmu(what, law=law, scenario=scenario, fmi=version, out=out)
        return made[key]

    return export


@pytest.fixture(scope="session")
def raw(exported, tmp_path_factory):
    """A function (what, version) -> the FMU's library, driven without FMPy's help."""
    made = {}

    def load(what, version):
        if (what, version) not in made:
            path = exported(what, version)
            folder = extract(str(path), str(tmp_path_factory.mktemp("unpacked")))
            made[what, version] = Fmu(path, Path(folder), version)
        return made[what, version]

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
