"""FMUs of 64-bit ARM Linux: their folders, and the results of FMPy and our commands there.

Commands run under the name of that machine, with code for this one;
tests/export/fmi/test_targets.py runs that processor's own code.
"""

import os
import sys
import zipfile
from types import SimpleNamespace

import numpy as np
import pytest

from tests.commands import finished
from wmr_ctrl.api import simulate
from wmr_ctrl.export.fmi.fmu_files import binaries, export_fmu
from wmr_ctrl.results.formats import load_run

linux = pytest.mark.skipif(sys.platform != "linux", reason="folders of Linux")
ON_ARM = """
import platform, sys
platform.machine = lambda: "aarch64"
import fmpy
assert (fmpy.platform, fmpy.platform_tuple) == ("linux64", "aarch64-linux")
for path in sys.argv[2:]:
    fmpy.simulate_fmu(path, stop_time=0.1, output_interval=0.01)
from wmr_ctrl.cli.root import root
for line in sys.argv[1].splitlines():
    try:
        root.main(line.split())
    except SystemExit as end:
        assert not end.code, line
"""
OWN, SHARED = "binaries/aarch64-linux/wmr_plant.so", "binaries/linux64/wmr_plant.so"


@pytest.mark.parametrize("version", [2, 3])
def test_linux64_has_the_arm_library_unless_x86_64_is_in_the_file(version):
    model = SimpleNamespace(identifier="wmr_plant")
    intel = SHARED if version == 2 else "binaries/x86_64-linux/wmr_plant.so"
    arm, both = {"aarch64-linux": b"arm"}, {"aarch64-linux": b"arm", "x86_64-linux": b"intel"}

    assert binaries(model, version, arm) == {OWN: b"arm", SHARED: b"arm"}
    assert binaries(model, version, both) == {OWN: b"arm", intel: b"intel"}


@pytest.mark.slow
@linux
def test_fmus_are_exported_and_stepped_on_an_arm_machine(tmp_path):
    """FMPy steps them, and so do our commands, with equal bits there and here."""

    def on_arm(commands, *fmus):
        done = finished([sys.executable, "-c", ON_ARM, commands, *fmus], cwd=tmp_path)
        return done.stdout + done.stderr

    assert "note" not in on_arm("export reference\nexport plant --fmi 2")
    made = ["wmr_plant.fmi2.fmu", "wmr_reference.fmi2.fmu", "wmr_reference.fmi3.fmu"]
    assert sorted(path.name for path in tmp_path.glob("*.fmu")) == made
    with zipfile.ZipFile(tmp_path / made[0]) as archive:
        names = set(archive.namelist())
    assert {name for name in names if name.startswith("binaries/")} == {OWN, SHARED}
    assert "extra/org.wmr-ctrl/reference.csv" in names

    asked = "paper-simulation --law mb --set clock.duration=0.1"
    on_arm(f"cosim {asked} --plant {made[0]} --out cosim.npz\nexport ssp", *made)

    wanted = simulate("paper-simulation", "mb", overrides={"clock.duration": 0.1})
    assert np.array_equal(load_run(tmp_path / "cosim.npz")["x"], wanted["x"])
    assert (tmp_path / "wmr.ssp").is_file()


def test_an_fmu_that_fmpy_cannot_run_lacks_a_reference_result_alone(
    exported, tmp_path, monkeypatch
):
    def refused(folder, **_):
        os.chdir(folder)  # as FMPy does while it loads a library, which it cannot here
        raise Exception("The FMU cannot be simulated on the current platform.")

    complete = exported("plant", 2)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("fmpy.simulate_fmu", refused)
    with pytest.warns(UserWarning, match=r"no reference result: .*on the current platform\)\.$"):
        (path,) = export_fmu("plant", fmi=2, out="new")
    with zipfile.ZipFile(tmp_path / path) as bare, zipfile.ZipFile(complete) as whole:
        own, every = ({item.filename: item.CRC for item in file.filelist} for file in (bare, whole))
    extra = ("org.wmr-ctrl/reference.csv", "org.wmr-ctrl/reference.ssv",
             "org.fmi-standard.fmi-ls-ref/fmi-ls-manifest.xml")  # fmt: skip
    assert own == {name: crc for name, crc in every.items() if name[6:] not in extra}
    assert len(every) == len(own) + 3
