"""A drive that is proposed keeps limits and floor, and tells what a poor log could not."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.own_plant import Drives, log_of, simulate
from tests.identification.conftest import KNOWN, TRUTH
from wmr_ctrl.errors import ArgumentError
from wmr_ctrl.identification import identify
from wmr_ctrl.identification.propose import propose

FLOOR = 3.0


def driven_by(drive):
    """The own plant, which follows with a loop of its own."""
    wanted = np.column_stack((drive.v, drive.omega))
    return simulate(TRUTH, 1, len(wanted) * TRUTH.period, 7, Drives("given", wanted=wanted), 2e-3)


@pytest.mark.slow
def test_a_drive_keeps_limits_and_floor_and_rests_at_both_ends(found):
    drive = propose(found, FLOOR)
    limits = found.scenario.limits.v_u1

    for speed, limit, fastest in zip((drive.v, drive.omega), limits, drive.fastest, strict=True):
        assert speed[0] == speed[-1] == 0
        assert np.abs(speed).max() <= limit
        assert fastest <= limit
    assert np.hypot(*drive.path[:, :2].T).max() <= drive.farthest <= FLOOR / 2
    assert drive.to_csv().splitlines()[1].startswith("t [s],v [m/s],omega [rad/s]")

    columns = driven_by(drive)
    assert np.hypot(columns["x"], columns["y"]).max() <= FLOOR / 2
    assert np.abs(columns["v1"]).max() <= limits[0]
    assert np.abs(columns["omega"]).max() <= limits[1]


def test_a_floor_that_no_drive_fits_is_refused(found):
    with pytest.raises(ArgumentError, match="above 0"):
        propose(found, 0.0)


@pytest.mark.slow
def test_after_a_circle_the_proposed_drive_tells_what_the_circle_could_not():
    """The loop that is meant: identify, propose, drive, identify."""
    circle = simulate(TRUTH, 1, 16.0, 3, Drives("circle"), step=2e-3)
    poor = identify(log_of(circle, 0), overrides=KNOWN)
    drive = propose(poor, FLOOR)

    better = identify(log_of(driven_by(drive), 0), overrides=KNOWN)

    for name in ("Fc", "Fv", "c"):
        assert poor.parameters[name].verdict == "undetermined"
    for name in ("m", "I", "Fc", "c", "delay"):
        assert better.parameters[name].verdict == "determined", name
        assert better.parameters[name].share < poor.parameters[name].share / 2
