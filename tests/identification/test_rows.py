"""Rows that say nothing about a base are excluded, and silent commands end; good logs stay."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.own_axes import changed
from tests.identification.conftest import BASE, NUMBERS, drive
from tests.papers_robot import paper
from wmr_ctrl import identify
from wmr_ctrl.identification.logs.lint import check_motion
from wmr_ctrl.identification.logs.log import COMMAND, LogError, of_columns
from wmr_ctrl.identification.logs.mended import mended, unwrapped
from wmr_ctrl.identification.logs.rows import usable
from wmr_ctrl.identification.logs.samples import motion_of
from wmr_ctrl.world.encoder import COUNTS

T = 0.02
MEASURED = ("v1_measured [m/s]", "omega_measured [rad/s]")


def rows_of(log):
    return usable(motion_of(of_columns("log", log), paper(), "v1_measured", COMMAND))


def keys(found):
    return [note.key for note in found.notes]


@settings(max_examples=12)
@given(
    seed=st.integers(0, 10**6), noise=st.sampled_from([0.0, 0.01, 0.04]),
    first=st.sampled_from([0.005, 0.05, 0.2]), held=st.sampled_from([0.1, 0.8, 3.0]),
    quantum=st.sampled_from([0.0, 0.01, 0.04]),
)  # fmt: skip
def test_nothing_of_a_good_log_is_left_out(seed, noise, first, held, quantum):
    how = {"noise": (noise, noise), "held": (held, held), "quantum": quantum}
    log = drive(changed(BASE, first=first), seed, **how)

    rows = rows_of(log)

    assert rows.notes == rows.left_out == ()
    assert rows.timeout is None
    assert rows.samples.use.all()
    assert np.array_equal(rows.samples.seen.T, [log[name] for name in MEASURED])


@pytest.mark.parametrize("seed, zeros", [(1, 0.01), (2, 0.08), (3, 0.08)])
def test_readings_that_no_acceleration_explains_are_left_out_with_their_times(seed, zeros):
    logs = drive(seed=seed, seconds=24.0), drive(seed=seed, seconds=24.0, zeros=zeros, spikes=5)
    true, seen = (np.column_stack([log[name] for name in MEASURED]) for log in logs)

    rows = rows_of(logs[1])

    far, use = np.abs(seen) > 2.0, rows.samples.use
    lost = (seen != true) & (np.abs(true) > 0.1) & ~far
    assert (use & lost).sum() < 0.1 * lost.sum() + 2
    assert (use & far).sum() <= 1
    assert (~use & (seen == true)).sum() <= 2
    assert np.abs(rows.samples.seen - true)[far & ~use].max() < 0.3
    assert {*keys(rows)} == {"readings"}
    told = [(item.begin, item.end) for item in rows.left_out]
    off = rows.samples.t[~use.all(axis=1)]
    assert all(any(begin <= t <= end for begin, end in told) for t in off)


def test_a_silence_shows_when_the_base_stops():
    silent = {"seconds": 24.0, "silent": (4.0, 6.0)}

    rows = rows_of(drive(replace(BASE, timeout=0.5), **silent))
    other = rows_of(drive(**silent))

    assert rows.timeout == pytest.approx(0.5, abs=0.041)
    assert other.timeout is None
    assert "goes on" in other.notes[0].text
    assert keys(rows) == keys(other) == ["timeout"]


def test_a_log_of_which_hardly_a_row_is_left_is_too_short():
    samples = rows_of(drive(seconds=6.0)).samples
    fourth = np.arange(len(samples.t))[:, None] % [4, 1] == 0

    with pytest.raises(LogError, match=r"1\.5 s is too short; drive for 2 s"):
        check_motion("log", replace(samples, use=fourth), 0.2, 2.0)


def test_stretches_with_the_drivers_off_are_left_out():
    rows = rows_of(drive(seconds=40.0, off=((8.0, 14.0), (24.0, 32.0))))
    t, use = rows.samples.t, rows.samples.use[:, 0]

    assert keys(rows) == ["drivers-off"] * 2
    for begin, end in ((8.2, 14.0), (24.2, 32.0)):
        assert not use[(t > begin) & (t < end)].any()
    assert use[(t > 16.0) & (t < 23.0)].all()


def turned(t):
    """Counts of both wheels at times (N,) [s]."""
    return [np.floor(400 * np.sin(rate * t)) for rate in (0.7, 1.1)]


def counted(t, counts):
    return of_columns("log", {"t": t, **dict(zip(COUNTS.elements, counts, strict=True))})


@settings(max_examples=30)
@given(
    seed=st.integers(0, 10**6),
    modulus=st.sampled_from([2**12, 2**15, 2**16, 2**32, 5000, 9000, 1234, 36000]),
)
def test_counters_go_on_where_they_wrap_at_any_modulus(seed, modulus):
    rng, t = np.random.default_rng(seed), T * np.arange(3000)
    speed = rng.uniform(1.0, 40.0) * np.sin(np.outer((0.3, 0.2), t) + rng.uniform(0, 9, (2, 1)))
    counts = np.floor(np.cumsum(speed, axis=1) + rng.integers(-(10**6), 10**6)).astype(np.int64)

    read = unwrapped(counted(t, counts % modulus)).columns

    for name, true in zip(COUNTS.elements, counts, strict=True):
        wraps = np.count_nonzero(np.diff(true // modulus))
        if wraps != 1 or modulus != 1234:
            most = 0.001 * modulus * wraps
            assert read[name] - read[name][0] == pytest.approx(true - true[0], abs=most)


@pytest.mark.parametrize("scatter", [1e-3, 3e-3])
def test_an_even_clock_is_taken_where_only_stamps_scatter(scatter):
    even = T * np.arange(2000)
    true = even + scatter * np.random.default_rng(1).uniform(-1, 1, len(even))

    read, kept = (mended(counted(true, turned(t))) for t in (even, true))

    assert read.times[COUNTS.elements[0]] == pytest.approx(even, abs=0.2 * scatter)
    assert keys(read) == ["clocks"]
    assert np.array_equal(kept.times[COUNTS.elements[0]], true)


def test_rows_at_the_time_of_the_row_before_are_left_out_if_they_are_few():
    t = np.sort(np.concatenate((np.arange(500) * T, [1.0, 2.0, 3.0])))

    read = mended(of_columns("log", {"t": t, "v1": np.arange(503.0), "omega": np.zeros(503)}))

    assert (np.diff(read.times["v1"]) > 0).all()
    assert read.columns["v1"][50:52].tolist() == [50.0, 52.0]
    assert keys(read) == ["clocks"]


@pytest.mark.parametrize("far", [700.0, -700.0, math.nan])
def test_single_counts_that_are_far_off_or_no_numbers_are_left_out(far):
    t, odd = np.arange(500) * T, [50, 200, 201, 400]
    good = counted(t, turned(t))
    name, other = COUNTS.elements
    spoilt = good.columns[name].copy()
    spoilt[odd] += far

    read = mended(replace(good, columns=good.columns | {name: spoilt}))

    for item in (name, other):
        assert read.columns[item].tolist() == np.delete(good.columns[item], odd).tolist()
        assert read.times[item].tolist() == np.delete(t, odd).tolist()
    assert len(read.notes) == 1
    assert not mended(good).notes


def test_what_was_left_out_is_told_and_the_base_is_found_all_the_same():
    faults = {"silent": (8.0, 12.0), "off": ((25.0, 31.0),), "zeros": 0.07, "seconds": 40.0}

    found = identify(drive(replace(BASE, timeout=0.5), **faults), base="velocity")

    told = found.to_json()
    assert {row["key"] for row in told["diagnosis"]} >= {"readings", "drivers-off", "timeout"}
    assert any(row["reason"] == "commanded but at rest" for row in told["left_out"])
    for name in ("gain1", "gain2", "delay1", "delay2"):
        assert found.parameters[name].value == pytest.approx(NUMBERS[name], rel=0.01, abs=0.005)
    assert found.scenario.value("base.timeout")[0] == pytest.approx(0.5, abs=0.041)
    assert "timeout = 0.5" in found.to_toml()
