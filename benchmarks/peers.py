"""Slower peers, apart from the cheap measures: python-control's simulator on the same closed loop.

``python -m benchmarks.peers`` prints how many times longer than ours it takes for a second of the
model-based loop: continuous law and plant, its own step control, NumPy inside.
"""

from __future__ import annotations

from functools import partial

import numpy as np
from numpy.typing import NDArray

from . import generated
from .numpy_loop import circle, rate
from .numpy_step import NumpyLaws
from .setup import Case, Setup
from .timing import Candidate, measure

Array = NDArray[np.float64]

SECONDS = 1.0
CONTROL = 1e-3


def candidates() -> dict[str, Candidate]:
    """One second of the loop by python-control, and 80 s of it in C; a step is 1 ms."""
    samples = round(SECONDS / CONTROL)
    return {
        "mb_loop": generated.closed_loop("mb", CONTROL),
        "mb_loop_control": Candidate(partial(control_loop, Setup(), Case()), samples),
    }


def control_loop(setup: Setup, case: Case, seconds: float = SECONDS) -> Array:
    """States (5, n) of the loop without noise by ``control.input_output_response``."""
    import control

    laws = NumpyLaws(setup)

    def rates(t: float, state: Array, *_: object) -> Array:
        torque = laws.mb_step(circle(case, t), state[:3], state[3:])
        return rate(setup, case.first, torque, state)

    system = control.nlsys(rates, None, inputs=0, states=5, outputs=5)
    times = np.arange(0.0, seconds, case.control)
    found: Array = control.input_output_response(system, times, 0, list(case.initial)).states
    return found


def main() -> None:
    """Print the ratio."""
    found = measure(candidates(), "mb_loop")["mb_loop_control"]
    print(f"python-control's simulator takes {found.ratio:.0f} times as long as our loop")


if __name__ == "__main__":
    main()
