"""The tutorial's log is what its script writes, is small, and tells what its page says."""

import numpy as np
import pytest

from benchmarks import robot_log
from tests.docs.pages import DOCS

LOG = DOCS / "robot-log.csv"


def test_it_is_small():
    assert LOG.stat().st_size < 1_000_000


@pytest.mark.slow
def test_its_script_writes_it(tmp_path):
    """To a count and some hundredths of a newton metre: platforms differ in the last digits."""
    robot_log.write(str(tmp_path / "log.csv"), robot_log.columns_of(None, robot_log.SEED))

    shipped, again = (
        np.loadtxt(path, delimiter=",", skiprows=1) for path in (LOG, tmp_path / "log.csv")
    )

    assert LOG.read_text().splitlines()[0] == (tmp_path / "log.csv").read_text().splitlines()[0]
    assert np.array_equal(shipped[:, 0], again[:, 0])
    assert np.abs(shipped[:, 1:3] - again[:, 1:3]).max() <= 1
    assert np.abs(shipped[:, 3:] - again[:, 3:]).mean() < 0.01


@pytest.mark.slow
def test_a_drive_that_is_given_is_driven(tmp_path):
    """Held between rows of another rate; the robot turns left and right as it is told to."""
    t = np.arange(0, 12, 0.05)
    v, omega = 0.3 * np.sin(0.6 * t), 1.0 * np.sin(0.9 * t)
    rows = [f"{a},{b},{c}" for a, b, c in zip(t, v, omega, strict=True)]
    (tmp_path / "drive.csv").write_text("t [s],v [m/s],omega [rad/s]\n" + "\n".join(rows) + "\n")

    drive = robot_log.drive_of(str(tmp_path / "drive.csv"))
    columns = robot_log.columns_of(drive, 1)

    assert drive.wanted[100] == pytest.approx((v[40], omega[40]))
    right, left = (np.array(columns[f"wheel_counts[{k}] [1]"]) for k in (1, 2))
    turning = np.gradient(right - left)
    assert np.corrcoef(turning, drive.wanted[:, 1])[0, 1] > 0.7
