"""Encoders: counts over a window, and the time between counts."""

import math

import numpy as np
import pytest

from tests.papers_robot import paper
from tests.world.motion import EFFECTS, fed_to, motion
from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.world.encoder import ENCODER
from wmr_ctrl.world.scenario import override

SIZED = {"encoder.window": 0.04, **EFFECTS["wheels"]}


@pytest.mark.parametrize(
    "changes, radius, track, periods", [({}, (0.0, 0.0), 0.0, 1), (SIZED, (0.02, -0.01), 0.02, 4)]
)
def test_counts_of_the_true_wheels_are_differenced_over_the_window(changes, radius, track, periods):
    columns = motion()
    turn = 0.25 * (1 + track) * columns["theta"]
    ways = np.column_stack((columns["path"] + turn, columns["path"] - turn))
    counts = np.floor(512 * ways / (2 * math.pi * 0.1 * (1 + np.array(radius))))
    old = counts[np.maximum(np.arange(400) - periods, 0)]
    right, left = 2 * math.pi * 0.1 * (counts - old).T / 512 / (periods * 0.01)
    wanted = np.column_stack(((right + left) / 2, (right - left) / 0.5))

    found = fed_to(ENCODER, {"encoder.counts": 512, **changes}, columns)

    assert found == pytest.approx(wanted, abs=1e-12)


def test_less_than_one_count_is_nearest_to_one():
    with pytest.raises(ScenarioError, match=r"The nearest is 1\."):
        override(paper(), {"encoder.counts": 0.4})


def by_time(way):
    """(v1, omega) from the time between counts, for a growing path length (N,) [m]."""
    columns = motion(len(way)) | {"path": way, "theta": 0 * way}
    return fed_to(ENCODER, {"encoder.counts": 1024, "encoder.method": "time"}, columns)


def test_the_time_between_counts_shows_a_steady_speed_to_rounding():
    """Forwards, backwards, and so slowly that a count takes many samples."""
    for speed in (0.5, -0.3, 0.004):
        shown = by_time(0.01 * speed * np.arange(400))

        assert np.abs(shown[-100:, 0] - speed).max() < 1e-9 * abs(speed)
        assert np.abs(shown[:, 0]).max() <= abs(speed) * (1 + 1e-9)
        assert not shown[:, 1].any()


def test_the_time_between_counts_forgets_a_speed_when_the_robot_stops():
    shown = by_time(0.005 * np.minimum(np.arange(300), 100))[:, 0]

    assert shown[99] == pytest.approx(0.5)
    assert (np.diff(shown[102:]) < 0).all()
    assert shown[-1] < 2 * math.pi * 0.1 / 1024 / 1.9
