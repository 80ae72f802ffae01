"""Odometry with jitter, drift, bursts and gaps: each message one law step, at the law's period."""

import numpy as np
import pytest

from tests.ros2.test_drive_core import CIRCLE, TICK, World, core_of
from wmr_ctrl.ros2.drive_core import BETWEEN, DOUBLED, MISSED, NO_ODOMETRY
from wmr_ctrl.ros2.intake import BURST, FOLLOWED, Pace

COUNT = 1500


def sampled(stamps):
    """Stamps that are samples, of a law whose period is TICK."""
    pace = Pace(TICK)
    return [stamp for stamp in np.round(stamps).astype(np.int64).tolist() if pace.due(stamp)]


def grid(rate=1.0, count=COUNT):
    """Stamps of a sender ``rate`` times as fast as the law."""
    return np.arange(count) * TICK / rate


def late(seed, largest, count=COUNT):
    """Lateness of a busy machine: mostly small, sometimes up to ``largest`` periods."""
    draws = np.random.default_rng(seed).exponential(0.15 * largest, count)
    return TICK * np.minimum(draws, largest)


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("rate", [0.5, 0.9, 0.997, 1.0, 1.003, 1.04])
def test_each_message_is_a_sample_at_about_the_laws_rate(seed, rate):
    """Stamps have the jitter of a busy machine if the rates are nearly equal."""
    stamps, draw = grid(rate), np.random.default_rng(seed)
    for jitter in (TICK * draw.uniform(-0.25, 0.25, COUNT), late(seed, 0.8)):
        held_against_nobody = np.concatenate((jitter[:1], np.zeros(COUNT - 1)))
        near = abs(rate - 1) < 0.01
        assert len(sampled(stamps + (jitter if near else held_against_nobody))) == COUNT


@pytest.mark.parametrize("rate", [1.0, 1.003, 1.06, 1.5, 2.0, 2.7, 4.0, 5.0, 10.0])
@pytest.mark.parametrize("share", [0.0, 0.2, 0.45])
def test_the_laws_mean_period_is_the_one_it_was_made_for(rate, share):
    """Any sender may have jitter of a share of its spacing; short intervals are rare."""
    jitter = np.random.default_rng(3).uniform(-share, share, 9000) * TICK / rate
    found = np.diff(sampled(grid(rate, 9000) + jitter)) / TICK

    assert np.mean(found) == pytest.approx(1.0, abs=FOLLOWED / 2)
    assert np.min(found) >= BURST
    if rate >= 2 and share <= 0.2:
        assert np.ptp(found[3:]) <= 2.5 / rate  # a sender must be known first
        assert np.mean(found) == pytest.approx(1.0, abs=0.01)


def test_a_burst_is_one_sample_and_a_gap_is_not_made_up_for():
    """A sender at four times the rate pauses for five periods, then sends all messages together."""
    stamps = grid(4.0, 400)
    stood = (stamps > 50 * TICK) & (stamps < 55 * TICK)
    stamps[stood] = 55 * TICK - np.arange(stood.sum(), 0, -1) * 1000
    found = np.array(sampled(stamps)) / TICK

    after = found[found > 54.9]
    assert after[1] - after[0] >= 0.7
    assert len(after) == pytest.approx(100 - 55, abs=1)


# -- in the drive's decisions ------------------------------------------------------------------


@pytest.fixture(scope="module")
def built():
    return core_of(CIRCLE)


@pytest.fixture
def world(built):
    built.counts.clear()
    return World(built)


def answered(world, intervals, delays=None):
    """Number of messages that were answered; each comes ``delays`` [ns] after its stamp."""
    count = 0
    for k, interval in enumerate(intervals):
        world.pass_by(int(interval))
        stamp, late = world.ros, 0 if delays is None else int(delays[k])
        world.wait(late)
        reason, gated = world.message(stamp=stamp)
        world.wait(-late)
        assert reason == ""
        count += gated is not None
    return count


@pytest.mark.parametrize("rate", [0.997, 1.0, 1.003])
def test_a_drive_answers_each_message_and_stays_on_time(world, rate):
    """Stamps have jitter, and so, independently, do the transport times."""
    stamps = np.round(grid(rate) + late(1, 0.8)).astype(np.int64)
    start = world.ros

    assert answered(world, np.diff(stamps), late(2, 0.1)) == COUNT - 1
    counts, core = world.core.counts, world.core
    assert counts.get(BETWEEN, 0) == counts.get(NO_ODOMETRY, 0) == 0
    assert core._sample * TICK == pytest.approx(world.ros - start - TICK, abs=1.1 * TICK)
    steps = counts.get(MISSED, 0) - counts.get(DOUBLED, 0) + COUNT - 1
    assert core._sample + 1 == steps  # what was left out or doubled is counted, to one
    assert max(map(abs, core.e)) < 0.02


def test_what_comes_between_is_counted(world):
    assert answered(world, np.diff(grid(4.0, 401))) == pytest.approx(100, abs=1)
    assert world.core.counts[BETWEEN] == pytest.approx(300, abs=1)
