"""Laws' graphs at single points, against their formulas worked out here."""

from __future__ import annotations

import math
from collections.abc import Mapping

import casadi as ca
import numpy as np
import pytest

from tests.papers_robot import paper
from wmr_ctrl.control.barrier.stable import stable_barrier
from wmr_ctrl.control.controller import law_graph
from wmr_ctrl.control.laws.context import LawContext
from wmr_ctrl.control.laws.law import commands_predicted
from wmr_ctrl.control.laws.prediction import slowed
from wmr_ctrl.control.laws.prox import ProxGains, guide
from wmr_ctrl.control.laws.pursuit import point_ahead
from wmr_ctrl.control.setup import settle
from wmr_ctrl.world.model.system import System
from wmr_ctrl.world.scenario import override

T, M, INERTIA, R, HALF = 0.01, 50.0, 5.4, 0.1, 0.25
DRIVING = {"x_d": 0.1, "y_d": 0.2, "theta_d": 0.3, "v1_d": 0.4, "v2_d": 0.2, "x": 0.08, "y": 0.15,
           "theta": 0.25, "v1": 0.45, "omega": 0.1}  # fmt: skip


def graph(law: str, **changed: object) -> System:
    return law_graph(settle(override(paper(), changed), law))


def at(system: System, given: Mapping[str, float], memory: Mapping[str, list[float]] | None = None):
    """Output and next memory for inputs and memory by name; what is not named is 0."""
    u = [given.get(name, 0.0) for item in system.inputs for name in item.signal.elements]
    x = [number for item in system.state
         for number in (memory or {}).get(item.signal.name, [0.0] * item.signal.size)]  # fmt: skip
    step = system.function("step", [system.y, system.update])
    return [np.asarray(part).ravel() for part in step(u, x, system.p0)]


@pytest.mark.parametrize(("delay", "count"), [
    (0.0, 0), (0.03, 3), (0.07, 7), (0.0300001, 4), (0.0299, 3), (1e-4, 1),
])  # fmt: skip
def test_commands_are_predicted_over_a_delay_as_its_decimals_say(delay: float, count: int) -> None:
    assert commands_predicted(ProxGains(delay=delay), T) == count
    assert commands_predicted(ProxGains(delay=delay / 7), T / 7) == count


def test_the_exact_decay_is_that_of_a_whole_period() -> None:
    """The force is linear in the rate: two rates tell which one the option stands for."""

    def force(**gains: object) -> np.ndarray:
        return at(graph("mb", **{f"gains.mb.{name}": value for name, value in gains.items()}),
                  DRIVING)[0]  # fmt: skip

    rho = np.array([15.0, 57.6])
    one, double, exact = force(), force(rho=(2 * rho).tolist()), force(decay="exact")
    rate = rho * (1 + (exact - one) / (double - one))

    assert rate == pytest.approx((1 - np.exp(-rho * T)) / T, rel=1e-9)


def test_an_observer_counts_on_friction_at_the_mean_velocity_and_begins_with_nothing() -> None:
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


def test_prox_makes_up_for_friction_at_the_speed_that_it_is_after() -> None:
    slow = {**DRIVING, "v1": 0.0, "omega": 0.0, "v1_d": 0.02}
    rough, smooth = (at(graph("prox", **{"model.mu": mu}), slow)[0] for mu in (0.08, 0.0))

    reached = T * smooth[0] / M
    friction = 0.08 * M * 9.81 * math.tanh(reached / 0.01)
    assert reached > 1e-3
    assert rough - smooth == pytest.approx([friction, 0.0], rel=1e-6)


def test_pid_begins_without_a_difference() -> None:
    system = graph("pid")
    first, later = (at(system, DRIVING, {"started": [k]})[0] for k in (0.0, 1.0))
    _, after = at(system, DRIVING)
    z = after[:2]

    assert first == pytest.approx(-np.array([210.0, 1.1]) * z)
    assert later == pytest.approx(first - np.array([0.64, 0.08]) * z / T)


def test_friction_stops_and_never_turns_round() -> None:
    for free, taken, left in ((0.1, 0.5, 0.0), (-0.1, -0.5, 0.0), (1.0, 0.25, 0.75), (-1, -2, 0)):
        assert float(ca.evalf(slowed(ca.SX(free), ca.SX(taken)))) == left


@pytest.mark.parametrize(("period", "delay"), [(0.01, 0.0), (0.01, 0.05), (0.1, 0.1), (0.05, 0.2)])
def test_the_guides_observer_slows_with_period_and_delay_together(period, delay) -> None:
    assert guide(period, delay, 0.2).wo == pytest.approx(min(10.0, 0.45 / (period + delay)))
    for wrong in ((0.0, delay, 0.2), (period, -1e-9, 0.2), (period, delay, 0.0)):
        with pytest.raises(ValueError, match="needs period, speed > 0"):
            guide(*wrong)


def test_pursuit_looks_no_farther_round_than_its_widest_angle() -> None:
    context = LawContext(settle(paper(), "pursuit"))
    point, way = point_ahead(context)
    symbols = ca.vertcat(*(item.sym for item in context.inputs), context.parameters.ports and
                         ca.vertcat(*(item.sym for item in context.parameters.ports)))  # fmt: skip
    look = ca.Function("look", [symbols], [point, way])
    numbers = [number for item in context.parameters.ports for number in item.value]
    for v1_d, v2_d, half in (
        (0.1, 2.0, 0.75),
        (0.1, -9.0, -0.75),
        (0.1, 1.0, 0.75),
        (0.4, 0.2, 0.15),
    ):
        u = [0.0, 0.0, 0.0, v1_d, v2_d, *[0.0] * 7]
        seen, far = (np.asarray(part).ravel() for part in look([*u, *numbers]))
        length = min(max(1.5 * v1_d, 0.3), 0.9)
        chord = length * math.sin(half) / half
        assert far == pytest.approx([length])
        assert seen == pytest.approx([chord * math.cos(half), chord * math.sin(half)])


def test_a_first_command_is_counted_from_the_measured_velocity_and_later_ones_from_the_last() -> (
    None
):
    base = {"base.kind": "velocity", "base.tau": [0.1, 0.1], "actuator.tau_max": 20.0}
    system = graph("kanayama", **base)
    given = {**DRIVING, "v1": -0.3, "omega": 0.9, "v_sent_before[1]": 0.1, "v_sent_before[2]": 0.0}

    first, later = (at(system, given, {"started": [k]})[0] for k in (0.0, 1.0))

    most = np.array([2.0, 6.0]) * T
    assert np.abs(first - [-0.3, 0.9]) == pytest.approx(most)
    assert np.abs(later - [0.1, 0.0]) == pytest.approx(most)


@pytest.mark.parametrize("v", [0.9999995, 1.0, 1.7, -1.0, -5.0])
def test_beyond_the_limit_barriers_are_those_just_inside(v: float) -> None:
    context = LawContext(settle(paper(), "mb"))
    V1 = context.barrier[0].V1
    ports = context.parameters.ports
    clip = ca.Function("clip", [ca.vertcat(*(i.sym for i in (*context.inputs, *ports)))], [V1])
    numbers = [number for item in ports for number in item.value]
    u = [0.0, 0.0, 0.0, 0.4, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, v, 0.0]
    inside = math.copysign(1.0 - 1e-6, v)

    expected = stable_barrier(*map(ca.SX, (0.4, inside, 1.0, 0.8))).V1
    assert float(clip([*u, *numbers])) == pytest.approx(float(ca.evalf(expected)), rel=1e-9)
