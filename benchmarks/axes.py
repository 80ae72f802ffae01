"""Speed gained by separate bounds of v and omega: ``python -m benchmarks.axes``.

Each row is a base whose axes differ, once with one interval that holds both axes and once with one
for each. The figure is the steady speed of one axis with a request of ten times its limit, without
pushes and with exact odometry.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from wmr_ctrl import load_scenario
from wmr_ctrl.control.filter import command_filter
from wmr_ctrl.world.scenario import Scenario

GOVERNED: Mapping[str, Any] = {
    "filter.kind": "governor", "filter.tau": (0.2, 0.3), "filter.gain": (0.9, 1.1),
    "filter.d": (0.05, 0.05), "filter.odometry": (0.02, 0.02), "limits.v_u1": (1.0, 1.0),
    "limits.v_u2": (0.7, 0.7), "clock.control": 0.05,
}  # fmt: skip
CLIPPED = {**GOVERNED, "filter.kind": "clip"}
MOWER: Mapping[str, Any] = {
    "filter.kind": "clip", "filter.damping": (0.4, 1.2), "filter.gain": (0.9, 1.0),
    "filter.d": (0.01, 0.05), "limits.v_u1": (0.3, 0.8), "limits.v_u2": (0.2, 0.6),
    "clock.control": 0.1,
}  # fmt: skip
SKIDS = {"filter.gain": ((0.95, 1.05), (0.8, 1.5))}


@dataclass(frozen=True)
class Case:
    """Base: its scenario, bounds for both axes together and for each, and the axis that is
    measured.

    ``gain``, ``tau`` [s] and delay ``late`` [s] are the true ones.
    """

    preset: str
    stated: Mapping[str, Any]
    both: Mapping[str, Any]
    apart: Mapping[str, Any]
    axis: int = 0
    gain: float = 1.0
    tau: float = 0.2
    late: float = 0.0


CASES: Mapping[str, Case] = {
    "mower whose yaw overshoots: v behind a clip": Case(
        "paper-simulation", MOWER, {"filter.loop": "second-order"},
        {"filter.loop": ("first-order", "second-order")},
    ),
    "Jackal whose turning gain is 0.8 to 1.5: v behind a clip": Case(
        "clearpath-jackal", {}, {"filter.gain": (0.8, 1.5)}, SKIDS
    ),
    "skid-steer with these gains: v behind a clip": Case(
        "paper-simulation", CLIPPED, {"filter.gain": (0.8, 1.5)}, SKIDS, gain=0.95
    ),
    "the same behind a governor": Case(
        "paper-simulation", GOVERNED, {"filter.gain": (0.8, 1.5)}, SKIDS, gain=0.95
    ),
    "omega late by 0.02 to 0.2 s, v by 0.02 s: v behind a governor": Case(
        "paper-simulation", GOVERNED, {"filter.delay": (0.02, 0.2)},
        {"filter.delay": ((0.02, 0.02), (0.02, 0.2))}, gain=0.9, late=0.02,
    ),
    "tau of v 0.1 to 0.15 s, of omega 0.4 to 0.6 s: omega behind a governor": Case(
        "paper-simulation", GOVERNED, {"filter.tau": (0.1, 0.6)},
        {"filter.tau": ((0.1, 0.15), (0.4, 0.6))}, axis=1, gain=0.9, tau=0.4,
    ),
}  # fmt: skip


def rest(scenario: Scenario, case: Case) -> float:
    """Speed [m/s or rad/s] at which the axis comes to rest."""
    filtering, stated, T = command_filter(scenario), scenario.filter, scenario.clock.control
    axis, v, before = np.eye(2)[case.axis], 0.0, 0.0
    asked, governs = 10 * axis * scenario.limits.v_u1, stated.kind == "governor"
    for _ in range(math.ceil(30 * case.tau / T)):
        command = filtering.step(asked, axis * v if governs else None).command[case.axis]
        for u, time in ((before, case.late), (command, T - case.late)):
            v += -math.expm1(-time / case.tau) * (case.gain * u - v)
        before = command
    return v


def rows() -> Iterator[tuple[str, float, float, float]]:
    """Rows: each case, its limit, and its speed with common and with separate intervals."""
    for name, case in CASES.items():
        speeds = [
            rest(load_scenario(case.preset, {**case.stated, **own}), case)
            for own in (case.both, case.apart)
        ]
        limit = load_scenario(case.preset, case.stated).limits.v_u1[case.axis]
        yield name, limit, speeds[0], speeds[1]


def main() -> None:
    """Print the table."""
    print("| base | limit | one interval | one for each axis |")
    print("|---|---|---|---|")
    for name, limit, both, apart in rows():
        print(f"| {name} | {limit:g} | {both:.3g} | {apart:.3g} |")


if __name__ == "__main__":
    main()
