"""No parameter is lost: a closed loop with other numbers is the native run of that scenario."""

import numpy as np
import pytest

from tests.export.fmi.test_fmi_equality import assert_loop_is, assert_same
from tests.export.fmi.test_fmi_every_column import COUNTED, scenario_with
from tests.tables import changes
from wmr_ctrl.api import simulate
from wmr_ctrl.export.cosim import cosimulate
from wmr_ctrl.world.scenario import load_scenario, override

BASE = load_scenario("paper-simulation", changes("""
    clock.duration = 0.3
    initial.velocity = [0.31, -0.95]
    actuator.tau_max = 6.0
    limits = {v_u1 = [0.4, 1.2], v_u2 = [0.15, 0.4], clip = 0.02}
    disturbance = {std = 1.0, truncate = 0.8, push = [3.0, 0.5]}
    sensor = {pose_period = 0.04, pose_noise = 0.01, correction = 0.6}
    sensor.velocity_noise = [0.002, 0.004]
    gains.kinematics.k = [8.0, 5.0, 4.0]
    changes = [{t = 0.1, m = 60.0, I = 6.0, mu = 0.12}]
"""))  # fmt: skip
"""Everything that is a number acts, within 0.3 s."""
GUARD = changes("guard = {enabled = true, trust = true, f_min = [0.1, 0.0], f_speed = [0.2, 0.3]}")
GUARDED = override(BASE, GUARD)
KEPT = ("clock", "sensor.pose_period", "sensor.velocity_losses", "actuator.jitter",
        "actuator.lag_spread", "seed")  # fmt: skip
"""Parameters that are whole numbers, of steps too, that the guard's delays are built for, or that
are no number of the scenario."""


def other_numbers(fmu):
    """Each parameter that may vary, with another value: brakes up to 2 % less, all else more."""
    draw = np.random.default_rng(0)
    found = {}
    for v in fmu.variables.values():
        if v.causality == "parameter" and not v.name.startswith(KEPT) and v.max > v.min:
            most = -0.02 if v.name.startswith("guard.brake") else 0.02
            found[v.name] = float(v.start) * (1 + most * draw.uniform())
    return found


def stated(numbers):
    """Parameters of an FMU as keys of a scenario; elements of an array are joined."""
    found = {}
    for name, value in numbers.items():
        key = name.replace("ref_", "reference.")
        if key.endswith("]"):
            found.setdefault(key.partition("[")[0], []).append(value)
        else:
            found[key] = value
    return found


@pytest.mark.parametrize(
    "base, law, version",
    [(GUARDED, "mb", 2), (BASE, "nn", 3), (BASE, "pid", 2), (BASE, "kanayama", 3),
     (scenario_with(COUNTED), "mb", 3)],
)  # fmt: skip
@pytest.mark.slow_but("base0-mb-2", "base4-mb-3")
def test_every_parameter_acts_as_in_the_native_run(raw, base, law, version):
    fmu = raw("closed-loop", version, base, law, arrays=False)
    numbers = other_numbers(fmu)
    run = simulate(override(base, stated(numbers)), law)

    assert len(numbers) > 25
    assert_loop_is(run, fmu, numbers)
    assert not np.array_equal(run["x"], simulate(base, law)["x"])


@pytest.mark.slow
def test_parts_of_another_scenario_take_its_numbers(raw):
    loop = raw("closed-loop", 2, GUARDED, "mb", arrays=False)
    scenario = override(GUARDED, stated(other_numbers(loop)))
    parts = {"plant": raw("plant", 2, GUARDED).path, "controller": raw("mb", 3, GUARDED).path}
    assert_same(simulate(scenario, "mb"), cosimulate(scenario, "mb", **parts))
