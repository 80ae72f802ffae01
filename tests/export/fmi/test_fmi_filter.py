"""Command filter as an FMU: the bits of a run's filter, its flags and its refusals."""

import numpy as np
import pytest
from fmpy.validation import validate_fmu

from tests.control.bases import GOVERNED
from tests.control.filter.test_filter import scenario
from tests.export.fmi.cases import both
from tests.export.fmi.raw import ERROR, OK
from wmr_ctrl import simulate
from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.export.fmi.fmu_files import export_fmu
from wmr_ctrl.world.scenario import load_scenario

DRIVEN = load_scenario("paper-simulation-noise-free", {**GOVERNED, "changes": []})


@both
@pytest.mark.slow_but("2")
def test_it_sends_what_a_run_sent_to_the_bit(version, raw):
    run, fmu, T = simulate(DRIVEN, "kanayama"), raw("filter", version, DRIVEN), DRIVEN.clock.control
    given = ("v_asked[1]", "v_asked[2]", "v_odometry[1]", "v_odometry[2]")
    asked = [run[name] for name in ("v_asked[1]", "v_asked[2]", "v1", "omega")]
    sent = ("v_command", "omega_command", "filter_flags")
    one, rows = fmu.new(), []
    assert one.put({"odometry_age": 0.0}) == OK
    one.begin()
    for k, values in enumerate(zip(*asked, strict=True)):
        assert one.put(dict(zip(given, values, strict=True))) == OK
        assert one.step(k * T, T) == OK
        rows.append(one.get("v_sent[1]", "v_sent[2]", "filter_flags", "limited"))
    *found, limited = np.transpose(rows)
    assert validate_fmu(str(fmu.path)) == []
    assert np.array_equal(found, [run[name] for name in sent])
    assert np.array_equal(limited, run["filter_flags"] % 2)
    assert 0 < limited.mean() < 1


def test_a_repeated_step_is_late_once_the_time_was_told(raw):
    one, late = raw("filter", 3, scenario()).new().begin(), []
    for k, since in enumerate((0.0, 0.0, 0.05, 0.0, 0.05)):
        assert (one.put({"elapsed": since}), one.step(0.05 * k, 0.05)) == (OK, OK)
        late += one.get("late")
    assert late == [0.0, 0.0, 0.0, 1.0, 0.0]


def test_what_is_no_number_is_refused_and_what_contradicts_the_bounds_is_told(raw):
    fmu = raw("filter", 2, scenario())
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
    assert fmu.description.description.endswith("interface.xml")
    assert not fmu.description.coSimulation.providesDirectionalDerivative


def test_without_a_filter_there_is_none(tmp_path):
    with pytest.raises(ScenarioError, match="has no command filter"):
        export_fmu("filter", scenario="paper-simulation", out=tmp_path)
    assert not list(tmp_path.iterdir())
