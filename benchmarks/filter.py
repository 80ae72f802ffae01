"""A step of the command filter against a clip written by hand: ``python -m benchmarks.filter``.

Steps are timed in sequence: each begins with the memory that the previous one left.
"""

from __future__ import annotations

import ctypes
from collections.abc import Mapping
from functools import partial
from typing import Any

import numpy as np

from benchmarks.drive import in_place
from benchmarks.native import load_filter
from benchmarks.timing import Candidate, measure_in_processes
from wmr_ctrl.control.filter import filter_system
from wmr_ctrl.world.scenario import load_scenario

STATED: Mapping[str, Any] = {
    "filter.gain": (0.9, 1.1), "filter.d": (0.05, 0.05), "limits.v_u1": (1.0, 1.5),
    "limits.v_u2": (0.7, 1.0), "clock.control": 0.05,
}  # fmt: skip
GOVERNED = {"filter.kind": "governor", "filter.tau": (0.2, 0.3), "filter.odometry": (0.02, 0.02)}
BANDED = {
    "filter.kind": "band", "filter.loop": "second-order", "filter.damping": (0.5, 1.0),
    "filter.frequency": (2.9, 3.6), "clock.control": 0.05,
}  # fmt: skip
ALL = {
    **GOVERNED, "filter.delay": (0.02, 0.06), "filter.losses": 1, "filter.jitter": 0.004,
    "filter.age": 0.12,
}  # fmt: skip
BESIDE = {**ALL, "filter.wheel_speed": 1.2, "filter.scale": "turn"}
CASES: Mapping[str, tuple[Mapping[str, Any], int, float]] = {
    "clip": ({"filter.kind": "clip"}, 100_000, 0.0),
    "governor": (GOVERNED, 100_000, 0.0),
    "governor, delay of 0 to 30 ms": ({**GOVERNED, "filter.delay": (0.0, 0.03)}, 100_000, 0.0),
    "governor, all at once": (ALL, 50_000, 0.0),
    "the same, odometry 100 ms old": (ALL, 50_000, 0.1),
    "the same with a limit for wheels, turning first": (BESIDE, 20_000, 0.0),
    "that, odometry 100 ms old": (BESIDE, 20_000, 0.1),
    "band of 50 commands": (BANDED, 10_000, 0.0),
}
"""Cases: settings, steps per round, and age of odometry [s]."""
FLOOR = "clip by hand"


def candidates() -> dict[str, Candidate]:
    """The floor and every case."""
    found = {}
    for name, (changes, steps, age) in CASES.items():
        scenario = load_scenario("paper-simulation", {**STATED, **changes})
        system, draw = filter_system(scenario), np.random.default_rng(0)
        library = load_filter(scenario, "filter_step")
        state, width = np.zeros(library.filter_size()), system.u.numel()
        library.filter_begin(state.ctypes.data_as(ctypes.c_void_p))
        rows = np.zeros((64, width))
        rows[:, :2] = np.repeat(draw.uniform(-2, 2, (16, 2)), 4, axis=0)
        if width > 3:
            rows[:, 2:4], rows[:, 4] = draw.uniform(-0.3, 0.3, (64, 2)), age
        if not found:
            run = in_place(library.hand_step, rows, state, system.y.numel())
            found[FLOOR] = Candidate(partial(run, 500_000), 500_000)
        run = in_place(library.filter_step, rows, state, system.y.numel())
        found[name] = Candidate(partial(run, steps), steps)
    return found


def main() -> None:
    """Print the table."""
    print("| step | ns here | times the clip by hand (quartiles) |")
    print("|---|---|---|")
    for name, item in measure_in_processes(candidates, FLOOR).items():
        print(f"| {name} | {item.ns:.3g} | {item.ratio:.3g} ({item.low:.3g} to {item.high:.3g}) |")


if __name__ == "__main__":
    main()
