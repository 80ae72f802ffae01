"""Ways to a stop in numbers: what a push rolls, a hold, and which command still stops."""

from __future__ import annotations

import math

import casadi as ca
import pytest

from wmr_ctrl.control.filter.ways import Reached, Stop, covered

T, D, B, TAU = 0.05, 0.05, 1.0, (0.2, 0.3)
STOP = Stop(tuple(map(ca.SX, TAU)), ca.SX(D), ca.SX(B), ca.SX(T), ca.SX(0.1), ca.SX(0))


def number(expression) -> float:
    return float(ca.evalf(ca.SX(expression)))


def test_a_release_rolls_what_a_push_leads_to_while_the_brake_closes():
    assert number(STOP.roll) == pytest.approx(D * (B - 0.2 * (1 - math.exp(-B / 0.2))))


def test_after_a_hold_a_release_ends_no_nearer_than_where_it_began():
    """The slowest base is pulled away, then let go and pushed back until its brake closes."""
    pull = 0.2
    time = number(STOP.hold(ca.SX(pull)))
    fades = number(covered(ca.SX(time), ca.SX(0.3)))
    speed = -pull * fades / 0.3
    away = pull * time - pull * fades
    back = D * B + (speed - D) * 0.2 * (1 - math.exp(-B / 0.2))
    assert back <= away + 1e-12


def test_the_largest_steady_speed_stops_just_within_its_way():
    """Whatever the time constant is while the command acts; then the slowest base is worst."""
    free = 0.4
    m = number(STOP.steady(ca.SX(free), [Reached(0.1, ca.SX(0.03), ca.SX(0.2))]))
    ways = []
    for tau in TAU:
        share = 1 - math.exp(-T / tau)
        speed = 0.2 + (m - 0.2) * share
        way = 0.03 + m * T + (0.2 - m) * tau * share
        ways.append(way + D * B + (speed - D) * 0.3 * (1 - math.exp(-B / 0.3)))
    assert m > D
    assert max(ways) == pytest.approx(free, abs=1e-12)
