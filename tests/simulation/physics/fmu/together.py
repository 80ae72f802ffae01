"""Reference, controller and plant as FMUs that step all at once: by libcosim, and by FMPy alone.

At communication steps of a plant step the torque is late by that much.  Nothing of our own master
is in it, so it shows what anybody's sees.
"""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest
from fmpy import read_model_description

from tests.export.fmi.together import step_together
from tests.simulation.physics.fmu.build import build_rigid
from wmr_ctrl.core.signals import PLANT_STATE, REFERENCE
from wmr_ctrl.export.fmi.blocks import parallel
from wmr_ctrl.export.fmi.fmu_files import model_of, write_fmu
from wmr_ctrl.export.fmi.targets import targets_of
from wmr_ctrl.world.scenario import Scenario

STATE = tuple(item.name for item in PLANT_STATE)
DESIRED = tuple(item.name for item in REFERENCE)
BODILY = ("slip_right", "slip_left", "tilt")
PLANES = {name: name for name in (*STATE, "tau_right", "tau_left")}
RIGIDS = {"x": "axle_x", "y": "axle_y", "theta": "yaw", "v1": "forward", "omega": "turning",
          "tau_right": "motor_right", "tau_left": "motor_left"}  # fmt: skip
"""Names of the plants' variables by ours."""

_LIBCOSIM = """
import json, sys
from libcosimpy.CosimEnums import CosimVariableType
from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimObserver import CosimObserver
from libcosimpy.CosimSlave import CosimLocalSlave
plan = json.loads(sys.stdin.read())
execution = CosimExecution.from_step_size(step_size=plan["nanoseconds"])
parts = {
    name: execution.add_local_slave(CosimLocalSlave(fmu_path=path, instance_name=name))
    for name, path in plan["parts"].items()
}
for giver, out, taker, into in plan["wires"]:
    assert execution.connect_real_variables(parts[giver], out, parts[taker], into) == 0
seen = CosimObserver.create_last_value()
execution.add_observer(observer=seen)
for _ in range(plan["samples"]):
    assert execution.step(step_count=plan["substeps"])
    row = [value for name, refs in plan["shown"] for value in
           seen.last_real_values(slave_index=parts[name], variable_references=refs)]
    print("ROW", *map(float.hex, row))
"""


class Together:
    """The three FMUs of a law on a scenario, wired by name."""

    def __init__(self, scenario: Scenario, law: str, folder: Path, *, rigid: bool) -> None:
        """Export them; the plant is the plane model or the rigid body."""
        self.clock, self.parts = scenario.clock, {}
        for name, what in (("reference", "reference"), ("law", law), ("plant", "plant")):
            path = folder / f"{name}.fmu"
            if name == "plant" and rigid:
                path, _ = build_rigid(scenario, folder)
            else:
                model = parallel(model_of(what, law, scenario))
                write_fmu(model, 2, targets_of("host"), path, result=False)
            self.parts[name] = path
        self.described = {name: read_model_description(str(p)) for name, p in self.parts.items()}
        self.refs = {
            name: {v.name: v.valueReference for v in described.modelVariables}
            for name, described in self.described.items()
        }
        theirs = RIGIDS if rigid else PLANES
        wires = [("reference", name, "law", name) for name in DESIRED]
        wires += [("plant", theirs[name], "law", name) for name in STATE]
        wires += [("law", name, "plant", theirs[name]) for name in ("tau_right", "tau_left")]
        self.wires = [
            (giver, self.refs[giver][out], taker, self.refs[taker][into])
            for giver, out, taker, into in wires
        ]
        further = BODILY if rigid else ()
        plant, reference = self.refs["plant"], self.refs["reference"]
        self.shown = (
            ("plant", [plant[theirs[name]] for name in STATE] + [plant[name] for name in further]),
            ("reference", [reference[name] for name in DESIRED[:3]]),
        )
        self.columns = (*STATE, *further, *DESIRED[:3])

    def by_libcosim(self) -> Mapping[str, np.ndarray]:
        """``columns`` at the end of every control period, by libcosim's fixed-step algorithm."""
        pytest.importorskip("libcosimpy", reason="NOT RUN: libcosimpy is not there")
        plan = {
            "parts": {name: str(path) for name, path in self.parts.items()},
            "wires": self.wires, "shown": self.shown, "samples": self.clock.samples,
            "substeps": self.clock.substeps, "nanoseconds": round(self.clock.plant * 1e9),
        }  # fmt: skip
        done = subprocess.run([sys.executable, "-c", _LIBCOSIM], input=json.dumps(plan),
                              capture_output=True, text=True, check=False)  # fmt: skip
        assert done.returncode == 0, done.stderr
        lines = [line.split() for line in done.stdout.splitlines() if line.startswith("ROW")]
        return self._named([[float.fromhex(word) for word in line[1:]] for line in lines])

    def by_fmpy(self, folder: Path) -> Mapping[str, np.ndarray]:
        """The same by a few lines on FMPy."""
        steps = (self.clock.samples * self.clock.substeps, self.clock.plant)
        rows = step_together(self.parts, self.wires, self.shown, steps, folder)
        return self._named(rows[self.clock.substeps - 1 :: self.clock.substeps])

    def _named(self, rows: np.ndarray | list[list[float]]) -> Mapping[str, np.ndarray]:
        return dict(zip(self.columns, np.array(rows).T, strict=True))
