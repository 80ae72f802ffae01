"""Forces within the guard's conditions pass the tests' own guard; some beyond them do not."""

import casadi as ca
import numpy as np
import pytest

from tests.oracle.guard import VelocityGuard
from tests.papers_robot import safe
from tests.tables import changes
from wmr_ctrl.control.guard.bounds import net
from wmr_ctrl.control.setup import settle
from wmr_proofs.corridor.inputs import conditions
from wmr_proofs.corridor.late_guard import ROOM, sizes_of_forces


def test_within_the_conditions_a_guard_passes_every_force_and_hardly_any_beyond():
    told = changes("disturbance.std = 0.3; sensor.velocity_noise = [0.01, 0.02]")
    scenario = safe(told)
    setup, asked, v = settle(scenario, "prox"), ca.SX.sym("F", 2), ca.SX.sym("v", 2)
    shares = ca.Function("shares", [asked, v], [ca.vertcat(*(
        ca.fabs(item.value) / item.most for item in conditions(setup, asked, v)
    ))])  # fmt: skip
    guard, rng = VelocityGuard(scenario, setup.tau_max), np.random.default_rng(3)

    passed, stopped = [], []
    for _ in range(300):
        speed = rng.uniform(-1.0, 1.0, 2) * scenario.limits.v_u1
        force = rng.uniform(-1.0, 1.0, 2) * (4000.0, 400.0)
        largest = float(ca.mmax(shares(force, speed)))
        for share, found in ((0.9999, passed), (1.02, stopped)):
            near, slow = (tuple(share / largest * part) for part in (force, speed))
            found.append(bool(np.allclose(guard.act(near, slow, (0.0, 0.0)), near, rtol=1e-9)))
    assert all(passed)
    assert np.mean(stopped) < 0.02


def test_forces_in_transit_are_counted_with_the_guards_own_disturbance_at_least():
    setup = settle(safe("actuator.delay = 0.02"), "prox")
    least = np.array([net(setup.guard, axis) for axis in (0, 1)])

    assert (least > 0).all()
    assert sizes_of_forces(setup, 0.1 * least).tolist() == least.tolist()
    assert sizes_of_forces(setup, 5.0 * least) == pytest.approx(5.0 * ROOM * least)
