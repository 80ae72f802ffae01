"""Limit cycles, distinguished from a start, from noise and from a reference's own swing."""

import numpy as np
import pytest

from tests.results.conftest import build
from wmr_ctrl.results.oscillation import KEPT, fast_swing_rms, oscillation
from wmr_ctrl.results.remarks import remarks_on


@pytest.mark.parametrize("count", [100, 101])
def test_fast_swing_excludes_the_power_of_slow_parts(count):
    """By Parseval: half of a sine's square, and all of a part that alternates between samples."""
    k, period = np.arange(count), 0.01
    whole = 2 * np.pi * k / count
    slow, fast = 5.0 + 0 * whole, 0.3 * np.sin(20 * whole)
    other = 0.4 * np.cos(np.pi * k) if count % 2 == 0 else 0.4 * np.cos(50 * whole)
    power = 0.3**2 / 2 + (0.4**2 if count % 2 == 0 else 0.4**2 / 2)

    both = np.column_stack((slow + fast + other, slow))

    assert fast_swing_rms(both, period) == pytest.approx(np.sqrt(power / 2))


@pytest.mark.parametrize("size, told", [(4e-4, False), (4e-3, True)])
def test_a_swing_of_a_thousandth_of_a_newton_metre_is_none(size, told):
    swing = size * np.sin(np.arange(200) * 2 * np.pi / 10)

    assert (oscillation(build(duration=2.0, tau_right=swing)) is not None) is told


def test_a_remark_counts_the_samples_of_a_period():
    swing = np.sin(np.arange(200) * 2 * np.pi / 10)
    said = " ".join(one.text for one in remarks_on(build(duration=2.0, tau_right=swing)))

    assert "at 10 Hz, 10 samples a period" in said


@pytest.mark.parametrize("periods, told", [(40, True), (10, False)])
def test_with_few_periods_a_line_needs_more_of_the_power(periods, told):
    """Two waves in the last 8 s, the slower with a little more than half of the power."""
    t = 0.01 * np.arange(1600)
    waves = 1.05 * np.sin(2 * np.pi * periods / 8 * t) + np.sin(2 * np.pi * 200 / 8 * t)

    assert (oscillation(build(duration=16.0, tau_right=waves, tau_left=waves)) is not None) is told


@pytest.mark.parametrize("frequency, swing, told", [
    (0.2, 0.6, True), (0.2, 0.3, False), (0.05, 0.6, False), (2.0, 0.6, True),
])  # fmt: skip
def test_a_cycling_velocity_is_found_by_its_swing(frequency, swing, told):
    """Peak to peak about the desired velocity, for a limit of 1.5 rad/s and a window of 40 s."""
    t = 0.01 * np.arange(8000)
    run = build(duration=80.0, omega=swing / 2 * np.sin(2 * np.pi * frequency * t))
    found = oscillation(run)

    assert (found is not None) is told
    if found is not None:
        assert (found.quantity, found.unit) == ("omega", "rad/s")
        assert found.frequency == pytest.approx(frequency, rel=0.05)


@pytest.mark.parametrize("share, told", [(KEPT - 0.1, False), (KEPT + 0.1, True)])
def test_a_swing_that_falls_below_its_share_in_a_quarter_decays(share, told):
    """A wave of 5 Hz whose amplitude in the last quarter is that share of the one before."""
    t = 0.01 * np.arange(1600)
    wave = np.sin(10 * np.pi * t) * np.where(t < 14.0, 1.0, share)

    assert (KEPT, oscillation(build(duration=16.0, tau_right=wave)) is not None) == (2 / 3, told)


@pytest.mark.parametrize("periods, rms", [(1, 0.0), (3, 0.0), (5, 1 / np.sqrt(2))])
def test_fewer_than_four_periods_are_a_transient(periods, rms):
    """A window of half a second, for any frequency."""
    signal = np.sin(2 * np.pi * periods * np.arange(50) / 50)[:, None]

    assert fast_swing_rms(signal, 0.01) == pytest.approx(rms, abs=1e-9)


@pytest.mark.parametrize("decay, periods, told", [
    (0.0, 40, True), (0.0, 5, True), (0.0, 2.5, False), (0.5, 40, False), (-0.3, 40, True),
    (0.12, 40, False), (0.05, 40, True),
])  # fmt: skip
def test_a_cycle_has_periods_and_does_not_decay(decay, periods, told):
    """exp(-decay t) sin(2 pi f t), the given number of periods in the last half of 16 s."""
    t = 0.01 * np.arange(1600)
    wave = np.exp(-decay * t) * np.sin(2 * np.pi * periods / 8 * t)
    found = oscillation(build(duration=16.0, tau_right=wave, tau_left=wave))

    assert (found is not None) is told
    assert not told or found.frequency == pytest.approx(periods / 8, abs=0.05)


def test_a_swing_is_no_larger_than_the_wheels_allow():
    """A square wave between the torque limits has a spectral line larger than the wave."""
    square = np.where(np.arange(1600) % 40 < 20, 6.0, -6.0)
    found = oscillation(build(duration=16.0, tau_right=square, tau_left=square))

    assert found.swing == pytest.approx(12.0)
    wave = np.sin(10 * np.pi * 0.01 * np.arange(800))
    found = oscillation(build(duration=8.0, tau_right=1 + wave, tau_left=1 + wave))
    assert found.swing == pytest.approx(2.0, rel=0.02)
