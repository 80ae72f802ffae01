"""A proposed drive keeps to the limits and the floor, and shows what a poor log does not."""

import numpy as np
import pytest

from benchmarks.own_plant import Drives, log_of, simulate
from tests.identification.conftest import KNOWN, STEP, TRUTH
from wmr_ctrl.core.errors import ArgumentError
from wmr_ctrl.identification import identify
from wmr_ctrl.identification.propose import DRAWS, ProposedDrive, _path, _shapes, propose

FLOOR = 3.0


def test_a_path_of_constant_speeds_is_the_arc_of_their_ratio():
    t, v, omega = np.arange(2000) * 1e-3, 0.4, 0.8

    path = _path(t, np.full(2000, v), np.full(2000, omega))

    turn = omega * (t + 1e-3)
    arc = v / omega * np.column_stack((np.cos(turn) - 1, np.sin(turn)))
    assert path[:, :2] == pytest.approx(arc, abs=1e-6)
    assert path[:, 2] == pytest.approx(omega * t, abs=1e-12)


def test_drives_are_no_larger_than_one_begin_and_end_at_rest_and_differ():
    t, drives = _shapes(0.02)

    assert (t[0], t[-1]) == (0.0, pytest.approx(60.0 - 0.02))
    assert drives.shape == (DRAWS, len(t), 2)
    assert 0.8 < np.abs(drives).max(axis=1).min() <= np.abs(drives).max() <= 1.0
    assert np.abs(drives[:, [0, -1]]).max() == 0.0
    assert np.ptp(drives, axis=0).max() > 1.0


def test_a_drive_as_text_has_its_numbers_and_what_it_reaches():
    t, v, omega = np.array([0.0, 0.1]), np.array([0.25, 0.5]), np.array([-0.5, 1.0])
    path = np.array([[0.0, 1.0, 2.0], [3.0, 4.0, 5.0]])

    text = ProposedDrive(t, v, omega, path, 1.25, (0.75, 1.5)).to_csv()

    head, names, *rows = text.splitlines()
    assert "1.25 m from the start, 0.75 m/s, 1.5 rad/s" in head
    assert names == "t [s],v [m/s],omega [rad/s],x [m],y [m],theta [rad]"
    assert rows == ["0,0.25,-0.5,0,1,2", "0.1,0.5,1,3,4,5"]


def test_a_floor_that_no_drive_fits_is_refused(found):
    with pytest.raises(ArgumentError, match="above 0"):
        propose(found, 0.0)


@pytest.mark.slow
def test_after_a_circle_the_proposed_drive_tells_what_the_circle_could_not():
    """The intended procedure: identify, propose, drive, identify.

    A circle does not determine the friction, and the result says so.
    """
    circle = simulate(TRUTH, 1, 16.0, 3, Drives("circle"), STEP)
    poor = identify(log_of(circle, 0), overrides=KNOWN)
    plan = propose(poor, FLOOR)
    wanted = np.column_stack((plan.v, plan.omega))
    given = Drives("given", wanted=wanted)
    columns = simulate(TRUTH, 1, len(wanted) * TRUTH.period, 7, given, STEP)

    better = identify(log_of(columns, 0), overrides=KNOWN)

    assert np.hypot(columns["x"], columns["y"]).max() <= FLOOR / 2
    for name, limit in zip(("v1", "omega"), poor.scenario.limits.v_u1, strict=True):
        assert np.abs(columns[name]).max() <= limit
    for name in ("Fc", "Fv", "c"):
        assert poor.parameters[name].verdict == "undetermined"
    assert any("cannot be separated" in text for text in poor.remarks)
    for name in ("m", "I", "Fc", "c", "delay"):
        assert better.parameters[name].verdict != "undetermined", name
        assert better.parameters[name].share < poor.parameters[name].share / 2
