"""Test vectors detect an error in every number of a law, and the guard acts in them."""

import numpy as np
import pytest

from tests.codegen.measured import SCENARIOS
from wmr_ctrl.codegen.package import packaged
from wmr_ctrl.codegen.vectors import SAMPLES, SITUATIONS, TOLERANCES, vectors_of
from wmr_ctrl.control.controller import controller
from wmr_ctrl.control.setup import settle
from wmr_ctrl.world.scenario import load_scenario

UNSEEN = {
    "clock.control": "MB holds no memory",
    "gains.nn.ratio_cap": "so far from the nodes the network is 0",
    "guard.brake": "as derived, it is what the guard does anyway",
    "guard.f_speed": "f_min is 0 by default",
    "limits.clip": "shows only beyond the limit, where the guard takes over",
    "guard.M_max": "prox brakes by itself where it counts",
}


def unseen(system, vectors):
    """Names of parameters for which an error of 1 % stays within the checker's tolerance."""
    names, missed = [p.signal.name for p in system.params for _ in p.value], set()
    machine = system.function("step", [system.update, system.y])
    for k, value in enumerate(system.p0):
        p, x, bound = np.array(system.p0), system.x0, TOLERANCES[False]
        p[k] = 5.0 if np.isinf(value) else 1.01 * value or 0.01
        for row, (u, wanted) in enumerate(zip(vectors.inputs, vectors.torques, strict=True)):
            x, torque = machine(u, x if row % SAMPLES else system.x0, p)
            if (abs(torque.full().ravel() - wanted) > bound * (1 + abs(wanted))).any():
                break
        else:
            missed.add(names[k])
    return missed


@pytest.mark.parametrize(
    "law, guarded",
    [("mb", False), ("prox", True), ("pid", True), ("nn", True), ("kanayama", False)],
)
@pytest.mark.slow_but("mb-False", "prox-True")
def test_an_error_of_one_per_cent_in_any_number_is_seen(law, guarded):
    scenario = load_scenario(SCENARIOS[guarded])
    system = controller(settle(scenario, law))
    shown_only = {"pid": {"limits.v_u2"}, "kanayama": {"limits.v_u2", "gains.kinematics.k"}}
    missed = unseen(system, vectors_of(system, scenario.limits))

    assert missed <= set(UNSEEN) | shown_only.get(law, set())


def test_counts_of_the_wheels_are_those_of_the_speeds_in_their_place():
    of = load_scenario(SCENARIOS[False], {"encoder.counts": 1e7})
    setup, robot = settle(of, "mb"), of.robot
    plain = vectors_of(controller(setup), of.limits).inputs
    counted = vectors_of(packaged(setup), of.limits)
    for k in range(0, len(plain), SAMPLES):
        moved = counted.inputs[k + 1 : k + SAMPLES, -2:]
        steps = np.diff(counted.counts[k : k + SAMPLES], axis=0)
        wrapped = (steps + 2**31) % 2**32 - 2**31
        assert (wrapped == moved).all()
        assert (steps != wrapped).any() == (moved[0] > 0).any()
        right, left = (moved * 2 * np.pi / 1e7 * robot.r / of.clock.control).T
        v = np.column_stack(((right + left) / 2, (right - left) / (2 * robot.l)))
        assert v == pytest.approx(plain[k + 1 : k + SAMPLES, -2:], abs=1e-4)


def test_runs_cover_both_sides_of_both_limits():
    scenario = load_scenario(SCENARIOS[False])
    vectors = vectors_of(controller(settle(scenario, "mb")), scenario.limits)
    share = vectors.inputs[:, -2:] / scenario.limits.v_u1

    assert len(vectors.inputs) == SAMPLES * len(SITUATIONS)
    assert (share > 1).any(axis=0).all()
    assert (share < -1).any(axis=0).all()
    assert np.isfinite(vectors.torques).all()
