"""A drive that is proposed keeps limits and floor, and tells what a poor log could not."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from benchmarks.own_plant import Drives, log_of, simulate
from tests.identification.conftest import KNOWN, STEP, TRUTH
from tests.papers_robot import paper
from wmr_ctrl.core.errors import ArgumentError
from wmr_ctrl.identification import identify
from wmr_ctrl.identification.propose import (
    DRAWS,
    ProposedDrive,
    _followed_drive,
    _path,
    _shapes,
    propose,
)

FLOOR = 3.0


def test_a_path_of_constant_speeds_is_the_arc_of_their_ratio():
    t, v, omega = np.arange(2000) * 1e-3, 0.4, 0.8

    path = _path(t, np.full(2000, v), np.full(2000, omega))

    turn = omega * (t + 1e-3)
    arc = v / omega * np.column_stack((np.cos(turn) - 1, np.sin(turn)))
    assert path[:, :2] == pytest.approx(arc, abs=1e-6)
    assert path[:, 2] == pytest.approx(omega * t, abs=1e-12)


def test_of_drives_that_fit_the_one_that_tells_most_is_proposed(monkeypatch):
    fitted = iter([(1.0, "little"), None, (3.0, "most"), (2.0, "some")])
    monkeypatch.setitem(propose.__globals__, "_shapes", lambda period: (None, [None] * 4))
    monkeypatch.setitem(propose.__globals__, "_fitted", lambda *_: next(fitted))
    clock = SimpleNamespace(control=0.01)

    assert propose(SimpleNamespace(scenario=SimpleNamespace(clock=clock))) == "most"


def test_drives_have_size_one_begin_and_end_at_rest_and_differ():
    t, kinds = _shapes(0.02)

    assert (t[0], t[-1]) == (0.0, pytest.approx(60.0 - 0.02))
    for drives in kinds:
        assert drives.shape == (DRAWS, len(t), 2)
        assert np.abs(drives).max(axis=1) == pytest.approx(1.0)
        assert np.abs(drives[:, [0, -1]]).max() == 0.0
        assert np.ptp(drives, axis=0).max() > 1.0


def test_a_followed_drive_comes_to_the_wanted_speeds_with_the_torques_of_friction():
    robot = {"m": 30.0, "I": 3.0, "Fc": 12.0, "Fv": 0.0, "c": 0.0, "Mv": 0.0}
    robot |= {"delay": 0.02, "lag": 0.02}
    scenario, wanted = paper(), np.tile([0.3, 0.5], (400, 1))

    motion, torque = _followed_drive(scenario, [robot], wanted)

    way, turn, v, omega, x, y = motion[0].T
    assert (v[-1], omega[-1]) == (pytest.approx(0.3, rel=0.02), pytest.approx(0.5, rel=0.02))
    assert torque[0, -1].sum() / scenario.robot.r == pytest.approx(12.0, rel=0.02)
    assert torque[0, 2, 0] > torque[0, 2, 1] > 0
    assert np.hypot(np.diff(x), np.diff(y)).sum() == pytest.approx(way[-1], rel=1e-3)
    assert turn[-1] > 0


def test_a_drive_as_text_has_its_numbers_and_what_the_corners_showed():
    t, v, omega = np.array([0.0, 0.1]), np.array([0.25, 0.5]), np.array([-0.5, 1.0])
    path = np.array([[0.0, 1.0, 2.0], [3.0, 4.0, 5.0]])

    text = ProposedDrive(t, v, omega, path, 1.25, (0.75, 1.5), 0.02, {}).to_csv()

    head, names, *rows = text.splitlines()
    assert "1.25 m from the start, 0.75 m/s, 1.5 rad/s, 2 % of the torques" in head
    assert names == "t [s],v [m/s],omega [rad/s],x [m],y [m],theta [rad]"
    assert rows == ["0,0.25,-0.5,0,1,2", "0.1,0.5,1,3,4,5"]


def driven_by(drive):
    """The own plant, which follows with a loop of its own."""
    wanted = np.column_stack((drive.v, drive.omega))
    return simulate(TRUTH, 1, len(wanted) * TRUTH.period, 7, Drives("given", wanted=wanted), STEP)


@pytest.fixture(scope="module")
def after_a_circle():
    """What the log of a circle tells, the drive that is proposed then, and the robot's on it."""
    circle = simulate(TRUTH, 1, 16.0, 3, Drives("circle"), STEP)
    poor = identify(log_of(circle, 0), overrides=KNOWN)
    drive = propose(poor, FLOOR)
    return poor, drive, driven_by(drive)


@pytest.mark.slow
def test_a_drive_keeps_limits_and_floor_and_rests_at_both_ends(after_a_circle):
    poor, drive, columns = after_a_circle
    limits = poor.scenario.limits.v_u1

    for speed, limit, fastest in zip((drive.v, drive.omega), limits, drive.fastest, strict=True):
        assert speed[0] == speed[-1] == 0
        assert np.abs(speed).max() <= limit
        assert fastest <= limit
    assert np.hypot(*drive.path[:, :2].T).max() <= drive.farthest <= FLOOR / 2
    assert drive.to_csv().splitlines()[1].startswith("t [s],v [m/s],omega [rad/s]")

    assert np.hypot(columns["x"], columns["y"]).max() <= FLOOR / 2
    assert np.abs(columns["v1"]).max() <= limits[0]
    assert np.abs(columns["omega"]).max() <= limits[1]


def test_a_floor_that_no_drive_fits_is_refused(found):
    with pytest.raises(ArgumentError, match="above 0"):
        propose(found, 0.0)


@pytest.mark.slow
def test_after_a_circle_the_proposed_drive_tells_what_the_circle_could_not(after_a_circle):
    """The loop that is meant: identify, propose, drive, identify.

    A circle tells no friction apart, and says so.
    """
    poor, _, columns = after_a_circle

    better = identify(log_of(columns, 0), overrides=KNOWN)

    for name in ("Fc", "Fv", "c"):
        assert poor.parameters[name].verdict == "undetermined"
    assert any("cannot be separated" in text for text in poor.remarks)
    for name in ("m", "I", "Fc", "c", "delay"):
        assert better.parameters[name].verdict == "determined", name
        assert better.parameters[name].share < poor.parameters[name].share / 2
