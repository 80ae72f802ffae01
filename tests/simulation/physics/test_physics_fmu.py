"""The rigid body as an FMU from C, driven by our exported controllers in FMPy and in libcosim."""

import numpy as np
import pytest
from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave
from fmpy.validation import validate_fmu

from tests.simulation.physics.fmu.build import INPUTS, OUTPUTS, build_rigid
from wmr_ctrl import cosimulate, simulate
from wmr_ctrl.core.errors import ArgumentError
from wmr_ctrl.core.signals import PLANT_STATE
from wmr_ctrl.simulation.physics.rigid import RigidBody
from wmr_ctrl.world.scenario import load_scenario

ENCODERS = {"encoder.counts": 4096}
SHORT = {"clock.duration": 3.0, "actuator.tau_max": 10.0}
ROUGH = np.random.default_rng(3).normal(0.0, 40.0, (300, 4)).tolist()


def test_the_body_in_c_is_the_body_in_python_to_the_bit(tmp_path):
    """Also with wheels that spin and lift, and under a push."""
    case = load_scenario("paper-simulation")
    path, _ = build_rigid(case, tmp_path)
    assert validate_fmu(str(path)) == []
    described, body = read_model_description(str(path)), RigidBody(case)
    slave = FMU2Slave(guid=described.guid, unzipDirectory=extract(str(path), str(tmp_path / "x")),
                      modelIdentifier="rigid", instanceName="body")  # fmt: skip
    slave.instantiate()
    inputs, outputs = range(len(INPUTS)), range(len(INPUTS), len(INPUTS) + len(OUTPUTS))
    for step, (right, left, thrust, moment) in enumerate(ROUGH):
        slave.setReal(inputs, [right, left, thrust, moment])
        slave.doStep(step * 1e-3, 1e-3)
        body.step((right, left, 0.0, 0.0, thrust, moment))
        now = body.now
        seen = [*now.pose, *now.velocity, now.path, now.turned, *now.wheels, *now.slip, now.tilt]
        assert slave.getReal(outputs) == seen, step
    assert max(map(abs, body.now.slip)) > 0.1
    slave.freeInstance()


def same_in_both(case, plant, map_file, names):
    """Assert that the coupled run on the FMU has the columns of the run on the rigid body, to the
    bit.
    """
    coupled = cosimulate(case, "mb", plant=plant, map_file=map_file, seed=12)
    native = simulate(case, "mb", plant="mujoco", seed=12)
    for name in names:
        assert np.array_equal(coupled[name], native[name]), name
    return native


@pytest.mark.slow
def test_in_fmpy_it_is_the_run_on_the_rigid_body_to_the_bit(tmp_path):
    """Our controllers and reference as FMUs, their noise, in the order of our master."""
    case = load_scenario("paper-simulation-no-switch", SHORT)
    states = (item.name for item in PLANT_STATE)
    same_in_both(case, *build_rigid(case, tmp_path), (*states, "tau_right", "tau_left"))


@pytest.mark.slow
def test_encoders_on_a_foreign_plant_see_its_wheels(tmp_path):
    """Also with spinning wheels: the map's rows for path and skid state their rotation."""
    case = load_scenario("paper-simulation-no-switch", {"clock.duration": 3.0, **ENCODERS})
    plant, names = build_rigid(case, tmp_path)
    with pytest.raises(ArgumentError, match="path"):
        cosimulate(case, "mb", plant=plant, map_file=names)
    rows = 'path = "rolled"\nskid = { terms = { turned = 1.0, yaw = -1.0 } }\n'
    names.write_text(names.read_text(encoding="utf-8") + rows, encoding="utf-8")
    native = same_in_both(case, plant, names, ("x", "v1", "wheel_counts", "tau_right"))
    assert np.abs(native["slip"]).max() > 1.0
