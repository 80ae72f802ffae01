"""Encoders: counts against a twin, and the time between counts."""

import math

import numpy as np
import pytest

from tests.papers_robot import paper
from tests.world import twins
from tests.world.motion import EFFECTS, WHEELED, assert_is_twin, fed, rows, scenario
from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.world.encoder import ENCODER
from wmr_ctrl.world.scenario import override

PLAIN = {"r": 0.1, "l": 0.25, "radius": (0.0, 0.0), "track": 0.0}


@pytest.mark.parametrize(
    "changes, twin",
    [
        ({}, {**PLAIN, "periods": 1}),
        ({"encoder.window": 0.04, **EFFECTS["wheels"]}, {**WHEELED, "periods": 4}),
    ],
)
def test_counts_are_the_twins(changes, twin):
    counting = twins.EncoderTwin({**twin, "counts": 512, "T": 0.01})

    assert_is_twin(ENCODER, {"encoder.counts": 512, **changes}, counting)


def test_less_than_one_count_is_nearest_to_one():
    with pytest.raises(ScenarioError, match=r"The nearest is 1\."):
        override(paper(), {"encoder.counts": 0.4})


def by_time(way, turn, counts=1024):
    """(v1, omega) shown by the time between counts, while way [m] and angle [rad] grow so."""
    motion = rows(len(way), np.random.default_rng(1))
    for row, path, theta in zip(motion, way.tolist(), turn.tolist(), strict=True):
        row |= {"path": [path], "theta": [theta], "skid": [0.0]}
    changes = {"encoder.counts": counts, "encoder.method": "time"}
    return fed(ENCODER.build(scenario(changes)), motion)


def test_the_time_between_counts_shows_a_steady_speed_to_rounding():
    """Forwards, backwards, and so slow that a count takes many samples."""
    for speed in (0.5, -0.3, 0.004):
        shown = by_time(0.01 * speed * np.arange(400), np.zeros(400))

        assert np.abs(shown[-100:, 0] - speed).max() < 1e-9 * abs(speed)
        assert np.abs(shown[:, 0]).max() <= abs(speed) * (1 + 1e-9)
        assert not shown[:, 1].any()


def test_the_time_between_counts_forgets_a_speed_when_the_robot_stops():
    shown = by_time(0.005 * np.minimum(np.arange(300), 100), np.zeros(300))[:, 0]
    count = 2 * math.pi * 0.1 / 1024

    assert shown[99] == pytest.approx(0.5)
    assert (np.diff(shown[102:]) < 0).all()
    assert shown[-1] < count / 1.9
