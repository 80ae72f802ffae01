"""Contents of the archives; the wheel works where no source tree is near."""

import json
import tarfile
import zipfile
from pathlib import Path

import pytest

from tests.architecture.tree import ROOT
from tests.commands import flat

pytestmark = pytest.mark.slow

UNWANTED = (".so", ".dll", ".dylib", ".o", ".pyc", ".fmu")
PLACES = {
    "wmr_ctrl": "wmr_ctrl",
    "wmr_proofs": "wmr_proofs",
    "fmu": "wmr_ctrl/_fmu",
    "benchmarks": "wmr_ctrl/_benchmarks",
}
"""Folders of the tree, and of the package that is installed."""


def test_wheel_has_package_data_and_nothing_else(built):
    with zipfile.ZipFile(next(built.glob("*.whl"))) as wheel:
        names = wheel.namelist()

    kept = {
        f"{place}/{path.relative_to(ROOT / folder).as_posix()}"
        for folder, place in PLACES.items()
        for path in (ROOT / folder).rglob("*")
        if path.is_file() and not path.name.endswith(UNWANTED)
    }
    assert {name for name in names if ".dist-info/" not in name} == kept
    tops = {name.split("/")[0] for name in names}
    assert {top for top in tops if not top.endswith(".dist-info")} == {"wmr_ctrl", "wmr_proofs"}
    assert any(name.endswith("licenses/LICENSE") for name in names)
    assert [name for name in names if name.endswith(UNWANTED)] == []


def test_a_wheel_for_any_machine_asks_for_the_compiler(built):
    with zipfile.ZipFile(next(built.glob("*.whl"))) as wheel:
        (name,) = [item for item in wheel.namelist() if item.endswith(".dist-info/METADATA")]
        lines = wheel.read(name).decode().splitlines()

    needed = [line for line in lines if line.startswith("Requires-Dist") and "extra ==" not in line]
    assert [line for line in needed if "ziglang" in line]
    assert [line for line in needed if "fmpy" in line]


def test_source_archive_has_tests_and_c_but_no_build_products(built):
    with tarfile.open(next(built.glob("*.tar.gz"))) as archive:
        names = [name.partition("/")[2] for name in archive.getnames()]

    for wanted in ("tests/conftest.py", "fmu/runtime/loop.c", "docs/architecture.md", "LICENSE"):
        assert wanted in names
    assert [name for name in names if name.endswith(UNWANTED)] == []


def test_installed_package_is_used_not_the_tree(installed):
    script = "import wmr_ctrl; print(wmr_ctrl.__version__, wmr_ctrl.__file__, sep='|')"
    version, _, path = installed.run("-c", script, program="python").stdout.strip().partition("|")

    assert Path(path).is_relative_to(installed.folder)
    assert version in installed.run("--version").stdout
    laws = json.loads(installed.run("laws", "--json").stdout)
    assert {law["name"] for law in laws} >= {"pid", "smc", "mb", "nn"}


def test_without_a_compiler_on_path_a_run_is_compiled_by_zig(installed):
    pytest.importorskip("ziglang")

    done = installed.run("run", "paper-simulation", "--law", "mb", "--json")

    assert done.returncode == 0, done.stdout + done.stderr
    assert json.loads(done.stdout)["engine"] == "native"


def test_without_any_compiler_the_message_helps_and_numpy_runs(installed, tmp_path):
    broken = {"WMR_CTRL_CC": "no-such-compiler", "WMR_CTRL_CACHE": str(tmp_path)}
    short = ("--law", "mb", "--set", "clock.duration=1", "--json")

    native = installed.run("run", "paper-simulation", *short, **broken)
    numpy = installed.run("run", "paper-simulation", *short, "--engine", "numpy", **broken)

    assert native.returncode == 2
    assert "pip install 'wmr_ctrl[compiler]'" in flat(native.stderr)
    assert "Traceback" not in native.stderr
    assert numpy.returncode == 0, numpy.stderr
    assert json.loads(numpy.stdout)["engine"] == "numpy"
