"""The command filter as an FMU: the bits of a run's filter, its flags, what it refuses."""

from pathlib import Path

import numpy as np
import pytest
from fmpy import extract, read_model_description, simulate_fmu
from fmpy.validation import validate_fmu

from tests.control.bases import GOVERNED
from tests.control.filter.test_filter import scenario
from tests.export.fmi.raw import ERROR, OK, Fmu
from wmr_ctrl import simulate
from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.export.fmi.fmu_files import export_fmu
from wmr_ctrl.world.scenario import load_scenario, override

DRIVEN = override(load_scenario("paper-simulation-noise-free"), {**GOVERNED, "changes": []})


def exported(case, version, folder):
    (path,) = export_fmu("filter", scenario=case, fmi=version, out=folder)
    return path


def opened(case, version, folder):
    path = exported(case, version, folder)
    return Fmu(path, Path(extract(str(path), str(folder / "unpacked"))), version)


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.slow_but("2")
def test_it_sends_what_a_run_sent_to_the_bit(version, tmp_path):
    run = simulate(DRIVEN, "kanayama")
    path = exported(DRIVEN, version, tmp_path)
    T = DRIVEN.clock.control
    names = ("t", *(f"v_asked[{i}]" for i in (1, 2)), *(f"v_odometry[{i}]" for i in (1, 2)))
    columns = (run["t"], *(run[name] for name in (*names[1:3], "v1", "omega")))
    given = np.array(
        list(zip(*columns, strict=True)), dtype=[(name.replace("t", "time", name == "t"), float)
        for name in names],
    )  # fmt: skip
    found = simulate_fmu(
        str(path), stop_time=run.rows * T, output_interval=T, step_size=T, input=given,
        start_values={"odometry_age": 0.0},
        output=["v_sent[1]", "v_sent[2]", "filter_flags", "limited"],
    )  # fmt: skip
    assert validate_fmu(str(path)) == []
    pairs = {"v_sent[1]": "v_command", "v_sent[2]": "omega_command", "filter_flags": "filter_flags"}
    for told, column in pairs.items():
        assert np.array_equal(found[told][1:], run[column]), told
    assert np.array_equal(found["limited"][1:], run["filter_flags"] % 2)
    assert 0 < found["limited"].mean() < 1


def test_a_repeated_step_is_noticed_once_the_time_was_told(tmp_path):
    instance = opened(scenario(), 3, tmp_path).new().begin()
    late = []
    for k, since in enumerate((0.0, 0.0, 0.05, 0.0, 0.05)):
        instance.put({"elapsed": since})
        assert instance.step(0.05 * k, 0.05) == OK
        late += instance.get("late")
    assert late == [0.0, 0.0, 0.0, 1.0, 0.0]
    instance.free()


def test_what_is_no_number_is_refused_and_what_contradicts_the_bounds_is_told(tmp_path):
    fmu = opened(scenario(), 2, tmp_path)
    instance = fmu.new().begin()
    instance.put({"v_asked[1]": 0.2})
    for wrong in (float("nan"), float("inf"), 2e12):
        for name in ("v_asked[1]", "v_odometry[2]", "odometry_age", "elapsed"):
            assert instance.put({name: wrong}) == ERROR
    assert instance.get("v_asked[1]") == [0.2]
    instance.put({"v_asked[1]": 0.3, "v_odometry[1]": 3.0, "odometry_age": 0.0})
    assert instance.step(0.0, 0.05) == OK
    assert instance.get("bounds_left", "unused", "share[1]", "refused") == [1.0, 0.0, 1.0, 0.0]
    assert fmu.variables["clock.control"].min == fmu.variables["clock.control"].max
    instance.free()


def test_its_plain_code_is_named_and_it_claims_no_derivatives(tmp_path):
    description = read_model_description(str(exported(scenario("clip"), 2, tmp_path)))
    assert description.description.endswith("interface.xml")
    assert not description.coSimulation.providesDirectionalDerivative


def test_without_a_filter_there_is_none(tmp_path):
    with pytest.raises(ScenarioError, match="has no command filter"):
        export_fmu("filter", scenario="paper-simulation", out=tmp_path)
    assert not list(tmp_path.iterdir())
