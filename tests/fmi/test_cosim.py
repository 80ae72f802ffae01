"""Co-simulation with other people's FMUs, masters, SSP, and FMUs that fail."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from fmpy.ssp.simulation import simulate_ssp

from tests.fmi.foreign import CONTROLLER, CONTROLLER_MAP, FAILING, PLANT, PLANT_MAP
from wmr_ctrl.api import simulate
from wmr_ctrl.errors import ArgumentError, UnknownNameError
from wmr_ctrl.fmi.cosim import cosimulate
from wmr_ctrl.fmi.cosim.mapping import load_map
from wmr_ctrl.fmi.cosim.slave import FmuError
from wmr_ctrl.fmi.ssp import export_ssp
from wmr_ctrl.fmi.units import unit_of
from wmr_ctrl.results import ise
from wmr_ctrl.scenario import load_scenario, override

NOMINAL = load_scenario("paper-simulation-nominal")
SHORT = override(NOMINAL, {"clock.duration": 3.0})
NOISY = override(load_scenario("paper-simulation-no-switch"), {"clock.duration": 3.0})


@pytest.fixture(scope="module")
def foreign(tmp_path_factory):
    """A function: source text of a PythonFMU slave -> its FMU, built by that exporter."""
    pytest.importorskip("pythonfmu", reason="PythonFMU builds the foreign FMUs")
    folder = tmp_path_factory.mktemp("foreign")

    def build(name: str, text: str) -> Path:
        source = folder / f"{name}.py"
        source.write_text(text, encoding="utf-8")
        command = [sys.executable, "-m", "pythonfmu", "build", "-f", str(source), "-d", str(folder)]
        subprocess.run(command, check=True, capture_output=True)
        return next(folder.glob(f"{name}.fmu"))

    return build


@pytest.fixture
def mapped(tmp_path):
    """A function: text of a map -> its file."""

    def write(text: str) -> Path:
        path = tmp_path / "map.toml"
        path.write_text(text, encoding="utf-8")
        return path

    return write


def test_foreign_plant_with_other_names_units_and_sampling(foreign, mapped):
    run = cosimulate(
        NOISY, "nn", plant=foreign("TheirRobot", PLANT), map_file=mapped(PLANT_MAP), seed=1
    )
    ours = simulate(NOISY, "nn", seed=1)
    assert run.outcome == "completed"
    for name in ("x", "y", "theta", "v1", "omega"):
        assert np.abs(run[name] - ours[name]).max() < 2e-3, name
    assert run.provenance["fmu_plant"] == "TheirRobot.fmu (FMI 2.0)"


def test_foreign_controller_drives_our_plant(foreign, mapped):
    run = cosimulate(
        SHORT,
        "pid",
        controller=foreign("TheirController", CONTROLLER),
        map_file=mapped(CONTROLLER_MAP),
    )
    speed, turn = run["v1"][-1], run["omega"][-1]
    assert speed == pytest.approx(0.3, abs=0.05)
    assert abs(turn) < 0.05
    assert np.isnan(run["V1"]).all()
    assert np.isfinite(run["e"]).all()


def test_an_fmu_that_fails_is_named(foreign, mapped):
    plant = foreign("TheirFailure", FAILING)
    run = cosimulate(NOISY, "nn", plant=plant, map_file=mapped(PLANT_MAP))
    assert run.outcome == "failed"
    assert re.search(r"TheirFailure\.fmu.*plant.*t = 0\.5", run.explanation)
    assert 49 <= run.rows <= 51


def test_divergence_is_an_outcome():
    wild = {"gains.pid.Kp": [2e4, 2e3]}
    run = cosimulate(override(load_scenario("paper-experiment-literal"), wild), "pid")
    assert run.outcome == "diverged"
    assert np.array_equal(
        run["v1"][:3], simulate("paper-experiment-literal", "pid", overrides=wild)["v1"][:3]
    )


def test_an_fmu_that_is_none_is_named(tmp_path):
    wrong = tmp_path / "wrong.fmu"
    wrong.write_bytes(b"no archive")
    with pytest.raises(FmuError, match=r"wrong\.fmu"):
        cosimulate(SHORT, "nn", plant=wrong)


@pytest.mark.parametrize("version", [2, 3])
def test_our_files_may_come_from_another_scenario(exported, version):
    """Parameters and start values are those of the scenario that is run."""
    heavier = override(SHORT, {"robot.m": 60.0, "initial.pose": [-0.2, 0.1, -1.0]})
    given = cosimulate(
        heavier, "mb", plant=exported("plant", version), controller=exported("mb", 5 - version)
    )
    assert np.array_equal(given["x"], simulate(heavier, "mb")["x"])


@pytest.mark.parametrize(
    ("law", "total", "fast"), [("pid", 2.42, 0.566), ("smc", 0.469, 1.806), ("nn", 0.826, 1.142)]
)
@pytest.mark.slow
def test_delay_of_the_jacobi_master(law, total, fast):
    run = cosimulate(NOMINAL, law, master="jacobi")
    assert ise(run)["total"] == pytest.approx(total, abs=0.006 if law == "pid" else 0.0006)
    assert run.monitor.max_abs_v[1] == pytest.approx(fast, abs=2e-3)


@pytest.mark.slow
def test_delay_of_the_jacobi_master_destroys_the_model_based_law():
    run = cosimulate(NOMINAL, "mb", master="jacobi")
    assert ise(run)["total"] == pytest.approx(4.6e5, rel=0.01)
    assert run.monitor.max_abs_v[1] == pytest.approx(1.59, abs=0.005)


@pytest.mark.parametrize("law", ["nn", "mb"])
def test_fmpys_ssp_simulation_is_the_jacobi_master(tmp_path, law):
    (package,) = export_ssp(law=law, scenario=SHORT, out=tmp_path)
    found = simulate_ssp(str(package), stop_time=2.995, step_size=0.01)
    run = cosimulate(SHORT, law, master="jacobi")
    for name in ("x", "y", "theta", "v1", "omega"):
        assert np.array_equal(found[name][: run.rows - 1], run[name][1:]), name
    for name in ("margin", "clip_active[1]", "d_least[1]", "d_least[2]", "feasible"):
        assert np.array_equal(found[name][: run.rows], run[name]), name


def test_a_torque_that_acts_late_breaks_what_the_monitor_assumes():
    """In order nothing pushes; all at once, each torque acts a step later than the law knows."""
    late, in_order = (cosimulate(SHORT, "nn", master=m) for m in ("jacobi", "gauss-seidel"))
    assert in_order.monitor.d_least == in_order.settings.dbar == (0.0, 0.0)
    assert in_order.monitor.bounds_left is None
    assert late.monitor.bounds_left is not None
    assert late.outcome == in_order.outcome == "completed"


def test_progress_is_told():
    told: list[float] = []
    cosimulate(SHORT, "mb", progress=told.append)
    assert told == pytest.approx([1 / 3, 2 / 3, 1.0])


def test_unknown_master_and_names_list_the_near_ones(exported, mapped):
    with pytest.raises(UnknownNameError, match="near: jacobi"):
        cosimulate(SHORT, "nn", master="jacoby")
    with pytest.raises(UnknownNameError, match="near: outputs"):
        load_map(mapped("[plant.output]\nx = 'y'\n"))
    with pytest.raises(ArgumentError, match="does not give omega, theta"):
        cosimulate(
            SHORT,
            "nn",
            plant=exported("plant", 2),
            map_file=mapped("[plant.outputs]\nx='x'\ny='y'\nv1='v1'\n"),
        )
    with pytest.raises(UnknownNameError, match="variable of the FMU"):
        cosimulate(
            SHORT, "nn", plant=exported("plant", 2), map_file=mapped("[plant.outputs]\nx='xx'\n")
        )


@pytest.mark.parametrize(
    "row",
    [
        'x = "v1"',
        "x = { terms = { theta = 1.0 } }",
        'v1 = { terms = { theta = 1.0 }, coefficient_unit = "m" }',
        'x = { terms = { x = 1.0 }, unit = "parsec" }',
    ],
)
def test_units_that_do_not_fit_are_refused(exported, mapped, row):
    with pytest.raises(ArgumentError, match=r"plant\.outputs|parsec"):
        cosimulate(
            SHORT, "nn", plant=exported("plant", 2), map_file=mapped(f"[plant.outputs]\n{row}\n")
        )


def test_a_change_that_the_map_cannot_make_is_refused(exported, mapped):
    scenario = override(SHORT, {"changes": [{"t": 1.0, "m": 60.0}]})
    rows = "\n".join(f'{n} = "{n}"' for n in ("x", "y", "theta", "v1", "omega"))
    with pytest.raises(ArgumentError, match=r"changes robot\.m"):
        cosimulate(
            scenario,
            "nn",
            plant=exported("plant", 2),
            map_file=mapped(f"[plant.outputs]\n{rows}\n"),
        )


@pytest.mark.parametrize(
    ("name", "factor", "exponents"),
    [
        ("kg.m2/s", 1.0, {"kg": 1, "m": 2, "s": -1}),
        ("N.m.s/rad", 1.0, {"kg": 1, "m": 2, "s": -1, "rad": -1}),
        ("rpm", np.pi / 30, {"rad": 1, "s": -1}),
        ("km/h", 1 / 3.6, {"m": 1, "s": -1}),
        ("1", 1.0, {}),
    ],
)
def test_units_are_read(name, factor, exponents):
    unit = unit_of(name)
    assert unit.factor == pytest.approx(factor)
    assert unit.exponents == exponents
