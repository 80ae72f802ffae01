"""The floor and its slow peer as candidates for `timing`.

``python -m benchmarks.floor`` in a checkout prints their times.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial

import numpy as np

from .hand_c import HandC
from .inputs import plant_torques, tracking_rows
from .numpy_step import NumpyLaws
from .setup import Case, Setup
from .timing import Candidate, Timing, measure

PLANT_STEP = 1e-3
STEPS = 100_000
"""Steps of one timing loop in C: about 10 ms."""


def step_candidates(hand: HandC | None = None, steps: int = STEPS) -> dict[str, Candidate]:
    """Hand-written control and plant steps, each a loop in C over a ring of inputs."""
    hand = hand or HandC()
    rows, library, law = tracking_rows(), hand.library, hand.law
    setup, W, start = Setup(), np.zeros(128), np.array([0.0, 0.0, 0.0, 0.15, 0.1])
    plant, torques = hand.plant(*Case().first, PLANT_STEP), plant_torques(setup, PLANT_STEP)
    mb = partial(library.hand_mb_repeat, law, steps, rows, len(rows))
    nn = partial(library.hand_nn_repeat, law, steps, rows, len(rows), W)

    def plant_loop() -> object:
        return library.hand_plant_repeat(plant, steps, torques, len(torques), start.copy())

    named: Mapping[str, Callable[[], object]] = {
        "mb_step": mb, "nn_step": nn, "plant_step": plant_loop
    }  # fmt: skip
    return {name: Candidate(run, steps) for name, run in named.items()}


def loop_candidates(
    control: float = 1e-3, setup: Setup | None = None, case: Case | None = None
) -> dict[str, Candidate]:
    """Hand-written closed loops of MB and NN; a step is one whole run."""
    hand = HandC(replace(setup or Setup(), period=control))
    case = replace(case or Case(), control=control)
    names = {"mb_loop": "mb", "nn_loop": "nn"}
    return {name: Candidate(partial(hand.loop, law, case), 1) for name, law in names.items()}


def numpy_candidates(steps: int = 500) -> dict[str, Candidate]:
    """NumPy control steps over the same ring of inputs."""
    laws, rows = NumpyLaws(Setup()), tracking_rows()
    parts = [(row[:7], row[7:10], row[10:]) for row in rows]

    def mb() -> None:
        for i in range(steps):
            laws.mb_step(*parts[i % len(parts)])

    def nn() -> None:
        W = np.zeros((2, 64))
        for i in range(steps):
            _, W = laws.nn_step(*parts[i % len(parts)], W)

    return {"mb_numpy": Candidate(mb, steps), "nn_numpy": Candidate(nn, steps)}


def main() -> None:
    """Print nanoseconds and ratios of everything in this module."""
    steps = measure({**step_candidates(), **numpy_candidates()}, "nn_step", rounds=15)
    loops = measure(loop_candidates(), "nn_loop", rounds=15)
    for timing in (*steps.values(), *loops.values()):
        print(line(timing))


def line(timing: Timing) -> str:
    """One row of the table."""
    spread = f"{timing.low:.2f} to {timing.high:.2f}"
    return f"{timing.name:12} {timing.ns:14,.1f} ns {timing.ratio:9.2f} times ({spread})"


if __name__ == "__main__":
    main()
