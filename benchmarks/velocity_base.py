"""Filters of commands side by side on the same base: none, a usual smoother, clip and governor.

    python -m benchmarks.velocity_base

The base has the gain 1.08 and is pushed now and then; kanayama drives it from far away, 20 starts.
The usual smoother limits the command's rate and clips it at the limit: kanayama's own a_max at
2.5 m/s2, 3.2 rad/s2 (the usual numbers of Nav2's velocity_smoother) and share 1.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

import wmr_ctrl
from wmr_ctrl.world.scenario import load_scenario, override

STARTS = 20
FILTER = {
    "tau": [0.2, 0.3],
    "gain": [0.9, 1.1],
    "d": [0.03, 0.3],
    "odometry": [0.01, 0.02],
    "delay": [0.0, 0.03],
}
BASE: Mapping[str, Any] = {
    "changes": [],
    "base": {"kind": "velocity", "tau": [0.25, 0.25], "gain": [1.08, 1.08], "delay": 0.02},
    "disturbance.push": [5.0, 2.0],
    "clock.control": 0.05,
    "clock.duration": 20.0,
    "limits": {"v_u1": [1.0, 2.0], "v_u2": [0.7, 1.4]},
    "gains.kanayama": {"share": 1.0, "a_max": [100.0, 100.0]},
    "reference.rate": 0.35,
}
WAYS: Mapping[str, Mapping[str, Any]] = {
    "command clipped at the limit": {},
    "usual smoother, then the same": {"gains.kanayama.a_max": [2.5, 3.2]},
    "filter, clip": {"filter": {**FILTER, "kind": "clip"}},
    "filter, governor": {"filter": {**FILTER, "kind": "governor"}},
}


def main() -> None:
    """Print the table."""
    plain = override(load_scenario("paper-simulation-noise-free"), BASE)
    print("| commands | runs that broke a limit | largest share of it | RMS, last quarter [mm] |")
    print("|---|---|---|---|")
    for name, changes in WAYS.items():
        draw = np.random.default_rng(0)
        broken, most, away = 0, 0.0, []
        for _ in range(STARTS):
            start = [*draw.uniform(-3, 3, 2), draw.uniform(-3, 3)]
            run = wmr_ctrl.simulate(override(plain, {**changes, "initial.pose": start}), "kanayama")
            broken += run.monitor.violations > 0
            most = max(
                most, *(v / u for v, u in zip(run.monitor.max_abs_v, (1.0, 2.0), strict=True))
            )
            error = run["e"][-100:, :2]
            away.append(1e3 * float(np.sqrt(np.mean(np.sum(error**2, axis=1)))))
        print(f"| {name} | {broken} of {STARTS} | {most:.3f} | {np.median(away):.2g} |")


if __name__ == "__main__":
    main()
