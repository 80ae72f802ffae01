"""The observer of the force that the model does not explain."""

import math

import numpy as np
import pytest

from tests.control.laws.points import DRIVING, HALF, INERTIA, M, R, T, at, graph
from tests.papers_robot import paper
from wmr_ctrl.control.laws.context import LawContext
from wmr_ctrl.control.laws.observer import Observer
from wmr_ctrl.control.setup import settle


def test_an_observer_counts_on_friction_at_the_mean_velocity_and_begins_with_nothing():
    system, wo, mu_m_g, v_s = graph("prox"), 10.0, 0.08 * 50.0 * 9.81, 0.01
    old, f_hat, tau = np.array([0.004, 0.12]), np.array([3.0, -1.0]), np.array([2.0, 1.5])
    known = {"f_hat": f_hat.tolist(), "v_previous": old.tolist(), "started": [1.0]}
    given = {**DRIVING, "v1": 0.012, "tau_applied[1]": tau[0], "tau_applied[2]": tau[1]}
    v, mass = np.array([0.012, 0.1]), np.array([M, INERTIA])

    after = at(system, given, known)[1]
    first = at(system, given, {"started": [0.0]})[1]

    force = np.array([tau.sum(), HALF * (tau[0] - tau[1])]) / R
    friction = np.array([mu_m_g * math.tanh((v + old)[0] / 2 / v_s), 0.0])
    residual = force - mass * (v - old) / T - friction
    expected = f_hat + (1 - math.exp(-wo * T)) * (residual - f_hat)
    assert after.tolist() == pytest.approx([*expected, *v, 1.0])
    assert first.tolist() == [0.0, 0.0, *v, 1.0]


def test_it_publishes_the_negative_of_its_force():
    context = LawContext(settle(paper(), "mb"))
    observer = Observer(context, context.period, context.friction_at)

    assert (observer.diagnostics[0].expr + observer.force).is_zero()
    assert len(observer.state) == 3
