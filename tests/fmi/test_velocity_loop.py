"""The closed-loop FMU of a base that takes velocities, and what cannot hold one."""

from __future__ import annotations

from pathlib import Path

import pytest
from fmpy import extract

from tests.fmi.raw import Fmu
from tests.fmi.test_every_field import assert_loop_is
from wmr_ctrl import simulate
from wmr_ctrl.core.errors import ArgumentError, ScenarioError
from wmr_ctrl.export.cosim import cosimulate
from wmr_ctrl.export.fmi.fmu_files import export_fmu
from wmr_ctrl.world.scenario import load_scenario, override

SCENARIO = override(
    load_scenario("paper-simulation-noise-free"),
    {
        "base": {
            "kind": "velocity", "tau": [0.2, 0.25], "gain": [1.05, 0.95], "delay": 0.02,
            "losses": 2, "accel": [2.0, 5.0], "deadband": [0.01, 0.01], "quantum": [0.01, 0.01],
            "w_max": 11.0,
        },
        "filter": {"kind": "clip", "gain": [0.9, 1.1], "d": [0.01, 0.01]},
        "clock.control": 0.05,
        "clock.duration": 1.0,
        "changes": [{"t": 0.5, "m": 65.0}],
    },
)  # fmt: skip
LAW = "kanayama"


def test_the_closed_loop_fmu_has_the_bits_of_the_run(tmp_path: Path) -> None:
    (path,) = export_fmu("closed-loop", law=LAW, scenario=SCENARIO, fmi=3, out=tmp_path)
    fmu = Fmu(path, Path(extract(str(path), str(tmp_path / "loop"))), 3)
    assert_loop_is(simulate(SCENARIO, LAW), fmu, SCENARIO, LAW)


def test_co_simulation_refuses_it_by_name() -> None:
    with pytest.raises((ScenarioError, ArgumentError), match=r"base\.kind"):
        cosimulate(SCENARIO, LAW)


@pytest.mark.parametrize("what", ["kanayama", "plant"])
def test_parts_of_it_are_refused_by_name(what: str, tmp_path: Path) -> None:
    with pytest.raises((ScenarioError, ArgumentError), match=r"base\.kind"):
        export_fmu(what, law=LAW, scenario=SCENARIO, fmi=3, out=tmp_path)
    assert list(tmp_path.iterdir()) == []
