"""Motions of a reference: chords, and remainders in parts, against numbers of the tests' own."""

import numpy as np
import pytest

from tests.papers_robot import safe
from wmr_ctrl.world.references import sample
from wmr_proofs.corridor.midradius import MidRadius
from wmr_proofs.corridor.motion import MovingCurve, _chord, _rounding, motion_of
from wmr_proofs.corridor.peaks import reference_gap


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


@pytest.mark.parametrize("steep", [lambda s: s**8, lambda s: float(s > 0.95), lambda s: 1.0])
def test_a_remainder_in_parts_is_not_below_the_integral_it_stands_for(steep):
    """The integrand is 2 (1 - s) times a curvature that grows with the box, over s from 0 to 1."""
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


def test_a_reference_is_aside_of_arcs_by_no_more_than_is_counted():
    """Each sample's motion is an arc of the test's own."""
    told = "reference.kind = lemniscate; clock = {control = 0.2, plant = 0.02, duration = 6.0}"
    motion, h = motion_of(safe(told, "reference.rate = 0.8; changes = []")), 0.02
    poses = sample(safe(told, "reference.rate = 0.8; changes = []"), np.arange(301) * h)[:, :3]
    begin, inner = poses[:-1:10], np.stack([poses[k:][:291:10] for k in range(1, 11)], axis=1)
    v, w = motion.way[1:].T
    t = h * np.arange(1, 11)
    after = begin[:, 2:] + w[:, None] * t
    ahead, theta = (v / w)[:, None], begin[:, 2:]
    x = begin[:, :1] + ahead * (np.cos(after) - np.cos(theta))
    y = begin[:, 1:2] + ahead * (np.sin(after) - np.sin(theta))
    off = np.hypot(x - inner[..., 0], y - inner[..., 1])
    for counted, found in ((motion.aside, off.max(axis=1)),
                           (motion.turned, np.abs(after - inner[..., 2]).max(axis=1)),
                           (motion.gap, off[:, -1])):  # fmt: skip
        assert (found <= counted + 1e-9).all()
        assert (counted <= found + 1e-8).all()
    assert (off.max(axis=1) > 10 * off[:, 0]).any()


def test_rounding_is_that_of_the_farthest_pose():
    poses = np.array([[0.0, 0.0, 0.0], [1e6, 0.0, 3.0], [1.0, 2.0, 0.0]])

    assert 10 * np.spacing(1e6) < _rounding(poses, 10) < 1e4 * np.spacing(1e6)
