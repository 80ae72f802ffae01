"""The table of plane model against rigid body, both FMUs.

``python -m tests.simulation.physics.fmu.table`` runs our exported controllers with both
plants, in FMPy and in libcosim, and prints it; it takes some minutes.
"""

from __future__ import annotations

import math
import tempfile
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from tests.simulation.physics.fmu.build import build_rigid
from tests.simulation.physics.fmu.together import BODILY, STATE, Together
from wmr_ctrl import cosimulate
from wmr_ctrl.world.scenario import Scenario, load_scenario

LAWS = ("mb", "nn", "prox")
SEED = 2000
TRUNCATED: dict[str, object] = {"disturbance.truncate": 3.0}
CASES: dict[str, dict[str, object]] = {
    "limit 5 N m": {"actuator.tau_max": 5.0},
    "limit 10 N m": {"actuator.tau_max": 10.0},
    "no limit": {},
    "guard and `actuator.traction`": {
        "guard.enabled": True, "actuator.traction": True, **TRUNCATED
    },
}  # fmt: skip
HEAD = (
    "| case | law | FMPy: plane model | rigid body | libcosim: plane model | rigid body |\n"
    "|---|---|---|---|---|---|\n"
)


def main() -> None:
    """Print the table."""
    rows = "".join(row(case, law) for case in CASES for law in LAWS)
    print(f"{HEAD}{rows}", end="")


def row(case: str, law: str) -> str:
    """One line of the table."""
    noisy, quiet = (
        load_scenario(preset, CASES[case])
        for preset in ("paper-simulation-no-switch", "paper-simulation-nominal")
    )
    cells = [*ordered(noisy, law), *at_once(quiet, law)]
    print(case, law, *cells, sep=" | ", flush=True)
    return "| " + " | ".join((case, law, *cells)) + " |\n"


def ordered(scenario: Scenario, law: str) -> list[str]:
    """FMPy under our master, in the order of the native loop, with noise."""
    with tempfile.TemporaryDirectory() as folder:
        plant, names = build_rigid(scenario, Path(folder))
        runs = (
            cosimulate(scenario, law, seed=SEED),
            cosimulate(scenario, law, plant=plant, map_file=names, seed=SEED),
        )
    listed = (*STATE, "x_d", "y_d", "theta_d")
    return [cell(scenario, {name: run[name] for name in listed}) for run in runs]


def at_once(scenario: Scenario, law: str) -> list[str]:
    """libcosim, all parts at once at each plant step, without noise."""
    cells = []
    for rigid in (False, True):
        with tempfile.TemporaryDirectory() as folder:
            parts = Together(scenario, law, Path(folder), rigid=rigid)
            cells.append(cell(scenario, parts.by_libcosim()))
    return cells


def cell(scenario: Scenario, seen: Mapping[str, np.ndarray]) -> str:
    """How a run went: ISE and e1 of the last 10 s, or what broke first."""
    period, limits = scenario.clock.control, scenario.limits.v_u1
    beyond = [first(np.abs(seen[name]) > most, period)
              for name, most in zip(("v1", "omega"), limits, strict=True)]  # fmt: skip
    told = [f"limit broken at {min(beyond):.1f} s"] if min(beyond) < math.inf else []
    if BODILY[0] in seen:
        slid = np.maximum(abs(seen["slip_right"]), abs(seen["slip_left"]))
        slipped = first(slid > scenario.body.slip_max, period)
        fallen = first(seen["tilt"] > scenario.body.tilt_max, period)
        told += ["slips"] if slipped < min(fallen, *beyond) else []
        told += [f"falls at {fallen:.1f} s"] if fallen < math.inf else []
        if fallen < math.inf:
            return ", ".join(told)
    return ", ".join((*told, f"ISE {errors(seen, period)}"))


def errors(seen: Mapping[str, np.ndarray], period: float) -> str:
    """ISE [m2 s and rad2 s], and e1 [mm] as RMS over the last 10 s."""
    off = [seen[f"{name}_d"] - seen[name] for name in ("x", "y", "theta")]
    ise = sum(float(np.sum(item**2)) for item in off) * period
    ahead = -np.sin(seen["theta"]) * off[0] + np.cos(seen["theta"]) * off[1]
    last = ahead[-round(10.0 / period) :]
    return f"{ise:.3g}, e1 {1e3 * math.sqrt(float(np.mean(last**2))):.2f} mm"


def first(where: np.ndarray, period: float) -> float:
    """Time of the first sample where something holds [s]; inf for none."""
    return float(np.argmax(where)) * period if where.any() else math.inf


if __name__ == "__main__":
    main()
