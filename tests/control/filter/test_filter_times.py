"""Steps that are late, early, repeated, or before the last one, and each filter's response."""

import math

import numpy as np
import pytest

from tests.control.filter.test_filter import scenario as first_order
from tests.control.filter.test_peak_gain import scenario
from tests.tables import changes
from wmr_ctrl import command_filter, load_scenario
from wmr_ctrl.control.filter.band import NAMES, BandGovernor

T = 0.05
COUNT = 300
FREE = {"kind": "band", "push": (0.0, 0.0)}
UNTIMELY = (0.0, 0.02, 0.3, 0.9, 1.2, 1.7, 3.0, 8.0)
"""Times between steps, in periods."""


def sent_at(limit, since):
    """Return the commands v sent for a request of 9 m/s at each step, and which steps are late.

    ``since``: time [s] since the step before, for each step.
    """
    limit.start()
    made = [limit.step((9.0, 0.0), dt=time) for time in since]
    return np.array([m.command[0] for m in made]), np.array(["late" in m.flags for m in made])


@pytest.mark.slow
def test_steps_within_their_jitter_are_in_time_whenever_the_first_came():
    J, rng = T / 4, np.random.default_rng(1)
    limit = command_filter(scenario(**FREE, jitter=J))
    off = rng.uniform(-J, J, COUNT + 1)
    off[:6] = J, -J, 0.0, J, J, -J
    sent, late = sent_at(limit, T + np.diff(off))
    assert not late.any()
    assert sent[150:].min() > 0.99
    for way in (1, -1):  # drift: within any beat's jitter for so long, and no longer
        sent, late = sent_at(limit, np.full(200, T + way * 0.019 * J))
        assert np.flatnonzero(late)[0] == 2 * J // (0.019 * J)


@pytest.mark.slow
def test_what_a_band_keeps_for_the_soonest_sample_counts_two_that_are_off_towards_each_other():
    J = T / 4
    system = BandGovernor(scenario(**FREE, jitter=J)).system
    numbers = {item.signal.name: item.value[0] for item in system.params}
    for name in NAMES:
        stays = math.exp(-numbers[f"filter.rate_{name}"] * (T - 2 * J))
        assert numbers[f"filter.soonest_{name}"] == pytest.approx(stays, rel=1e-3)


def test_a_clip_takes_a_quarter_of_a_period_for_in_time():
    sent, late = sent_at(command_filter(first_order(kind="clip")), [T, 1.2 * T, 0.8 * T, 1.3 * T])
    assert (sent == sent[0]).all()
    assert late.tolist() == [False, False, False, True]


@pytest.mark.parametrize("at", [5, 10])
@pytest.mark.parametrize("caught_up", [False, True])
def test_a_late_step_brakes_nobody_who_wants_as_much(at, caught_up):
    limit = command_filter(scenario(**FREE))
    since = np.full(120, T)
    since[at] = 1.5 * T
    if caught_up:
        since[at + 1] = 0.5 * T
    sent, late = sent_at(limit, since)
    assert late.sum() == 1 + caught_up
    assert sent[at] >= sent[at - 1] > 0.7
    assert (np.diff(sent) >= 0).all()
    assert sent[-1] > 0.97


@pytest.mark.parametrize("share", [0.02, 0.9, 1.1, 3.0])
@pytest.mark.slow_but("0.9")
def test_a_stop_comes_however_wrong_the_period_is(share):
    limit = command_filter(scenario(**FREE))
    for _ in range(400):
        up = limit.step((9.0, 0.0), dt=share * T).command[0]
    sent, waited = up, 0.0
    while sent != 0 and waited < 10:
        made = limit.step((0.0, 0.0), dt=share * T)
        assert "late" in made.flags
        sent, waited = made.command[0], waited + share * T
    assert up > 0.3
    assert waited < 2.5


def test_after_untimely_steps_all_is_as_it_would_be():
    """The filter recovers after late steps: ``dt`` zero, negative, NaN, too short or too long."""
    limit = command_filter(scenario(**FREE))
    for _ in range(100):
        before = limit.step((9.0, 0.0)).command[0]
    for wrong in (0.0, -1.0, math.nan, -math.inf, 0.01, math.inf, 1e300):
        assert "late" in limit.step((9.0, 0.0), dt=wrong).flags
    for _ in range(100):
        made = limit.step((9.0, 0.0), dt=T)
    assert made.flags == ("limited",)
    assert made.command[0] > before
    assert limit.step((0.0, 0.0), dt=T).command[0] == 0.0


@pytest.mark.parametrize("wrong", [0.0, -0.05, 0.03, 0.2, math.nan, math.inf])
@pytest.mark.parametrize("kind", ["clip", "governor"])
def test_a_clip_acts_whenever_a_step_is_untimely(kind, wrong):
    limit = command_filter(first_order(kind))
    clip = pytest.approx((1 - 0.05) / 1.1, rel=1e-7)
    limit.step((0.3, 0.0), (0.0, 0.0), dt=T)
    made = limit.step((5.0, 0.0), (0.0, 0.0), dt=wrong)
    assert made.command[0] == clip
    assert made.flags == ("limited", "late")


def test_a_governor_forgets_what_it_made_of_commands_that_were_not_in_time():
    """One command forwards and an early step: the limit backwards, 0.02 m/s, holds afterwards."""
    own = changes("""
        filter.kind = governor; filter.tau = [0.2, 0.2]; filter.delay = [0.19, 0.19]
        limits.v_u1 = [0.5, 1]; limits.v_u2 = [0.3, 0.7]; limits.v_min = [-0.02, -1]
    """)
    step = command_filter(load_scenario("paper-simulation", own | {"clock.control": T})).step
    v, sent, slowest, late = 0.0, [0.0] * 190, [], False
    for k in range(50):
        since = 0.02 if k == 22 else T
        for _ in range(round(since / 1e-3)):
            v += (1 - math.exp(-1e-3 / 0.2)) * (sent[-190] - v)
            sent.append(sent[-1])
            slowest.append(0.0 if late else v)
        made = step((9.0 if k == 21 else -9.0, 0.0), dt=since)
        sent[-1], late = made.command[0], "late" in made.flags
    assert -0.02 <= min(slowest) < -0.0199


@pytest.mark.slow
def test_slow_commands_change_in_time_and_no_faster():
    stated = {"loop": "second-order", "frequency": (3.0, 5.0), "damping": (0.4, 1.4)}
    slow = command_filter(scenario(slew=(0.2, 0.2), push=(0.0, 0.0), **stated))
    rng, last = np.random.default_rng(7), 0.0
    for since in (
        *T * rng.choice([1.0, 1.0, 0.5, 0.8, 1.6, 3.0, 0.0, -0.5], 200),
        math.nan,
        -math.inf,
        math.inf,
    ):
        made = slow.step((rng.choice([-9.0, 9.0]), 0.0), dt=since)
        most = 0.2 * min(since, T) if since >= 0 else 0.0
        assert abs(made.command[0] - last) <= most * (1 + 1e-9)
        assert ("late" in made.flags) == (not abs(since - T) <= T / 4)
        last = made.command[0]
