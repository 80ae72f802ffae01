"""The closed loop with every effect in it: its state put back, its numbers set from outside."""

from pathlib import Path

import numpy as np
import pytest
from fmpy import extract

from tests.export.fmi.raw import OK, Fmu
from tests.world.motion import LAW, TOGETHER, scenario
from wmr_ctrl.api import export_fmu, simulate
from wmr_ctrl.world.scenario import override

SET = {
    "encoder.counts": 600.0, "gyro.bias": 0.02, "gyro.noise": 0.003, "sensor.pose_dropout": 0.6,
    "actuator.jitter": 0.004, "actuator.lag": 0.03, "actuator.lag_spread": 0.2,
    "motor.step": 0.3, "motor.dead_zone": 0.2, "motor.stall": 15.0, "motor.free": 25.0,
    "wheels.track": -0.01, "slope.angle": 0.05, "slope.direction": -1.0, "slope.offset": 0.05,
    "gust.time": 0.3,
}  # fmt: skip
"""Another value of every scalar that the effects read as a parameter."""


@pytest.fixture(scope="module")
def fmu(tmp_path_factory):
    out = tmp_path_factory.mktemp("effects")
    (path,) = export_fmu("closed-loop", law=LAW, scenario=scenario(TOGETHER), fmi=3, out=out)
    return Fmu(path, Path(extract(str(path), str(out / "extracted"))), 3)


def test_numbers_that_are_set_act_as_in_a_loop_of_their_own(fmu):
    changed = override(scenario(TOGETHER), SET)
    run, instance = simulate(changed, LAW, seed=0), fmu.new()
    assert instance.put(SET) == OK, fmu.messages[-1:]
    instance.begin(stop=0.5)
    shown = []
    for k in range(50):
        shown.append(instance.get("x", "v1", "omega"))
        assert instance.step(0.01 * k, 0.01) == OK

    wanted = np.column_stack([run[name] for name in ("x", "v1", "omega")])
    assert np.array_equal(np.array(shown), wanted)
