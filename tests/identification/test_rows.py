"""Rows that say nothing about a base are left out, and commands that cease end; good logs stay."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.signal import lfilter

from wmr_ctrl import identify
from wmr_ctrl.identification.logs.log import LogError, of_columns
from wmr_ctrl.identification.logs.mended import mended, unwrapped
from wmr_ctrl.identification.logs.rows import usable
from wmr_ctrl.identification.logs.samples import Samples

T, INNER = 0.02, 20
LATE = 0.04
NAMES_OF_COUNTS = ("wheel_counts[1]", "wheel_counts[2]")
NAMES = ("v_command [m/s]", "omega_command [rad/s]", "v1_measured [m/s]", "omega_measured [rad/s]")


def drive(seed=0, seconds=40.0, noise=0.003, tau=0.1, held=0.8, timeout=None, silent=(), off=()):
    """Times, commands and speeds (N, 2) of a first-order base; nan where commands cease."""
    rng, count = np.random.default_rng(seed), round(seconds / T)
    rows = max(round(held / T), 1)
    sent = rng.uniform(-0.5, 0.5, (count // rows + 1, 2)).repeat(rows, axis=0)[:count]
    t = np.arange(count) * T
    acting, heard = sent.copy(), np.ones(count, bool)
    for begin, end in silent:
        heard[(t >= begin) & (t < end)] = False
        held_until = begin + timeout if timeout else end
        acting[(t >= begin) & (t < end)] = sent[t < begin][-1]
        acting[(t >= held_until) & (t < end)] = 0.0
    alive = np.ones(count)
    for begin, end in off:
        alive[(t >= begin) & (t < end)] = 0.0
    fine = (0.97 * acting * alive[:, None]).repeat(INNER, axis=0)
    fine = np.vstack((np.zeros((round(LATE / T) * INNER, 2)), fine))[: count * INNER]
    share = -math.expm1(-T / INNER / tau)
    v = lfilter([0.0, share], [1.0, share - 1.0], fine, axis=0)[::INNER]
    return t, np.where(heard[:, None], sent, np.nan), v + noise * rng.normal(size=v.shape)


def samples(t, sent, v):
    heard = np.isfinite(sent[:, 0])
    return Samples(t, v, np.zeros(2), t[heard], sent[heard], np.array([0]), of_speed=True)


@settings(max_examples=25)
@example(seed=33381, noise=0.01, tau=0.005, held=0.1, quantum=0.01)
@given(
    seed=st.integers(0, 10**6), noise=st.sampled_from([0.0, 0.001, 0.01, 0.04]),
    tau=st.sampled_from([0.005, 0.05, 0.2]), held=st.sampled_from([0.1, 0.8, 3.0]),
    quantum=st.sampled_from([None, 0.01, 0.04]),
)  # fmt: skip
def test_nothing_of_a_good_log_is_left_out(seed, noise, tau, held, quantum):
    t, sent, v = drive(seed, 12.0, noise, tau, held)
    v = v if quantum is None else np.round(v / quantum) * quantum

    rows = usable(samples(t, sent, v))

    assert rows.notes == rows.left_out == ()
    assert rows.timeout is None
    assert rows.samples.use.all()
    assert np.array_equal(rows.samples.seen, v)


@settings(max_examples=10)
@given(seed=st.integers(0, 10**6), share=st.sampled_from([0.01, 0.08]), size=st.floats(1.0, 9.0))
def test_readings_that_no_acceleration_explains_are_left_out_with_their_times(seed, share, size):
    t, sent, v = drive(seed)
    rng = np.random.default_rng(seed)
    zero, far = rng.random(len(t)) < share, rng.choice(np.arange(50, len(t) - 50), 5, replace=False)
    spoilt = np.where(zero[:, None], 0.0, v)
    spoilt[far, 0] = size * rng.choice([-1, 1], 5)

    rows = usable(samples(t, spoilt * 0 + sent, spoilt))

    moves = np.abs(v) > 0.1
    missed = rows.samples.use & moves & zero[:, None]
    assert missed.sum() < 0.1 * (moves & zero[:, None]).sum() + 2
    assert (~rows.samples.use[far, 0]).sum() >= 4
    assert (~rows.samples.use & ~zero[:, None])[:, 1].sum() <= 2
    assert np.abs(rows.samples.seen - v)[far, 0].max() < 0.3
    assert {note.key for note in rows.notes} == {"readings"}
    left = [(item.begin, item.end) for item in rows.left_out]
    assert all(any(a <= t[k] <= b for a, b in left) for k in far[~rows.samples.use[far, 0]])


@pytest.mark.slow_but("0.5")
@pytest.mark.parametrize("timeout", [0.3, 0.5, 1.2])
def test_a_silence_shows_when_the_base_stops(timeout):
    silent = [(6.0, 10.0), (14.0, 18.0), (25.0, 30.0), (37.0, 40.0)]

    rows = usable(samples(*drive(3, timeout=timeout, silent=silent)))
    other = usable(samples(*drive(3, silent=silent)))

    assert rows.timeout == pytest.approx(timeout, abs=0.041)
    assert other.timeout is None
    assert "goes on" in other.notes[0].text
    assert [note.key for note in (*rows.notes, *other.notes)] == ["timeout"] * 2


def test_a_log_of_which_hardly_a_row_is_left_is_too_short():
    t, sent, v = drive(4, seconds=6.0)
    v[np.random.default_rng(4).random(v.shape) < 0.5] *= 1e5
    log = dict(zip(("t [s]", *NAMES), np.column_stack((t, sent, v)).T.tolist(), strict=True))

    with pytest.raises(LogError, match=r"s is too short; drive for 2 s"):
        identify(log, base="velocity")


def test_stretches_with_the_drivers_off_are_left_out():
    rows = usable(samples(*drive(4, seconds=60.0, off=[(12.0, 20.0), (40.0, 52.0)])))
    t, use = rows.samples.t, rows.samples.use[:, 0]

    assert [note.key for note in rows.notes] == ["drivers-off"] * 2
    for begin, end in ((12.2, 20.0), (40.2, 52.0)):
        assert not use[(t > begin) & (t < end)].any()
    assert use[(t > 22.0) & (t < 39.0)].all()


@settings(max_examples=40)
@given(
    seed=st.integers(0, 10**6), fast=st.floats(1.0, 40.0), start=st.integers(-(10**6), 10**6),
    modulus=st.sampled_from([2**12, 2**15, 2**16, 2**32, 5000, 9000, 1234, 36000]),
)  # fmt: skip
def test_counters_go_on_where_they_wrap_at_any_modulus(seed, fast, start, modulus):
    rng = np.random.default_rng(seed)
    speed = np.convolve(rng.uniform(-fast, fast, 60).repeat(50), np.ones(20) / 20, "same")
    counts = np.floor(np.cumsum([speed, -0.7 * speed], axis=1) + start).astype(np.int64)
    t = 0.02 * np.arange(counts.shape[1])
    log = of_columns("log", {"t": t, **dict(zip(NAMES_OF_COUNTS, counts % modulus, strict=True))})

    read = unwrapped(log)

    for name, true in zip(NAMES_OF_COUNTS, counts, strict=True):
        wraps = int(np.sum(np.diff(true // modulus) != 0))
        if wraps == 0 or wraps >= 2 or modulus in (2**12, 2**15, 2**16, 2**32, 5000, 9000, 36000):
            assert read.columns[name] - read.columns[name][0] == pytest.approx(
                true - true[0], abs=0.001 * modulus * wraps
            )


@pytest.mark.parametrize("scatter", [1e-3, 3e-3])
def test_an_even_clock_is_taken_where_only_stamps_scatter(scatter):
    rng, even = np.random.default_rng(1), T * np.arange(2000)
    true = even + scatter * rng.uniform(-1, 1, len(even))
    turn = [np.floor(300 * np.cumsum(np.sin(rate * even))) for rate in (0.7, 1.1)]
    at_true = [np.floor(np.interp(true, even, row)) for row in turn]
    counts, irregular = (dict(zip(NAMES_OF_COUNTS, rows, strict=True)) for rows in (turn, at_true))

    read = mended(of_columns("log", {"t": true, **counts}))
    kept = mended(of_columns("log", {"t": true, **irregular}))

    assert read.times[NAMES_OF_COUNTS[0]] == pytest.approx(even, abs=0.2 * scatter)
    assert [note.key for note in read.notes] == ["clocks"]
    assert np.array_equal(kept.times[NAMES_OF_COUNTS[0]], true)


def test_rows_at_the_time_of_the_row_before_are_left_out_if_they_are_few():
    t = np.sort(np.concatenate((np.arange(500) * T, [1.0, 2.0, 3.0])))
    log = of_columns("log", {"t": t, "v1": np.arange(503.0), "omega": np.zeros(503)})

    read = mended(log)

    assert (np.diff(read.times["v1"]) > 0).all()
    assert read.columns["v1"][50:52].tolist() == [50.0, 52.0]
    assert [note.key for note in read.notes] == ["clocks"]


@pytest.mark.parametrize("far", [700.0, -700.0, math.nan])
def test_single_counts_that_are_far_off_or_no_numbers_are_left_out(far):
    t = np.arange(500) * T
    counts = [np.floor(400 * np.sin(rate * t)) for rate in (0.7, 1.1)]
    odd = [50, 200, 201, 400]
    spoilt = [counts[0].copy(), counts[1]]
    spoilt[0][odd] += far
    good = of_columns("log", {"t": t, **dict(zip(NAMES_OF_COUNTS, counts, strict=True))})
    log = replace(good, columns=dict(zip(NAMES_OF_COUNTS, spoilt, strict=True)))

    read = mended(log)

    for name, rows in zip(NAMES_OF_COUNTS, counts, strict=True):
        assert read.columns[name].tolist() == np.delete(rows, odd).tolist()
        assert read.times[name].tolist() == np.delete(t, odd).tolist()
    assert len(read.notes) == 1
    assert not mended(good).notes


def test_what_was_left_out_is_told_and_the_base_is_found_all_the_same():
    t, sent, v = drive(5, timeout=0.5, silent=[(6.0, 10.0), (20.0, 24.0)], off=[(28.0, 34.0)])
    v[np.random.default_rng(0).random(len(t)) < 0.07] = 0.0
    heard = np.isfinite(sent[:, 0])
    columns = dict(zip(NAMES, (*np.where(heard[:, None], sent, np.nan).T, *v.T), strict=True))
    log = {"t [s]": t, **columns}

    found = identify({key: row.tolist() for key, row in log.items()}, base="velocity")

    told = found.to_json()
    assert {row["key"] for row in told["diagnosis"]} >= {"readings", "drivers-off", "timeout"}
    assert any(row["reason"] == "commanded but at rest" for row in told["left_out"])
    for axis in (1, 2):
        assert found.parameters[f"gain{axis}"].value == pytest.approx(0.97, rel=0.01)
        assert found.parameters[f"delay{axis}"].value == pytest.approx(LATE, abs=0.005)
    assert found.scenario.value("base.timeout")[0] == pytest.approx(0.5, abs=0.041)
    assert "timeout = 0.5" in found.to_toml()
