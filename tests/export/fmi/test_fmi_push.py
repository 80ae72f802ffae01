"""An adversary's push in FMUs: a parameter of the closed loop, part of every co-simulation."""

import numpy as np
import pytest
from fmpy import simulate_fmu

from benchmarks.guard_runs import FACTORS
from tests.export.fmi.test_fmi_equality import STATE
from wmr_ctrl.api import simulate
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


def looped(path, run, **starts):
    """Columns of a closed-loop FMU as the native run has them, and its largest speeds."""
    names = [name for signal in run.signals[1:] for name in signal.elements]
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


@pytest.mark.parametrize("version, guard", [(2, False), (3, True)])
@pytest.mark.slow_but("2-False")
def test_closed_loop_under_an_adversary_is_the_native_loop(tmp_path, version, guard):
    scenario = override(PUSHED, {"guard.enabled": guard})
    (path,) = export_fmu("closed-loop", law="mb", scenario=scenario, fmi=version, out=tmp_path)
    run = simulate(scenario, "mb")
    rows, speeds = looped(path, run)
    assert not [name for name in rows if not np.array_equal(rows[name], run[name])]
    assert speeds == run.monitor.max_abs_v
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
