"""An adversary's push in FMUs: a parameter of the closed loop, part of every co-simulation."""

import numpy as np
import pytest
from fmpy import simulate_fmu

from benchmarks.guard_runs import FACTORS
from tests.export.cosim.foreign import PLANT, PLANT_MAP
from tests.export.fmi.test_fmi_equality import STATE
from wmr_ctrl.api import simulate
from wmr_ctrl.export.cosim import cosimulate
from wmr_ctrl.export.fmi.fmu_files import export_fmu
from wmr_ctrl.world.scenario import load_scenario, override

PUSHED = override(
    load_scenario("paper-simulation-nominal"),
    {
        **FACTORS["adversary"],
        "clock.duration": 2.0,
        "limits.v_u1": [0.6, 0.6],
        "limits.v_u2": [0.4, 0.4],
    },
)


def elements(run):
    return [name for signal in run.signals[1:] for name in signal.elements]


def looped(path, run, **starts):
    """Columns of a closed-loop FMU as the native run has them, and its largest speeds."""
    names = elements(run)
    speeds = ("max_abs_v[1]", "max_abs_v[2]")
    found = simulate_fmu(
        str(path),
        stop_time=run.settings.duration,
        output_interval=0.01,
        step_size=0.01,
        start_values=starts,
        output=[*names, *speeds],
    )
    rows = {n: found[n][:-1] if n in STATE else found[n][1:] for n in names}
    return rows, tuple(found[name][-1] for name in speeds)


def assert_loop_is(run, path, **starts):
    rows, speeds = looped(path, run, **starts)
    assert not [name for name in rows if not np.array_equal(rows[name], run[name])]
    assert speeds == run.monitor.max_abs_v


@pytest.mark.parametrize(("version", "guard"), [(2, False), (3, True)])
@pytest.mark.slow_but("2-False")
def test_closed_loop_under_an_adversary_is_the_native_loop(tmp_path, version, guard):
    scenario = override(PUSHED, {"guard.enabled": guard})
    (path,) = export_fmu("closed-loop", law="mb", scenario=scenario, fmi=version, out=tmp_path)
    run = simulate(scenario, "mb")
    assert_loop_is(run, path)
    assert (run.monitor.violations == 0) == guard


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.slow_but("3")
def test_push_radius_and_track_are_parameters(tmp_path, version):
    """F r/2 on both wheels, N r/(2 l) on right less left, of the values set in the FMU."""
    calm = override(PUSHED, {"disturbance.push": [0.0, 0.0]})
    (path,) = export_fmu("closed-loop", law="pid", scenario=calm, fmi=version, out=tmp_path)
    chosen = {"robot.r": 0.13, "robot.l": 0.31}
    run = simulate(calm, "pid", overrides={**chosen, "disturbance.push": [7.0, 1.9]})
    starts = {**chosen, "disturbance.push[1]": 7.0, "disturbance.push[2]": 1.9}
    rows, _ = looped(path, run, **starts)
    assert np.array_equal(rows["noise_right"], run["noise_right"])
    assert np.array_equal(rows["noise_left"], run["noise_left"])
    assert rows["noise_right"][0] + rows["noise_left"][0] == pytest.approx(7.0 * 0.13)
    assert rows["noise_right"][0] - rows["noise_left"][0] == pytest.approx(1.9 * 0.13 / 0.31)


@pytest.mark.parametrize(("version", "guard"), [(2, False), (3, True)])
@pytest.mark.slow
def test_cosimulation_under_an_adversary_is_the_native_loop(version, guard):
    scenario = override(PUSHED, {"guard.enabled": guard})
    run, other = simulate(scenario, "mb"), cosimulate(scenario, "mb", fmi=version)
    names = [name for name in run.columns if name != "e"]
    assert not [n for n in names if not np.array_equal(run[n], other[n], equal_nan=True)]
    assert run.monitor == other.monitor


@pytest.mark.slow
def test_push_is_turned_with_the_motion():
    robot, (force, moment) = PUSHED.robot, PUSHED.disturbance.push
    along, around = 0.5 * robot.r * force, 0.5 * robot.r * moment / robot.l
    run = cosimulate(PUSHED, "mb", master="jacobi")
    ways = [np.where(run[name] < 0, -1.0, 1.0) for name in ("v1", "omega")]
    right, left = (ways[0] * along + sign * ways[1] * around for sign in (1.0, -1.0))
    assert run["noise_right"] == pytest.approx(right, abs=1e-15)
    assert run["noise_left"] == pytest.approx(left, abs=1e-15)


@pytest.mark.slow
def test_push_reaches_a_foreign_plant(foreign, mapped):
    scenario = override(load_scenario("paper-simulation-nominal"), {"clock.duration": 1.0})
    pushed = override(scenario, {"disturbance.push": [20.0, 1.0]})
    plant, names = foreign("TheirPushed", PLANT.replace("TheirRobot", "TheirPushed")), PLANT_MAP
    run = cosimulate(pushed, "nn", plant=plant, map_file=mapped(names))
    ours = simulate(pushed, "nn")
    assert np.abs(run["x"] - ours["x"]).max() < 2e-3
    assert np.abs(run["x"] - simulate(scenario, "nn")["x"]).max() > 5e-3
