"""Co-simulation with other people's FMUs, masters, SSP, and FMUs that fail."""

import _ctypes
import json
import os
import re
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from fmpy.ssp.simulation import simulate_ssp

from tests.commands import finished, flat
from tests.export.cosim.foreign import FAILING, PLANT, PLANT_MAP
from wmr_ctrl.api import simulate
from wmr_ctrl.cli import root
from wmr_ctrl.cli.summary import summary_text
from wmr_ctrl.core.errors import ArgumentError, ScenarioError, UnknownNameError
from wmr_ctrl.export.cosim import cosimulate
from wmr_ctrl.export.cosim.mapping import load_map
from wmr_ctrl.export.cosim.run import IN_ORDER, TELL, _assumed, _cosim_setup
from wmr_ctrl.export.cosim.slave import FmuError, FmuFile, Slave
from wmr_ctrl.export.fmi.files import write_archive
from wmr_ctrl.export.fmi.ssp import export_ssp
from wmr_ctrl.results import load_run
from wmr_ctrl.world.scenario import load_scenario, override

NOMINAL = load_scenario("paper-simulation-nominal")
SHORT = override(NOMINAL, {"clock.duration": 3.0})


@pytest.mark.slow
def test_the_command_tells_a_script_that_an_fmu_failed(foreign, mapped, tmp_path):
    plant, saved = foreign("TheirFailure", FAILING), tmp_path / "run.npz"
    words = f"paper-simulation-no-switch --set clock.duration=1.0 --law pid --json --out {saved}"
    given = ("cosim", *words.split(), "--plant", str(plant), "--map", str(mapped(PLANT_MAP)))
    done = CliRunner().invoke(root, given, env={"COLUMNS": "999"})
    assert done.exit_code == 3
    assert f"error: the FMU {plant} (plant) failed at t = 0.5 s in doStep." in flat(done.stderr)
    assert load_run(saved).outcome == json.loads(done.stdout)["outcome"] == "failed"


@pytest.mark.parametrize(
    "parts, said",
    [
        (None, "there is no such file. Check the path."),
        ("no archive", "it is no whole zip archive"),
        ("folder", "it is a folder. Name the file, which ends in .fmu."),
        ({"a.txt": ""}, "it lacks a part (There is no item named 'modelDescription.xml' in the"),
        ({"modelDescription.xml": "<a/>"}, "its modelDescription.xml is none of FMI 2.0 or 3.0."),
        ({"modelDescription.xml": "<a>"}, ". Export it again, for co-simulation by FMI 2.0"),
    ],
)
def test_a_file_that_is_no_fmu_is_told_in_words(tmp_path, parts, said):
    """The sentence names a remedy and quotes nothing from the interpreter."""
    path = tmp_path / "some.fmu"
    if parts == "no archive":
        path.write_text(parts, "utf-8")
    elif parts == "folder":
        path.mkdir()
    elif parts:
        write_archive(path, {name: text.encode() for name, text in parts.items()})

    with pytest.raises(FmuError) as refused:
        FmuFile(path, "plant")

    told = str(refused.value)
    assert said in told
    assert told.endswith(".")
    assert "NoneType" not in told


@pytest.mark.skipif(sys.platform != "linux", reason="what loaders say differs")
@pytest.mark.parametrize(
    "altered, said",
    [
        (
            lambda library: library[: len(library) // 2],
            "the process that tried was ended by it, so it is damaged or cut off. Copy",
        ),
        (
            lambda library: library[:18] + b"\xff\x00" + library[20:],
            "it is for another processor. Copy",
        ),
        (lambda _: Path(_ctypes.__file__).read_bytes(), "its library lacks a function of FMI 2.0"),
        (None, "it has no binaries/linux64/wmr_plant.so, and this platform is linux64"),
    ],
)
def test_a_library_that_cannot_be_loaded_is_told_in_words(exported, tmp_path, altered, said):
    """Loading it would end the process, so another process tries first."""
    with zipfile.ZipFile(exported("plant", 2)) as whole:
        parts = {name: whole.read(name) for name in whole.namelist()}
    library = parts.pop("binaries/linux64/wmr_plant.so")
    parts |= {"binaries/linux64/wmr_plant.so": altered(library)} if altered else {}
    path = write_archive(tmp_path / "damaged.fmu", parts)

    with pytest.raises(FmuError, match=re.escape(said)):
        Slave(path, "plant", tmp_path / "unpacked")


@pytest.mark.parametrize("known", [False, True])
def test_a_guard_that_is_not_told_of_the_masters_delay_promises_nothing(known):
    """Its least disturbance includes the late torque's effect, and the text says so."""
    safe = load_scenario("safe-simulation", {"clock.duration": 0.2})
    run = cosimulate(safe, "prox", master="jacobi", delay_known=known)
    text = flat(summary_text(run))

    assert ("assumption-void: Under the master jacobi" in text) is not known
    assert ("torques acted a period late, untold" in text) is not known
    assert (run.outcome == "bounds-left") is not known


@pytest.mark.parametrize("flat", [False, True])
@pytest.mark.slow
def test_fmpys_ssp_simulation_is_the_jacobi_master(tmp_path, flat):
    given = {"scenario": SHORT, "delay_known": True}
    (package,) = export_ssp(law="prox", out=tmp_path, flat=flat, **given)
    found = simulate_ssp(str(package), stop_time=2.995, step_size=0.01)
    run = cosimulate(law="prox", master="jacobi", **given)
    assert ("plant.noise_right" in found.dtype.names) is not flat
    for name in ("x", "y", "theta", "v1", "omega"):
        assert np.array_equal(found[f"plant.{name}"][:-1], run[name][1:]), name
    for name in ("margin", "clip_active[1]", "d_least[1]", "d_least[2]", "feasible"):
        assert np.array_equal(found[f"controller.{name}"], run[name]), name


def test_a_map_becomes_transformations_of_connections(foreign, mapped, tmp_path):
    """Torques are in mN m, angles in deg from another zero; a sum of outputs is refused."""
    direct = PLANT_MAP.replace("w_right", "v1").replace("w_left", "omega").replace("rpm", "km/h", 1)
    plant = foreign("TheirRobot", PLANT)
    given = {"law": "pid", "scenario": SHORT, "plant": plant, "out": tmp_path}
    (package,) = export_ssp(**given, map_file=mapped(direct))
    with zipfile.ZipFile(package) as archive:
        text = archive.read("SystemStructure.ssd").decode()
    change = r'endConnector="(\w+)" suppress.*?factor="(\S+)" offset="(\S+)"'
    found = {name: (float(factor), float(off)) for name, factor, off in re.findall(change, text)}
    assert found["motorR"] == (1000.0, 0.0)
    assert found["v1"] == pytest.approx((1 / 3.6, 0.0))
    assert found["theta"] == pytest.approx((np.pi / 180, -np.pi / 2))
    with pytest.raises(ArgumentError, match="carries one"):
        export_ssp(**given, map_file=mapped(PLANT_MAP))
    with pytest.raises(ArgumentError, match=r"part \[plant\]"):
        export_ssp(**given)


@pytest.mark.slow
def test_a_controller_that_knows_the_masters_delay_is_the_native_one_with_it():
    """All parts step together, so each torque acts a period late, as behind drives with that
    delay.
    """
    own = {"clock.duration": 2.0, "initial.pose": [-1.0, -0.5, -0.7]}
    base = load_scenario("safe-simulation", own)
    late = override(base, {"actuator.delay": base.actuator.delay + base.clock.control})
    native = simulate(late, "prox", seed=4)
    run = cosimulate(base, "prox", master="jacobi", delay_known=True, seed=4)
    for name in ("x", "y", "theta", "v1", "omega", "d_least"):
        assert np.array_equal(run[name], native[name]), name
    assert (run.monitor.bounds_left, run.provenance["delay"]) == (None, "known to the controller")


def test_a_delay_that_the_master_adds_is_told_apart_where_it_is_too_long():
    """The remedy was once a total delay and jitter of 8 ms, of which the master needs 10."""
    with pytest.raises(ScenarioError, match=r"counts 0 s of the scenario and .* 0\.01 s, by which"):
        cosimulate("robot-10ms", "kanayama", master="jacobi", delay_known=True)
    with pytest.raises(ArgumentError, match="no torque is delayed"):
        cosimulate("safe-simulation", "prox", delay_known=True)
    files = dict.fromkeys(("reference", "controller", "plant"))
    for preset, remedy in (("robot-10ms", IN_ORDER), ("safe-simulation", TELL)):
        case = _cosim_setup(preset, "kanayama", files, None, delay_known=False, at_once=True)
        assert _assumed(case).void.endswith(remedy)


def test_progress_is_told():
    told = []
    cosimulate(SHORT, "mb", progress=told.append)
    assert told == pytest.approx([1 / 3, 2 / 3, 1.0])


def test_unknown_master_and_names_list_the_near_ones(exported, mapped):
    with pytest.raises(UnknownNameError, match="near: jacobi"):
        cosimulate(SHORT, "pid", master="jacoby")
    with pytest.raises(UnknownNameError, match="near: outputs"):
        load_map(mapped("[plant.output]\nx = 'y'\n"))
    for rows, words in (("x='x'\ny='y'\nv1='v1'", "does not give omega, theta"),
                        ("x='xx'", "variable of the FMU")):  # fmt: skip
        given = {"plant": exported("plant", 2), "map_file": mapped(f"[plant.outputs]\n{rows}\n")}
        with pytest.raises((ArgumentError, UnknownNameError), match=words):
            cosimulate(SHORT, "pid", **given)


@pytest.mark.parametrize("fault", ["ImportError('no libxml2')", "OSError('no libxml2')"])
def test_fmpy_that_cannot_be_imported_is_said_in_words(fault, tmp_path):
    (tmp_path / "fmpy.py").write_text(f"raise {fault}\n")
    program = "from wmr_ctrl.__main__ import main; main()"
    found = os.pathsep.join((str(tmp_path), *sys.path))
    done = finished(
        [sys.executable, "-c", program, "cosim", "paper-simulation"],
        code=2, env={**os.environ, "PYTHONPATH": found},
    )  # fmt: skip
    assert "FMPy, which cannot be imported (no libxml2)" in flat(done.stderr)
