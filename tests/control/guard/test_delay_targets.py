"""The guard behind a delay is the same in lanes, FMUs and C packages as in the native loop."""

from __future__ import annotations

import subprocess
from pathlib import Path

import numpy as np
import pytest

from tests.codegen.packages import write_package
from wmr_ctrl.api import simulate, simulate_many
from wmr_ctrl.codegen.toolchain import find_toolchain
from wmr_ctrl.control.given import scenario_of
from wmr_ctrl.export.cosim import cosimulate
from wmr_ctrl.world.scenario import Scenario

LATE = {
    "actuator.delay": 0.013,
    "actuator.tau_max": 10.0,
    "clock.duration": 3.0,
    "initial.velocity": [0.9, 1.2],
    "changes": [],
}


def late() -> Scenario:
    return scenario_of("safe-simulation", LATE)


@pytest.mark.slow
def test_controller_fmu_equals_the_native_loop() -> None:
    native, fmu = simulate(late(), "prox", seed=2), cosimulate(late(), "prox", seed=2)

    assert native["clip_active"].any()
    for signal in fmu.signals:
        if signal.name in native:
            assert native[signal.name] == pytest.approx(fmu[signal.name], abs=1e-9), signal.name


@pytest.mark.slow
def test_lanes_equal_the_native_loop() -> None:
    table = simulate_many(late(), "prox", range(5))
    runs = [simulate(late(), "prox", seed=seed) for seed in range(5)]

    assert np.array([run.monitor.max_abs_v for run in runs]) == pytest.approx(
        np.stack([table["max_abs_v1"], table["max_abs_v2"]], axis=1), abs=1e-9
    )


@pytest.mark.slow
def test_package_remembers_what_is_under_way(tmp_path: Path) -> None:
    """Its own check, compiled and run; two earlier commands and the delay are in its header."""
    write_package("prox", tmp_path, late())
    header = (tmp_path / "wmr_prox.h").read_text(encoding="utf-8")
    for name in ("tau_applied[2]", "tau_sent1[2]", "tau_sent2[2]", "actuator_delay"):
        assert name in header
    sources = [str(tmp_path / name) for name in ("wmr_prox.c", "check.c")]
    program = tmp_path / "check"
    command = [*find_toolchain().command, "-O2", *sources, "-o", str(program), "-lm"]
    subprocess.run(command, check=True, capture_output=True)
    assert subprocess.run([program], check=False, capture_output=True).returncode == 0
