"""Builder of an FMU from rigid.c, the library of the wheel, and a scenario's body."""

import sys
import tempfile
import zipfile
from functools import cache
from pathlib import Path

import mujoco
import numpy as np
import pytest

from tests.compilers import compile_in, where
from wmr_ctrl.codegen.resources import fmu_dir
from wmr_ctrl.simulation.physics.rigid import RigidBody, description

INPUTS = ("motor_right", "motor_left", "force", "moment")
OUTPUTS = (
    "axle_x", "axle_y", "yaw", "forward", "turning", "rolled", "turned", "wheel_right",
    "wheel_left", "slip_right", "slip_left", "tilt",
)  # fmt: skip
"""Outputs, in the order of rigid.c."""
MAP = """
[plant]
step = {step!r}
units = "SI"
[plant.inputs]
motor_right = "torque_right"
motor_left = "torque_left"
force = "thrust"
moment = "moment"
[plant.outputs]
x = "axle_x"
y = "axle_y"
theta = "yaw"
v1 = "forward"
omega = "turning"
"""
BODY = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="rigid" guid="{{wmr-rigid}}"
                     numberOfEventIndicators="0">
  <CoSimulation modelIdentifier="rigid" canHandleVariableCommunicationStepSize="true"/>
  <ModelVariables>{variables}</ModelVariables>
  <ModelStructure><Outputs>{outputs}</Outputs><InitialUnknowns>{outputs}</InitialUnknowns>
  </ModelStructure>
</fmiModelDescription>
"""


def build_rigid(scenario, folder):
    """FMU of a scenario's body, and the map for `cosimulate`; skips without a compiler."""
    if sys.platform != "linux":
        pytest.skip("NOT RUN: this FMU is linked as Linux does")
    folder.mkdir(parents=True, exist_ok=True)
    path, names = folder / "rigid.fmu", folder / "rigid.toml"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("modelDescription.xml", described())
        archive.writestr("binaries/linux64/rigid.so", library())
        archive.writestr("resources/robot.xml", description(scenario))
        archive.writestr("resources/start.txt", start(scenario))
    names.write_text(MAP.format(step=scenario.clock.plant), encoding="utf-8")
    return path, names


@cache
def library():
    """The compiled library, which finds MuJoCo's library inside the wheel."""
    home = Path(mujoco.__file__).parent
    (shared,) = home.glob("libmujoco.so.*")
    compiler = where("cc", "gcc", "clang")
    flags = ["-std=c99", "-O2", "-ffp-contract=off", "-Wall", "-Wextra", "-Wno-unused-parameter"]
    command = [compiler, *flags, "-shared", "-fPIC", f"-I{home / 'include'}",
               f"-I{fmu_dir() / 'fmi' / 'headers'}", str(Path(__file__).with_name("rigid.c")),
               str(shared), f"-Wl,-rpath,{home}", "-lm", "-o", "rigid.so"]  # fmt: skip
    with tempfile.TemporaryDirectory() as folder:
        compile_in(Path(folder), command)
        return Path(folder, "rigid.so").read_bytes()


def start(scenario):
    """Initial state of a run of the body, as text exact to the bit."""
    body, robot = RigidBody(scenario), scenario.robot
    kind = mujoco.mjtState.mjSTATE_INTEGRATION
    state = np.empty(mujoco.mj_stateSize(body.model, kind))
    mujoco.mj_getState(body.model, body.data, state, kind)
    head = (robot.r, robot.l, scenario.initial.pose[2], body.now.pose[2])
    return (
        "\n".join([*map(float.hex, head), str(len(state)), *map(float.hex, state.tolist())]) + "\n"
    )


def described():
    """The model description."""
    rows = [(name, "input", ' start="0"') for name in INPUTS]
    rows += [(name, "output", "") for name in OUTPUTS]
    variables = "".join(
        f'<ScalarVariable name="{name}" valueReference="{i}" causality="{kind}" '
        f'variability="continuous"><Real{first}/></ScalarVariable>'
        for i, (name, kind, first) in enumerate(rows)
    )
    places = range(len(INPUTS) + 1, len(rows) + 1)
    outputs = "".join(f'<Unknown index="{place}"/>' for place in places)
    return BODY.format(variables=variables, outputs=outputs)
