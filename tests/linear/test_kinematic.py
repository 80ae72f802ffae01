"""Certified sets, the saddle, and runs from inside and outside."""

import casadi as ca
import numpy as np

import wmr_ctrl
from wmr_ctrl.theory.linear import start_off
from wmr_ctrl.world.references import sample
from wmr_proofs.paper_functions import position_lyapunov

CERTIFIED = 0.4
"""2/k2: V2 at the saddle."""


def level(e):
    """V2 of Eq. (31) at errors (N, 3)."""
    symbol = ca.SX.sym("e", 3)
    graph = ca.Function("V2", [symbol], [position_lyapunov(symbol, ca.SX(5.0))])
    return np.asarray(graph(np.asarray(e).T)).ravel()


def test_runs_from_the_certified_set_converge(nominal):
    rng = np.random.default_rng(1)
    e = rng.uniform((-0.9, -0.9, -3.0), (0.9, 0.9, 3.0), (300, 3))
    starts = [start_off(nominal, row) for row in e[level(e) < CERTIFIED][:12]]
    found = wmr_ctrl.simulate_many(nominal, "mb", [0] * 12, starts=starts)
    end = sample(nominal, np.array([nominal.clock.duration]))[0, :2]

    assert (np.hypot(found["final_x"] - end[0], found["final_y"] - end[1]) < 0.05).all()
    assert set(found["outcome"]) == {"completed"}
