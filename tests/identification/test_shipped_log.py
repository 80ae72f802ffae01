"""The tutorial's log is what its script writes, is small, and tells what its page says."""

import numpy as np
import pytest

from benchmarks import robot_log
from tests.docs.pages import DOCS

LOG = DOCS / "robot-log.csv"


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


def test_a_drive_that_is_given_is_held_between_its_rows(tmp_path):
    (tmp_path / "drive.csv").write_text("t [s],v [m/s],omega [rad/s]\n1,0.3,0\n1.05,0.2,-1\n")

    wanted = robot_log.drive_of(str(tmp_path / "drive.csv")).wanted

    assert wanted.tolist() == [[0.3, 0.0]] * 3 + [[0.2, -1.0]]
    assert LOG.stat().st_size < 1_000_000
