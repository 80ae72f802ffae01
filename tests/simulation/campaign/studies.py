"""Studies that the tests run: one of made-up figures, one of real runs."""

import numpy as np

from wmr_ctrl.simulation.campaign.study_plan import plan_of
from wmr_ctrl.simulation.campaign.study_run import run_study

FACTS = {"version": "1", "kernels": "ab"}
PLAN = {
    "laws": ["mb", "prox"],
    "guard": [False, True],
    "seeds": {"first": 3, "count": 5},
    "grid": {"robot.m": [40, 50.5]},
    "sample": {"method": "latin-hypercube", "n": 3, "robot": {"mu": [0.05, 0.1]}},
    "figures": ["violated", "position_rms", "ise_total"],
    "chunk": 7,
}
REAL = {
    "scenario": "far-start",
    "laws": ["mb"],
    "guard": [False, True],
    "seeds": 2,
    "set": {"clock.duration": 1.0, "disturbance.truncate": 3.0},
    "grid": {"actuator.tau_max": [1.0, 20.0]},
    "figures": ["position_rms", "max_abs_v1", "violated", "d_start"],
}


def figures(chunk, jobs=None):
    """Numbers that depend only on the case and the seed; sometimes none."""
    rows = []
    for case, seed in chunk.runs:
        mass, mu = case.overrides["robot.m"], case.overrides["robot.mu"]
        broken = float((seed * 7 + int(mass) + case.guard) % 3 == 0)
        rows.append((broken, mass * mu / (seed + 1), np.nan if seed == 4 else 1 / 3 + seed))
    table = np.array(rows).T
    named = dict(zip(("violated", "position_rms", "ise_total"), table, strict=True))
    outcome, refusal = np.array(["completed"] * len(rows)), np.array([""] * len(rows))
    return {"outcome": outcome, "refusal": refusal, **named}


def table_of(out, **changes):
    plan = plan_of({**PLAN, **changes})
    return run_study(plan, out, figures, FACTS).table.read_bytes()


def refuse_after(count, error):
    """Make a given number of chunks and then fail."""
    left = [count]

    def make(chunk, jobs=None):
        if left[0] == 0:
            raise error
        left[0] -= 1
        return figures(chunk)

    return make
