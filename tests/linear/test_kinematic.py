"""Certified sets, the saddle, and runs from inside and outside."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from analysis.starts import certified, converged, endings, level, start_at
from wmr_ctrl.api import compile_loop
from wmr_ctrl.control.barrier.stable import stable_minimiser
from wmr_ctrl.control.setup import kinematic_gains
from wmr_ctrl.results import Outcome
from wmr_ctrl.theory.linear import SADDLE, kinematic_loop
from wmr_ctrl.world.model.kinematics import auxiliary_velocity, error_rate
from wmr_ctrl.world.scenario import override


def test_levels_of_the_audit(nominal):
    found = certified(nominal)

    assert found.ideal == pytest.approx(0.4)
    assert found.saturated == pytest.approx(0.4)

    paper_start = np.array((0.70453, -0.06031, -0.87080))
    assert level(nominal, paper_start) == pytest.approx(0.32116, abs=1e-5)


def test_a_reference_faster_than_the_barrier_is_certified_nowhere(nominal):
    fast = override(nominal, {"reference.radius": 9.0})

    assert certified(fast).saturated == 0.0


def test_the_saddle_is_a_resting_point(nominal):
    loop = kinematic_loop(nominal)
    rate = loop.function("rate", [loop.update])((0.2, 0.1), SADDLE, [])

    assert np.abs(np.asarray(rate)).max() < 1e-15


def test_saturated_kinematics_never_raise_v2_inside_the_certified_set(nominal):
    v_d, at = ca.SX.sym("v_d", 2), ca.SX.sym("e", 3)
    asked = auxiliary_velocity(at, v_d, ca.SX(ca.DM(kinematic_gains(nominal).k)))
    limits = zip(nominal.limits.v_u1, nominal.limits.v_u2, strict=True)
    v = [stable_minimiser(asked[i], ca.SX(u1), ca.SX(u2)) for i, (u1, u2) in enumerate(limits)]
    rate = ca.Function("rate", [v_d, at], [error_rate(at, ca.vertcat(*v), v_d)])
    rng = np.random.default_rng(0)
    e = rng.uniform((-0.9, -0.9, -np.pi), (0.9, 0.9, np.pi), (4000, 3))
    inside = e[level(nominal, e) < certified(nominal).saturated]
    velocity = np.tile(((0.2,), (0.1,)), len(inside))
    moving = np.asarray(rate(velocity, inside.T)).T
    slope = inside[:, 0] * moving[:, 0] + inside[:, 1] * moving[:, 1]

    assert len(inside) > 500
    assert (slope + np.sin(inside[:, 2]) * moving[:, 2] / 5.0).max() <= 1e-9


def test_starts_have_the_error_that_was_asked_for(nominal):
    short = override(nominal, {"clock.duration": 0.05})
    wanted = np.array((0.3, -0.2, 0.9))
    ending = endings(compile_loop(short, "mb"), [start_at(short, wanted)])[0]

    assert ending.distance == pytest.approx(np.hypot(0.3, 0.2), abs=0.05)
    assert start_at(nominal, np.array((0.70453, -0.06031, -0.87080)))[:3] == pytest.approx(
        (-0.5, -0.5, -0.7), abs=1e-4
    )


def test_runs_from_the_certified_set_converge(nominal):
    loop = compile_loop(nominal, "mb")
    rng = np.random.default_rng(1)
    e = rng.uniform((-0.9, -0.9, -3.0), (0.9, 0.9, 3.0), (300, 3))
    inside = e[level(nominal, e) < certified(nominal).saturated][:12]
    found = endings(loop, [start_at(nominal, row) for row in inside])

    assert len(found) == 12
    assert converged(found).all()
    assert {item.outcome for item in found} == {Outcome("completed")}
