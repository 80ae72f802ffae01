"""The governor's bounds of a first-order base, in numbers."""

from math import exp

import casadi as ca
import pytest

from wmr_ctrl.control.filter.governor import (
    FirstOrder,
    Schedule,
    SpeedBound,
    admitted,
    drive,
    drive_back,
    largest_command,
    relaxed,
)

B = FirstOrder(V=1.0, dbar=0.1, nbar=0.0, K_min=0.9, K_max=1.2, kappa=0.5)


def number(expression):
    return float(ca.evalf(ca.SX(expression)))


@pytest.mark.parametrize("u, ahead, back", [(0.5, 0.7, -0.35), (-0.5, -0.35, 0.7), (0, 0.1, 0.1)])
def test_a_command_drives_by_the_worse_gain_and_the_push(u, ahead, back):
    assert number(drive(u, B)) == pytest.approx(ahead)
    assert number(drive_back(u, B)) == pytest.approx(back)


def test_behind_a_slower_base_a_larger_command_is_safe():
    assert number(largest_command(1.0, B)) == pytest.approx(0.9 / 1.2)
    assert number(largest_command(0.4, B)) == pytest.approx(0.9 / 1.2 + 0.5 / 1.2 * 0.6)


@pytest.mark.parametrize("target, bound", [(1.0, 0.5 + 0.8 * 0.5), (0.0, 0.5 - 0.2 * 0.5)])
def test_a_bound_rises_by_the_most_and_falls_by_the_least(target, bound):
    assert number(relaxed(0.5, target, 0.8, 0.2)) == pytest.approx(bound)


def test_old_odometry_is_carried_through_each_piece_of_time_since():
    late, v, sent = Schedule((0.3, 0.3), age=1.0), 0.2, [0.0, 0.7, -0.4]
    for piece in late.pieces(-1.0, 0.0, 1):
        v += (1 - exp((piece.start - piece.end) / 3)) * (sent[piece.ages[0]] - v)
    bound = SpeedBound(late, B, (ca.SX(3),) * 2, ca.SX(1))
    assert number(bound.now(ca.SX(0.2), ca.SX(1), sent)) == pytest.approx(v)


def test_a_share_is_that_of_the_limit_on_its_side():
    shares = admitted([ca.SX(2.0), ca.SX(-2.0), ca.SX(0.1)], [-1.0] * 3, [0.5] * 3)

    assert [number(item) for item in shares] == pytest.approx([0.25, 0.5, 1.0])


def test_a_schedule_knows_how_long_commands_act():
    plain = Schedule()
    late = Schedule(delay=(0.2, 1.5), losses=2, jitter=0.1, age=0.5, hold=4.0)

    assert (plain.longest, plain.oldest) == (1.0, 1)
    assert late.longest == pytest.approx(4.0 + 1.3)
    assert late.oldest == max(k for k in range(1, 20) if 1.5 - (k - 3) * 0.9 > -0.5)
    pieces = plain.pieces(0.0, 2.0, 0, cut=0.5)
    assert [(item.start, item.end) for item in pieces] == [(0.0, 0.5), (0.5, 1.0), (1.0, 2.0)]
    assert pieces[0].ages == (0,)
