"""How long a law's evaluations take, called one by one from Python."""

from __future__ import annotations

import time

from wmr_ctrl.sim.compiled_law import CompiledLaw

EVALUATIONS = 10_000
"""As many as the paper timed."""

START_SAMPLE = (0.0, 0.0, -1.5707963, 0.2, 0.1, 0.0, 0.0, -0.5, -0.5, -0.7, 0.3, -0.4)
"""A sample near the paper's start: reference, pose, velocity."""


def seconds_of(law: CompiledLaw, count: int = EVALUATIONS) -> float:
    """Seconds that ``count`` evaluations of ``law`` take."""
    law.u[:] = START_SAMPLE
    begin = time.perf_counter()
    for _ in range(count):
        law.step()
    return time.perf_counter() - begin
