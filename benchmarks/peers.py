"""Peers on the same closed loop, apart from the cheap measures: python-control, and numba.

``python -m benchmarks.peers`` prints how many times longer than ours they take: python-control's
simulator for a second of the model-based loop (continuous law and plant, its own step control,
NumPy inside), numba for the network law's step and loop where it is installed.
"""

from __future__ import annotations

from functools import partial

import numpy as np
from numpy.typing import NDArray

from . import generated, numba_peer
from .bench import CONTROL, STEPS, Ratio, quartiles
from .numpy_loop import circle, rate
from .numpy_step import NumpyLaws
from .setup import Case, Setup
from .timing import Builders, Candidate, built, measure

Array = NDArray[np.float64]

SECONDS = 1.0
RATIOS = (
    Ratio("mb_loop_control_vs_native", "mb_loop_control", "mb_loop", ""),
    Ratio("nn_step_numba_vs_native", "nn_numba", "nn", ""),
    Ratio("closed_loop_numba_vs_native", "nn_loop_numba", "nn_loop", ""),
)


BUILDERS: Builders = {
    "mb_loop": partial(generated.closed_loop, "mb", CONTROL),
    "mb_loop_control": lambda: Candidate(
        partial(control_loop, Setup(), Case()), round(SECONDS / CONTROL)
    ),
    "nn": partial(generated.step, "nn", STEPS),
    "nn_numba": lambda: numba_peer.step(Setup(), STEPS),
    "nn_loop": partial(generated.closed_loop, "nn", CONTROL),
    "nn_loop_numba": lambda: numba_peer.loop(Setup(period=CONTROL), Case(control=CONTROL)),
}
"""Loops by python-control, numba and in C, steps by numba and in C; a step is one sample."""


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
    """Print the ratios."""
    failed: dict[str, str] = {}
    found = measure(built(BUILDERS), "mb_loop", failed=failed)
    for item in RATIOS:
        values = quartiles(found, item)
        why = failed.get(item.above) or failed.get(item.below)
        print(f"{item.key:28} {f'{values[1]:.3g}' if values else f'not measured: {why}'}")


if __name__ == "__main__":
    main()
