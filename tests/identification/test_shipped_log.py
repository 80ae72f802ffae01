"""The tutorial's log equals its script's output, is small, and gives the numbers of its page."""

import numpy as np
import pytest

from benchmarks import robot_log
from tests.docs.pages import DOCS

LOG = DOCS / "robot-log.csv"


@pytest.mark.slow
def test_its_script_writes_it(tmp_path):
    """To one count and some hundredths of a newton metre, since platforms differ in the last
    digits.
    """
    robot_log.write(str(tmp_path / "log.csv"), robot_log.columns_of(None, robot_log.SEED))

    files = LOG, tmp_path / "log.csv"
    shipped, again = (np.loadtxt(path, delimiter=",", skiprows=1) for path in files)

    assert LOG.read_text().splitlines()[0] == files[1].read_text().splitlines()[0]
    off = np.abs(shipped - again)
    assert off[:, 0].max() == 0
    assert off[:, 1:3].max() <= 1
    assert off[:, 3:].mean() < 0.01


def test_a_drive_that_is_given_is_held_between_its_rows(tmp_path):
    (tmp_path / "drive.csv").write_text("t [s],v [m/s],omega [rad/s]\n1,0.3,0\n1.05,0.2,-1\n")

    wanted = robot_log.drive_of(str(tmp_path / "drive.csv")).wanted

    assert wanted.tolist() == [[0.3, 0.0]] * 3 + [[0.2, -1.0]]
    assert LOG.stat().st_size < 1_000_000
