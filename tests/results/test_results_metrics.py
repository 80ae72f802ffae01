"""Figures of a run: properties that the definitions imply, then the summary's shape."""

import json
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.results.conftest import build
from wmr_ctrl.results import Monitor, e_rms, ise, summary, tau_peak, tau_rms
from wmr_ctrl.results.measures import ise_over

CONTROLS = st.sampled_from([0.001, 0.01, 0.1, 0.3, 1 / 3])
ERRORS = st.floats(-1e3, 1e3).filter(lambda c: c == 0 or abs(c) > 1e-3)
STOPPED = Monitor((2.0, 1000.0), 3, (0.3, 1), (0.6, 2), "diverged")


# -- integral squared error ---------------------------------------------------------------


@pytest.mark.parametrize("name", ["x", "y_d", "theta"])
@given(c=ERRORS, rows=st.integers(1, 300), control=CONTROLS)
def test_a_constant_error_integrates_to_its_square_times_the_duration(name, c, rows, control):
    run = build(duration=rows * control, control=control, **{name: c})
    expected = c**2 * rows * control

    assert ise(run)["total"] == pytest.approx(expected, rel=1e-12)
    parts = sum(ise(run)[part] or 0.0 for part in ("before", "after"))
    assert parts == pytest.approx(expected, rel=1e-12)
    assert ise(run)["position"] == pytest.approx(
        0.0 if name.startswith("theta") else expected, rel=1e-12
    )


@pytest.mark.parametrize("start, end", [(-0.1, 0.5), (0.5, 0.4), (0.0, 1.01), (2.0, 3.0)])
def test_a_window_outside_the_run_has_no_figure(start, end):
    assert ise_over(build(), start, end) is None
    assert e_rms(build(), start, end) is None
    assert e_rms(build(), 0.5, 0.5) is None
    assert ise_over(build(x=1.0), 0.5, 0.5) == 0.0


# -- runs that ended early ----------------------------------------------------------------


def test_an_early_end_leaves_only_the_windows_that_it_covers():
    whole = build(x=1.0, split=0.6)
    early = build(x=1.0, split=0.6, rows=60, monitor=STOPPED)

    assert ise(early) == {
        "total": None,
        "before": ise(whole)["before"],
        "after": None,
        "position": None,
    }
    assert ise_over(early, 0.0, 0.61) is None
    figures = summary(build(rows=0, monitor=STOPPED, rms_from=0.0))
    assert set(figures["ise"].values()) | set(figures["e_rms"].values()) == {None}
    assert (figures["tau_peak"], figures["tau_rms"]) == (None, None)


# -- torques and body-frame errors --------------------------------------------------------


@pytest.mark.parametrize("wheel", ["tau_right", "tau_left"])
@pytest.mark.parametrize("row", [0, 57, 99])
@pytest.mark.parametrize("sign", [-1, 1])
def test_the_torque_peak_is_found_on_either_wheel(wheel, row, sign):
    torque = np.full(100, 0.5)
    torque[row] = 7.0 * sign

    assert tau_peak(build(**{wheel: torque})) == 7.0


def test_the_torque_rms_starts_at_its_sample_and_not_before():
    torque = np.where(np.arange(100) < 30, 100.0, 2.0)

    assert tau_rms(build(tau_right=torque, tau_left=2.0, rms_from=0.3)) == pytest.approx(2.0)
    assert tau_rms(build(tau_right=torque, tau_left=2.0, rms_from=0.29)) == pytest.approx(
        math.sqrt((100**2 + 141 * 2**2) / 142)
    )
    assert tau_rms(build(rms_from=1.0)) is None


def test_the_rms_windows_of_the_summary_are_half_open():
    time = np.arange(800) / 10
    marks = np.stack([time, np.where(time < 40, 1.0, 3.0), np.where(time >= 45, 5.0, 0.0)], axis=1)
    figures = summary(build(duration=80.0, control=0.1, e=marks))["e_rms"]

    assert {key: values[1:] for key, values in figures.items()} == {
        "30-40": [1.0, 0.0],
        "40-45": [3.0, 0.0],
        "70-80": [3.0, 5.0],
    }
    squares = [t**2 for t in time if 40 <= t < 45]
    assert figures["40-45"][0] == pytest.approx(math.sqrt(sum(squares) / 50))


# -- summary ------------------------------------------------------------------------------


def test_the_summary_has_exactly_the_published_keys():
    hashes = {"version": "1.0", "scenario_hash": "ab", "kernel_hash": "cd"}
    monitor = Monitor((1.2, 0.5), 4, (0.1, 1), d_least=(3, math.inf))
    told = {**hashes, "scenario_toml": "..."}
    run = build(provenance=told, monitor=monitor, dbar=(60, 15))
    figures = summary(run)

    assert " ".join(figures) == (
        "scenario law guard seed engine plant watched_every outcome robots ise position_rms "
        "position_max tracking tracked arrival guard_share filter_share usable_speed "
        "reference_speed torque_change_rms torque_needed_rms saturated_share max_abs_v "
        "least_margin least_gap violations kept rigid d_least dbar tau_peak tau_rms e_rms figures "
        "remarks provenance"
    )
    assert [item["key"] for item in figures["remarks"]] == ["limit-violated"]
    assert list(figures["position_rms"]) == ["all", "last_quarter"]
    assert figures["provenance"] == hashes
    assert (figures["violations"], figures["max_abs_v"]) == (4, [1.2, 0.5])
    assert (figures["outcome"], type(figures["outcome"])) == ("limit-violated", str)
    assert (figures["d_least"], figures["dbar"]) == ([3.0, None], [60.0, 15.0])


@given(value=st.sampled_from([math.nan, math.inf, -math.inf, 1e200]))
def test_the_summary_is_strict_json_whatever_the_numbers_are(value):
    lost = Monitor((math.nan, math.inf), 1, (0.0, 1), (0.5, 1), "non-finite")
    for monitor in (lost, Monitor((0.1, 0.1))):
        run = build(x=value, e=value, tau_left=value, rms_from=0.0, monitor=monitor)
        figures = summary(run)

        assert json.loads(json.dumps(figures, allow_nan=False)) == figures
        assert figures["ise"]["total"] is None
        assert figures["tau_peak"] == (1e200 if value == 1e200 else None)
    assert summary(build(rows=50, monitor=lost))["max_abs_v"] == [None, None]
