"""Distances of a stop by formulas, against a base that is integrated."""

import math
from dataclasses import replace

import casadi as ca
import numpy as np
import pytest

from wmr_ctrl.control.filter.governor import FirstOrder, Schedule
from wmr_ctrl.control.filter.ways import (
    LARGEST,
    Reached,
    Stop,
    ToldBound,
    covered,
    farthest,
    told_command,
)

STOP = Stop((0.15, 0.3), 0.05, 1.0, 0.05, 0.15, 0.1)


def gone(v, pieces, tau, steps=20_000):
    """Distance and speed of a base that follows (target, time) one after the other, by Euler's
    rule.
    """
    way = 0.0
    for target, time in pieces:
        h = time / steps
        for _ in range(steps):
            way, v = way + h * v, v + h / tau * (target - v)
    return way, v


def test_what_a_fading_speed_covers():
    way, _ = gone(1.0, [(0.0, 0.4)], 0.3)
    assert float(covered(0.4, 0.3)) == pytest.approx(way, rel=1e-4)


def test_the_farthest_way_is_that_of_one_end():
    for v, target in ((0.2, 0.9), (0.9, 0.2)):
        ways = [gone(v, [(target, 0.25)], tau)[0] for tau in (0.15, 0.2, 0.3)]
        told = farthest(v, target, 0.25, *(covered(0.25, tau) for tau in STOP.tau))
        assert float(told) == pytest.approx(max(ways), rel=1e-4)


@pytest.mark.parametrize("instant", [0.1, 0.15])
@pytest.mark.parametrize("w, at", [(0.3, 0.1), (0.05, 0.0), (0.8, 0.2)])
def test_the_largest_steady_speed_stops_the_worst_base_within_the_free_distance(w, at, instant):
    """The worst base stops exactly at the end of the free distance.

    Obstacles approach until it stands.
    """
    free = 0.9
    m = float(STOP.steady(free, [Reached(instant, at, w)]))
    acts, needs = STOP.acts + STOP.last - instant, []
    for tau in STOP.tau:
        way, v = gone(w, [(m, acts)], tau)
        rest, _ = gone(v - STOP.push, [(0.0, STOP.rest)], STOP.tau[1])
        needs.append(at + way + rest + STOP.push * STOP.rest + STOP.nearing * STOP.time)
    assert max(needs) == pytest.approx(free, rel=1e-4)


def test_a_release_rolls_as_far_as_the_quickest_base():
    way, _ = gone(0.0, [(STOP.push, STOP.rest)], STOP.tau[0])
    assert STOP.roll == pytest.approx(way, rel=1e-4)
    assert Stop((0.1, 0.2), 0.0, None, 0.1, 0.1, 0.0).roll == 0


def test_after_the_hold_a_release_ends_where_it_began():
    pull = 0.3
    for tau in STOP.tau:
        way, v = gone(0.0, [(-pull, float(STOP.hold(pull)))], tau)
        back, _ = gone(v, [(STOP.push, STOP.rest)], tau)
        assert way + back <= 1e-5


def test_a_retreat_needs_what_it_rolls_afterwards():
    own = Stop((0.15, 0.3), 0.05, 1.0, 0.05, 0.15, 0.0)
    way, _ = gone(-0.1, [(0.05, 1.0)], 0.15)
    assert float(own.retreat(0.02, -0.2, -0.1)) == pytest.approx(0.02 + max(0.0, way), abs=1e-6)


def bounds(**numbers):
    """Numbers of an axis, as symbols that are constants."""
    known = {"V": 1.0, "dbar": 0.05, "nbar": 0.0, "K_min": 0.9, "K_max": 1.1, "kappa": 0.5}
    return FirstOrder(**{name: ca.SX(value) for name, value in (known | numbers).items()})


def test_a_lowered_limit_lets_pass_what_lands_on_it_after_the_least_time():
    slowest = 1 / math.expm1(0.04 / 0.3)
    u = float(told_command(0.5, 0.55, bounds(), slowest))
    end = 1.1 * u + 0.05 + (0.55 - 1.1 * u - 0.05) * math.exp(-0.04 / 0.3)
    assert end == pytest.approx(0.5)
    assert float(told_command(0.5, 0.9, bounds(), slowest)) == 0
    assert float(told_command(0.05, 0.0, bounds(), slowest)) == 0
    assert float(told_command(0.5, 0.4, bounds(), slowest)) == pytest.approx(0.5 / 1.1)


def told_bound(still, most=(1.0, 1.0, 1.0)):
    """A bound of the speed with two commands that may act."""
    told = {"most": list(map(ca.SX, most)), "still": list(map(ca.SX, still))}
    tau = ca.SX(0.15), ca.SX(0.3)
    return ToldBound(Schedule((0.0, 0.5)), bounds(), tau, ca.SX(0.1), punctual=ca.SX(1), **told)


def test_a_brake_lifts_a_bound_below_zero_and_the_most_of_what_acts_cuts_it():
    piece = Schedule((0.0, 0.5)).pieces(0.0, 0.5, 1)[0]
    shares, targets = (ca.SX(0.2), ca.SX(0.1)), [ca.SX(0.0), ca.SX(-1.0), ca.SX(-1.0)]
    moving, braked = told_bound([0, 0, 0]), told_bound([0, 1, 0])
    assert float(ca.evalf(moving.carried(ca.SX(-0.5), piece, targets, shares))) < -0.5
    assert float(ca.evalf(braked.carried(ca.SX(-0.5), piece, targets, shares))) == 0
    cut = told_bound([0, 0, 0], (1.0, 0.3, 0.2))
    assert float(ca.evalf(cut.carried(ca.SX(0.9), piece, [ca.SX(1.0)] * 3, shares))) <= 0.3
    assert float(ca.evalf(cut.present(ca.SX(0.9)))) == 0.3


@pytest.mark.parametrize("hold, push", [(1.0, 0.05), (2.0, -LARGEST)])
def test_a_base_stops_on_its_own_between_punctual_commands_only_if_it_holds_briefly(hold, push):
    told = replace(told_bound([0, 0, 0]), schedule=Schedule((0.0, 0.5), hold=hold))
    assert float(ca.evalf(told.stopped[0])) == push


def test_the_way_until_the_next_sample_counts_no_motion_backwards():
    bound = told_bound([0, 0, 0])
    ways = [
        float(ca.evalf(bound.until_next(ca.SX(v), [ca.SX(0.5), ca.SX(-1.0), ca.SX(-1.0)])))
        for v in (-0.5, 0.0, 0.4)
    ]
    assert ways[0] == ways[1] < ways[2]
    ends = bound.takeovers(ca.SX(0.4), [ca.SX(0.0), ca.SX(0.4), ca.SX(0.4)])
    told = np.array(
        [[float(ca.evalf(part)) for part in (at.instant, at.way, at.speed)] for at in ends]
    )
    assert told[0] == pytest.approx([0.0, 0.0, 0.4])
    assert told[-1] == pytest.approx([0.05, 0.02, 0.4])
