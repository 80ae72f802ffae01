"""Windows of samples, and whether a run lasted through them."""

from dataclasses import replace
from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.results.conftest import build
from wmr_ctrl.results import Monitor, Settings
from wmr_ctrl.results.windows import (
    at_rest,
    covered,
    drive,
    driving,
    labouring,
    robots_over,
    rows_of,
    window,
    windows_of,
    working,
)

SETTINGS = Settings(0.1, 0.01, 8.0, (1.0, 1.5), 4.0)


@given(
    a=st.integers(0, 1200),
    b=st.integers(0, 1200),
    control=st.sampled_from([Fraction(1, 100), Fraction(1, 10), Fraction(3, 10)]),
)
def test_a_window_holds_the_samples_that_exact_arithmetic_puts_there(a, b, control):
    start, end = Fraction(a, 1000), Fraction(a + b, 1000)
    run = build(duration=float(300 * control), control=float(control))
    inside = [k for k in range(300) if start <= k * control < end]
    rows = window(run, float(start), float(end))

    assert rows is not None
    assert list(range(300))[rows] == inside


@pytest.mark.parametrize("k, stop", [(3, 0.3), (3, 0.1 * 3), (2, 0.29), (3, 0.3999)])
def test_a_period_counts_once_it_is_over_however_its_end_is_rounded(k, stop):
    ended = Monitor((0.0, 0.0), stopped=(stop, 1), stop_reason="diverged")
    run = build(rows=5, duration=1.0, control=0.1, monitor=ended)

    assert covered(run) == k


def test_a_motion_is_judged_over_its_end_and_a_path_that_stops_over_its_drive():
    stops = replace(SETTINGS, arrival=6.0)

    assert (drive(SETTINGS), working(SETTINGS), at_rest(SETTINGS)) == ((60, 80), (40, 80), (80, 80))
    assert (drive(stops), working(stops), at_rest(stops)) == ((30, 60), (30, 60), (60, 80))
    assert working(replace(SETTINGS, duration=0.1))[0] == 1
    assert windows_of(stops)["before"] == (0, 40)
    assert windows_of(stops)["end"] == (60, 80)
    assert rows_of(build(duration=8.0, control=0.1, rows=59), drive(stops)) is None


@pytest.mark.parametrize(
    "start, end, words",
    [(0.0, 8.0, "50 kg, from 4 s on 65 kg"), (0.0, 4.0, "50 kg"), (4.0, 8.0, "65 kg")],
)
def test_robots_of_a_window_are_told_where_they_change(start, end, words):
    changing = replace(SETTINGS, robots=((0.0, "50 kg"), (4.0, "65 kg")))
    run = replace(build(duration=8.0, control=0.1), settings=changing)

    assert robots_over(changing, start, end) == words
    assert robots_over(SETTINGS) == ""
    assert driving(run) == "last quarter (6 to 8 s: 65 kg)"
    assert labouring(run) == "last half (4 to 8 s: 65 kg)"
    assert driving(replace(run, settings=replace(SETTINGS, arrival=6.0))) == "drive (3 to 6 s)"
