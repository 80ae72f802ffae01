"""Steps that come late, early, twice, or before the last one: what each filter makes of them."""

import math

import numpy as np
import pytest

from tests.control.filter.test_band import CORNERS, SWINGING, second_order_base
from tests.control.filter.test_filter import scenario as first_order
from tests.control.filter.test_peak_gain import scenario
from wmr_ctrl import command_filter
from wmr_ctrl.control.filter.band import NAMES, BandGovernor

T = 0.05
FAMILIES = {
    "pi": ({"push": (0.0, 0.0)}, CORNERS[::3]),
    "second-order": (
        {"loop": "second-order", "frequency": (3.0, 5.0), "damping": (0.4, 1.4), "gain": (0.8, 1.1),
         "push": (0.0, 0.0)},
        [second_order_base(*numbers) for numbers in SWINGING[1::2]],
    ),
}  # fmt: skip
UNTIMELY = (0.0, 0.02, 0.3, 0.9, 1.2, 1.7, 3.0, 8.0)
"""Periods from one step to the next, besides 1."""
COUNT, LONG = 300, 60


def half_period(base):
    """Half the base's own period, in samples; 10 where it does not swing."""
    swing = abs(np.linalg.eigvals(base.A).imag).max()
    return round(math.pi / swing / T) if swing > 0.3 else 10


def standing_still(base):
    """Commands that swing with the base, while the filter is called again and again at once."""
    k = np.arange(COUNT)
    return 9.0 * (-1.0) ** (k // LONG), T * np.where(k % LONG >= LONG - half_period(base), 1.0, 0.0)


def at_random(base, rng):
    """Swings and chance; times some of which are untimely, now and then many in a row."""
    k, part = np.arange(COUNT), COUNT // 20
    swings = (-1.0) ** (k // half_period(base))
    chance = np.repeat(rng.choice([-1.0, 0.0, 1.0], COUNT // 10), 10)
    asked = np.where(np.repeat(rng.random(part) < 0.5, 20), swings, chance)
    share = np.repeat(rng.choice([0.0, 0.1, 1.0], part), 20)
    late = rng.random(COUNT) < share
    return 9 * asked, T * np.where(late, rng.choice(UNTIMELY, COUNT), 1.0)


def fastest(base, limit, asked, since, *, told):
    """Largest |v| of a base whose filter is called at those times, and is told them or not."""
    limit.start()

    def send(k):
        return limit.step((asked[k], 0.0), dt=since[k - 1] if told and k else None).command[0]

    return np.abs(base.speeds(send, since)).max()


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.slow
def test_a_band_that_is_told_the_time_keeps_its_limit_whenever_it_is_called(family):
    stated, bases = FAMILIES[family]
    limit, rng = command_filter(scenario(kind="band", **stated)), np.random.default_rng(3)
    worst = [fastest(b, limit, *standing_still(b), told=True) for b in bases]
    worst += [fastest(b, limit, *at_random(b, rng), told=True) for b in bases for _ in (0, 1)]
    assert 0.7 < max(worst) <= 1.0


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.slow
def test_a_band_that_is_not_told_the_time_breaks_its_limit(family):
    stated, bases = FAMILIES[family]
    limit = command_filter(scenario(kind="band", **stated))
    assert max(fastest(b, limit, *standing_still(b), told=False) for b in bases) > 1.0


def sent_at(limit, since):
    """Commands for steps that ask for all, told ``since`` [s] the one before; which are late."""
    limit.start()
    made = [limit.step((9.0, 0.0), dt=time) for time in since]
    return np.array([m.command[0] for m in made]), np.array(["late" in m.flags for m in made])


@pytest.mark.slow
def test_steps_within_their_jitter_are_in_time_whenever_the_first_came():
    J, rng = T / 4, np.random.default_rng(1)
    limit = command_filter(scenario(kind="band", jitter=J, push=(0.0, 0.0)))
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
    system = BandGovernor(scenario(kind="band", jitter=J, push=(0.0, 0.0))).system
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
    limit = command_filter(scenario(kind="band", push=(0.0, 0.0)))
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
    stated, _ = FAMILIES["pi"]
    limit = command_filter(scenario(kind="band", **stated))
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
    """A clock that stood still or went back, and what is no number, count as no time at all."""
    stated, _ = FAMILIES["pi"]
    limit = command_filter(scenario(kind="band", **stated))
    for _ in range(100):
        before = limit.step((9.0, 0.0)).command[0]
    for wrong in (0.0, -1.0, math.nan, -math.inf, 0.01, math.inf, 1e300):
        assert "late" in limit.step((9.0, 0.0), dt=wrong).flags
    for _ in range(100):
        made = limit.step((9.0, 0.0), dt=T)
    assert made.flags == ("limited",)
    assert made.command[0] > before
    assert limit.step((0.0, 0.0), dt=T).command[0] == 0.0


@pytest.mark.slow
def test_slow_commands_change_in_time_and_no_faster():
    stated = {"loop": "second-order", "frequency": (3.0, 5.0), "damping": (0.4, 1.4)}
    slow = command_filter(scenario(slew=(0.2, 0.2), push=(0.0, 0.0), **stated))
    rng, last = np.random.default_rng(7), 0.0
    for since in (*times_of(rng, 200), math.nan, -math.inf, math.inf):
        made = slow.step((rng.choice([-9.0, 9.0]), 0.0), dt=since)
        most = 0.2 * min(since, T) if since >= 0 else 0.0
        assert abs(made.command[0] - last) <= most * (1 + 1e-9)
        assert ("late" in made.flags) == (not abs(since - T) <= T / 4)
        last = made.command[0]


def times_of(rng, count):
    return T * np.where(rng.random(count) < 0.5, rng.choice(UNTIMELY, count), 1.0)


@pytest.mark.parametrize("wrong", [0.0, -0.05, 0.03, 0.2, math.nan, math.inf])
@pytest.mark.parametrize("kind", ["clip", "governor"])
def test_a_clip_acts_whenever_a_step_is_untimely(kind, wrong):
    limit = command_filter(first_order(kind))
    clip = pytest.approx((1 - 0.05) / 1.1, rel=1e-7)
    limit.step((0.3, 0.0), (0.0, 0.0), dt=T)
    made = limit.step((5.0, 0.0), (0.0, 0.0), dt=wrong)
    assert made.command[0] == clip
    assert made.flags == ("limited", "late")


def late_commands(told):
    """Largest speed of a base whose commands take three periods, but for one that takes none.

    Asked for all, then nine times at once for the reverse, then, by the quick one, for all again:
    nothing but the first commands has acted by then.
    """
    limit, late = command_filter(first_order(delay=(0.0, 3 * T), odometry=None)), 3 * T
    sent, now = [], 0.0
    for k in range(60):
        r = 9.0 if k < 20 or k > 28 else -9.0
        since = 0.0 if 20 <= k < 29 else T
        made = limit.step((r, 0.0), dt=since if told else None)
        now += since
        sent.append((now + (0.0 if k == 29 else late), made.command[0]))
    v, worst, taken = 0.0, 0.0, 0.0
    for (begin, u), (end, _) in zip(sent, [*sent[1:], (now + 1.0, 0.0)], strict=True):
        taken = max(taken, begin)  # in the order in which they were sent
        aim = (1.1 if u > 0 else 0.9) * u + 0.05
        v = aim + (v - aim) * math.exp(-max(0.0, end - taken) / 0.2)
        worst = max(worst, v)
    return worst


def test_commands_that_are_still_on_their_way_are_waited_for():
    assert late_commands(told=False) > 1.01
    assert late_commands(told=True) <= 1.0
