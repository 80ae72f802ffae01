"""Motions of a reference: chords, laps, and remainders in parts, with numbers of the tests' own."""

import numpy as np
import pytest

from wmr_proofs.corridor.midradius import MidRadius
from wmr_proofs.corridor.motion import Laps, MovingCurve, RunMotion, _chord, laps_of
from wmr_proofs.corridor.peaks import reference_gap

LAP, COUNT = 10, 34


def motion(moved=None):
    """Three laps and a part; the robot is heavier from a sample on."""
    phase = np.arange(COUNT) % LAP / 10.0
    robot = np.ones((COUNT, 2, 3))
    if moved is not None:
        robot[moved:, :, 0] = 2.0
    pair, far = np.stack((phase, 1 - phase), axis=1), np.zeros(COUNT)
    way = np.vstack([pair[-1:] * 0 + pair[LAP - 1], pair])
    return RunMotion(pair, pair, way, far.copy(), far.copy(), far.copy(), far.copy(), robot)


@pytest.mark.parametrize("v, turn", [(0.3, 2.0), (-0.2, 2.0), (0.4, 0.0), (0.3, -15.0)])
def test_the_velocity_along_an_arc_is_that_at_which_it_is_driven(v, turn):
    period, theta = 0.1, np.array([0.3, -2.0])
    after = theta + turn * period
    if turn:  # forward is (-sin theta, cos theta)
        step = v / turn * np.stack((np.cos(after) - np.cos(theta), np.sin(after) - np.sin(theta)))
    else:
        step = v * period * np.stack((-np.sin(theta), np.cos(theta)))
    start = np.array([[1.0, 2.0, theta[0]], [3.0, -1.0, theta[1]]])
    end = np.column_stack((start[:, :2] + step.T, after))

    assert _chord(start, end, np.full(2, turn), period) == pytest.approx([v, v], rel=1e-9)


@pytest.mark.parametrize("step", [0.02, 0.2])
def test_an_arc_is_off_its_sum_by_simpsons_rule_by_no_more_than_is_counted(step):
    v, w = 0.7, 2.5
    angles = w * np.array([0.0, step / 2, step])
    summed = step / 6 * v * np.array([1, 4, 1]) @ np.stack((-np.sin(angles), np.cos(angles)), 1)
    exact = v / w * np.array([np.cos(angles[2]) - 1, np.sin(angles[2])])
    off = np.hypot(*(summed - exact))

    assert off <= reference_gap(np.array([-v, w]), step) <= 4 * off
    assert off > 1e-14


def test_laps_reach_to_the_end_or_to_where_the_robot_changes():
    """The sample of a change is a lap by itself; what holds before is none of what comes after."""
    laps, _ = laps_of(motion(), LAP)
    changed, _ = laps_of(motion(23), LAP)

    assert laps.end.tolist() == [COUNT] * COUNT
    assert changed.end.tolist() == [23] * 23 + [24] + [COUNT] * (COUNT - 24)
    assert not laps.spread.any()
    assert laps_of(motion(), 0)[0].end.tolist() == [0] * COUNT


def test_later_laps_count_with_their_largest_difference_and_their_largest_distances():
    """Whichever of them it is; beyond what rounding explains they are no laps."""
    one = motion()
    one.v_d[LAP + 3, 0] += 3e-11
    one.v_d[2 * LAP + 3, 0] += 1e-11
    one.gap[LAP + 5], one.aside[2 * LAP + 5], one.reckoned[5] = 3e-6, 2e-6, 1e-6
    laps, widened = laps_of(one, LAP)

    assert laps.spread[3] == pytest.approx(3e-11, rel=1e-3)
    assert laps.spread[LAP + 3] == pytest.approx(3e-11, rel=1e-3)  # a lap later still it is as ever
    assert [widened.gap[5], widened.aside[5], widened.reckoned[5]] == [3e-6, 2e-6, 1e-6]
    assert [widened.gap[LAP + 5], widened.aside[LAP + 5]] == [3e-6, 2e-6]
    one.v_d[2 * LAP + 3, 0] += 1e-6
    laps, _ = laps_of(one, LAP)
    assert laps.end[[3, LAP + 3]].tolist() == [0, 0]
    assert laps.end[4] == COUNT


@pytest.mark.parametrize("last, stands", [(21, True), (20, False)])
def test_a_lap_stands_for_others_where_each_of_its_samples_comes_again(last, stands):
    end = np.full(COUNT, COUNT)
    end[14] = last

    assert Laps(LAP, end, np.zeros(COUNT)).are_from(10) is stands
    assert Laps(LAP, end, np.zeros(COUNT)).are_from(15)
    assert not Laps(0, end, np.zeros(COUNT)).are_from(15)


@pytest.mark.parametrize("steep", [lambda s: s**8, lambda s: float(s > 0.95), lambda s: 1.0])
def test_a_remainder_in_parts_is_not_below_the_integral_it_stands_for(steep):
    """2 (1 - s) times a bend that grows with the box, over s from 0 to 1."""
    curve = MovingCurve.__new__(MovingCurve)
    curve.bends, curve._rows = np.array([[0, 0, 0]]), np.eye(1)
    curve.steep, curve.little = slice(0, 1), 0.0
    curve.bend = lambda box, numbers: np.array([steep(min(1.0, float(box.radius[0]) / 2.0))])
    point, s = MidRadius(np.zeros(1), np.zeros(1)), (np.arange(4000) + 0.5) / 4000
    least = 2 * np.mean((1 - s) * [steep(x) for x in s])
    coarse = (1 - 0.5**2) * steep(0.5) + 0.25 * steep(1.0)
    for fine in (False, True):
        found = curve.bend_within(point, np.array([2.0]), point, fine=fine)[0]

        assert least * (1 - 1e-3) <= found <= coarse * (1 + 1e-9)
