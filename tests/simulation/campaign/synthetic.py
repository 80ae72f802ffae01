"""A stand-in for the engine: smooth, made-up runs of 80 s in a tenth of the samples."""

from contextlib import contextmanager
from unittest.mock import patch

import numpy as np

from tests.results.conftest import build
from wmr_ctrl.core.signals import Signal
from wmr_ctrl.results import Monitor

W_NORM = Signal("W_norm", "1", "norm of the weights", 2)
PACE = {"pid": 0.1, "smc": 0.3, "mb": 0.05, "nn": 0.2}


def simulate(scenario, law, seed):
    """A distance that decays, an oscillation that depends on the seed, a limit broken by PID and
    SMC.
    """
    t = 0.1 * np.arange(800)
    wiggle = 0.01 * np.sin(t + seed)
    gap = 0.7 * np.exp(-PACE.get(law, 0.1) * t) + wiggle
    fast = 3.0 if law in ("pid", "smc") or scenario.startswith("far") else 0.9
    weights = {"W_norm": np.outer(1 + t, (1.0, 2.0))} if law == "nn" else {}
    return build(
        duration=80.0,
        control=0.1,
        monitor=Monitor((fast, 0.5), 40, (0.1, 1)) if fast > 1.0 else Monitor((fast, 0.5)),
        extra=(W_NORM,) if weights else (),
        labels={"scenario": scenario, "law": law, "seed": seed},
        x=2 * np.sin(0.1 * t) + gap,
        y=2 - 2 * np.cos(0.1 * t),
        x_d=2 * np.sin(0.1 * t),
        y_d=2 - 2 * np.cos(0.1 * t),
        theta=0.1 * t + gap,
        theta_d=0.1 * t,
        v1=0.2 + gap,
        omega=0.1 + wiggle,
        v1_d=0.2,
        tau_right=3 + 40 * gap,
        tau_left=3 - 20 * gap,
        e=np.outer(gap, (1.0, 0.5, 0.1)),
        V1=gap**2 + 1e-6,
        margin=1 - np.abs(0.2 + gap),
        **weights,
    )


@contextmanager
def made_up(simulate=simulate, asked=lambda case: None):
    """Replace campaigns' compiled loops by ``simulate``; ``asked`` is called with each case."""

    def build(case, device="cpu"):
        asked(case)
        return lambda seed: simulate(case.scenario, case.law, seed)

    with (
        patch("wmr_ctrl.simulation.campaign.engine.build_loop", build),
        patch("wmr_ctrl.simulation.campaign.engine.run_each", in_turn),
        patch("wmr_ctrl.simulation.physics.run.run_rigid_each", in_turn),
    ):
        yield


def in_turn(runs, then, jobs=None, progress=None):
    """A stand-in for the functions that run many loops together."""
    results = []
    for place, (loop, seed) in enumerate(runs):
        results.append(then(place, loop(seed)))
        if progress:
            progress((place + 1) / len(runs))
    return results
