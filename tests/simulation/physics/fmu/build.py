"""Packs rigid.c, compiled against the library of the wheel, with a scenario's body into an FMU."""

import sys
import tempfile
import zipfile
from functools import cache
from pathlib import Path

import mujoco
import pytest

from tests.compilers import compile_in, where
from tests.simulation.physics.states import state_of
from wmr_ctrl.codegen.resources import fmu_dir
from wmr_ctrl.simulation.physics.rigid import RigidBody, description

INPUTS = {"motor_right": "N.m", "motor_left": "N.m", "force": "N", "moment": "N.m"}
OUTPUTS = {
    "axle_x": "m", "axle_y": "m", "yaw": "rad", "forward": "m/s", "turning": "rad/s",
    "rolled": "m", "turned": "rad", "wheel_right": "rad/s", "wheel_left": "rad/s",
    "slip_right": "m/s", "slip_left": "m/s", "tilt": "rad",
}  # fmt: skip
"""Names and units, in the order of rigid.c."""
MAP = """
[plant]
step = {step!r}
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
  <UnitDefinitions>{units}</UnitDefinitions>
  <ModelVariables>{variables}</ModelVariables>
  <ModelStructure><Outputs>{outputs}</Outputs><InitialUnknowns>{outputs}</InitialUnknowns>
  </ModelStructure>
</fmiModelDescription>
"""
UNITS = {
    "N.m": 'kg="1" m="2" s="-2"', "N": 'kg="1" m="1" s="-2"', "m": 'm="1"', "rad": 'rad="1"',
    "m/s": 'm="1" s="-1"', "rad/s": 'rad="1" s="-1"',
}  # fmt: skip


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
    """The compiled library, which finds MuJoCo's where the wheel has it."""
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
    """What a run of the body starts from, to the bit."""
    body, robot = RigidBody(scenario), scenario.robot
    state = state_of(body).tolist()
    head = (robot.r, robot.l, scenario.initial.pose[2], body.pose[2])
    return "\n".join([*map(float.hex, head), str(len(state)), *map(float.hex, state)]) + "\n"


def described():
    """The model description."""
    units = "".join(f'<Unit name="{n}"><BaseUnit {b}/></Unit>' for n, b in UNITS.items())
    rows = [(name, unit, "input", ' start="0"') for name, unit in INPUTS.items()]
    rows += [(name, unit, "output", "") for name, unit in OUTPUTS.items()]
    variables = "".join(
        f'<ScalarVariable name="{name}" valueReference="{i}" causality="{kind}" '
        f'variability="continuous"><Real unit="{unit}"{first}/></ScalarVariable>'
        for i, (name, unit, kind, first) in enumerate(rows)
    )
    first = len(INPUTS) + 1
    outputs = "".join(f'<Unknown index="{first + i}"/>' for i in range(len(OUTPUTS)))
    return BODY.format(units=units, variables=variables, outputs=outputs)
