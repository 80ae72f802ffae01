"""Forces within the conditions on a guard, which the tests' own guard passes, and some beyond."""

from __future__ import annotations

import casadi as ca
import numpy as np

from tests.oracle.guard import VelocityGuard
from wmr_ctrl.control.setup import settle
from wmr_ctrl.corridor.inputs import conditions
from wmr_ctrl.scenario import load_scenario


def test_within_the_conditions_a_guard_passes_every_force_and_hardly_any_beyond():
    told = {"disturbance.std": 0.3, "sensor.velocity_noise": [0.01, 0.02]}
    scenario = load_scenario("safe-simulation", told)
    setup, asked, v = settle(scenario, "prox"), ca.SX.sym("F", 2), ca.SX.sym("v", 2)
    shares = ca.Function("shares", [asked, v], [ca.vertcat(*(
        ca.fabs(item.value) / item.most for item in conditions(setup, asked, v)
    ))])  # fmt: skip
    guard, rng = VelocityGuard(scenario, setup.tau_max), np.random.default_rng(3)

    passed = {True: [], False: []}
    for _ in range(400):
        speed = rng.uniform(-1.1, 1.1, 2) * scenario.limits.v_u1
        force = rng.uniform(-1.1, 1.1, 2) * (500.0, 60.0)
        within = float(ca.mmax(shares(force, speed))) <= 1
        sent = guard.act(tuple(force), tuple(speed), (0.0, 0.0))
        passed[within].append(bool(np.allclose(sent, force, rtol=1e-9)))
    assert len(passed[True]) > 100 < len(passed[False])
    assert all(passed[True])
    assert np.mean(passed[False]) < 0.05
