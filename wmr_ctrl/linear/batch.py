"""Many runs of one compiled loop from many starts, several robots at a time on each core."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np

from wmr_ctrl.linear.numbers import Floats
from wmr_ctrl.results import Outcome
from wmr_ctrl.sim.many import run_many
from wmr_ctrl.sim.ready import Ready
from wmr_ctrl.world.references import sample


@dataclass(frozen=True)
class Ending:
    """Where a run ended: outcome, distance to the reference [m], largest |v1| and |omega|.

    The distance is that at the end of the run; infinite for a run that ended early.
    """

    outcome: Outcome
    distance: float
    max_abs_v: tuple[float, float]


def endings(
    loop: Ready,
    starts: Iterable[Floats],
    jobs: int | None = None,
    progress: Callable[[float], None] | None = None,
) -> list[Ending]:
    """Run ``loop``, from `wmr_ctrl.api.compile_loop`, once from each start (5: pose and velocity).

    The same noise (seed 0) acts in all runs.  ``jobs``, ``progress`` and Ctrl-C as in
    `wmr_ctrl.sim.many.run_many`.
    """
    rows = [tuple(map(float, start)) for start in starts]
    table = run_many(
        lambda _: loop, [loop.scenario], [0] * len(rows),
        starts=rows, jobs=jobs, progress=progress,
    )  # fmt: skip
    scenario = loop.scenario
    end = sample(scenario.reference, np.array([scenario.clock.duration]))[0, :2]
    gaps = np.hypot(*(table["final_state"][:, :2] - end).T)
    gaps[table["stop"] > 0] = np.inf
    return [
        Ending(Outcome(outcome), float(gap), (float(v[0]), float(v[1])))
        for outcome, gap, v in zip(table["outcome"], gaps, table["max_abs_v"], strict=True)
    ]
