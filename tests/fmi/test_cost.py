"""What co-simulation costs beside FMPy's own calls of FMUs that do nothing."""

from __future__ import annotations

import ctypes as ct
import subprocess
import time

import pytest
from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave

from tests.fmi.test_portable import tool
from wmr_ctrl.fmi.cosim import cosimulate
from wmr_ctrl.fmi.cosim.master import Master
from wmr_ctrl.signals import PLANT_STATE, POSE, REFERENCE, TORQUE, TORQUE_NOISE, VELOCITY

EMPTY = """
int values(void *c, const unsigned *v, unsigned long n, double *x)
{ (void)c; (void)v; (void)n; (void)x; return 0; }
int step(void *c, double t, double h, int b) { (void)c; (void)t; (void)h; (void)b; return 0; }
"""
SAMPLES, SUBSTEPS = 8000, 10
MOST = 1.5


def empty_slave(path, folder, stubs):
    """FMPy's handle of an FMU whose calls reach functions that do nothing."""
    described = read_model_description(str(path))
    slave = FMU2Slave(
        guid=described.guid,
        unzipDirectory=extract(str(path), str(folder)),
        modelIdentifier=described.coSimulation.modelIdentifier,
        instanceName="empty",
    )
    for name in ("fmi2GetReal", "fmi2SetReal", "fmi2DoStep"):
        given = slave._functions[name]
        stub = ct.CDLL(str(stubs))["step" if name == "fmi2DoStep" else "values"]
        stub.argtypes, stub.restype = given.argtypes, given.restype
        slave._functions[name] = stub
    refs = {v.name: v.valueReference for v in described.modelVariables}
    return slave, lambda signals: [refs[signal.name] for signal in signals]


def fmpys_calls(law, plant):
    """Seconds for setting, stepping and reading both parts over a run, by FMPy's methods.

    The plant is stepped and read once in each of its own steps, as the monitor needs it.
    """
    (controller, of), (robot, at) = law, plant
    seen, asked = of((*REFERENCE, *POSE, *VELOCITY)), of(TORQUE)
    driven, state = at((*TORQUE, *TORQUE_NOISE)), at(PLANT_STATE)
    start = time.perf_counter()
    for k in range(SAMPLES):
        controller.setReal(seen, [0.0] * len(seen))
        controller.doStep(0.01 * k, 0.01)
        controller.getReal(asked)
        robot.setReal(driven, [0.0] * len(driven))
        for j in range(SUBSTEPS):
            robot.doStep(0.01 * k + 0.001 * j, 0.001)
            robot.getReal(state)
    return time.perf_counter() - start


@pytest.mark.slow
def test_a_run_costs_little_more_than_fmpys_calls(exported, tmp_path, monkeypatch):
    (tmp_path / "stub.c").write_text(EMPTY, encoding="utf-8")
    stubs = tmp_path / "stub.so"
    command = [tool("cc"), "-shared", "-fPIC", "-O2", "-o", str(stubs), str(tmp_path / "stub.c")]
    subprocess.run(command, check=True)
    parts = [empty_slave(exported(w, 2), tmp_path / f"empty_{w}", stubs) for w in ("nn", "plant")]
    taken, empty, run = [], [], Master.run

    def timed(master, progress):
        start = time.perf_counter()
        run(master, progress)
        taken.append(time.perf_counter() - start)

    monkeypatch.setattr(Master, "run", timed)
    for _ in range(5):
        cosimulate("paper-simulation", "nn")
        empty.append(fmpys_calls(*parts))
    assert min(taken) <= MOST * min(empty)
