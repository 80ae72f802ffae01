"""Bounds and numbers that a part of a log contradicts are named; good logs contradict none."""

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from benchmarks.own_plant import log_of, simulate
from tests.identification.conftest import KNOWN, STEP, TRUTH
from wmr_ctrl.identification import fit as fitting
from wmr_ctrl.identification import identify
from wmr_ctrl.identification.fit import Fitted, changes
from wmr_ctrl.identification.refuted import _monitor, contradictions, explaining


def test_a_good_log_contradicts_none_of_its_bounds(found):
    assert found.bounds.refuted == ()
    assert contradictions(found.white, found.bounds) == ()


@pytest.mark.slow
@pytest.mark.parametrize(
    "changes, key",
    [({}, None), ({"m": 42.0}, "m was"), ({"gust": (12.0, 2.4, 0.5)}, "guard.dbar[2]")],
)
def test_what_changed_in_the_last_third_is_named_and_the_guard_is_off(driven, changes, key):
    other = simulate(replace(TRUTH, **changes), 1, 12.0, seed=5, step=STEP)

    found = identify([log_of(driven, 0), log_of(other, 0)], overrides=KNOWN)

    assert found.scenario.guard.enabled is (key is None)
    if key is None:
        assert found.bounds.refuted == ()
        return
    assert any(key in text for text in found.bounds.refuted), found.bounds.refuted
    assert any("the guard is off: a part of the log" in text for text in found.remarks)


def test_clocks_that_drift_apart_look_like_a_delay_that_changed(driven):
    log = {key: np.array(value) for key, value in log_of(driven, 0).items()}
    slow = 1.008 * log["t [s]"]
    log |= {key: np.interp(log["t [s]"], slow, log[key]) for key in log if "counts" in key}

    found = identify({key: values.tolist() for key, values in log.items()}, overrides=KNOWN)

    (said,) = found.bounds.refuted
    assert said.startswith("delay was")
    assert not found.scenario.guard.enabled


def changed(values, seconds=30.0):
    """Return the changes found in fifteen blocks of time that each determine a value to 1 %."""
    names = ("m", "I", "delay")
    values = np.array([values] * 3).T
    theta = values.mean(axis=0)
    information = np.array([1e4 * np.eye(3)] * 15)
    fit = Fitted(theta, np.array([True, False, True]), 1e4 * (theta - values), information)
    return changes(fit, names, SimpleNamespace(t=np.array([0.0, seconds]), period=0.05))


@pytest.mark.parametrize("ends", range(3, 13))
def test_values_of_blocks_that_step_are_told_with_the_time_of_the_step(ends):
    """The step from 30 to 36 is logarithmic for the mass; a delay has its own values."""
    found = changed(np.where(np.arange(15) < ends, np.log(30.0), np.log(36.0)))

    times = {name: item.time for name, item in found.items()}
    assert times == pytest.approx({"m": 2.0 * ends, "delay": 2.0 * ends})
    assert found["delay"].values == pytest.approx((math.log(30.0), math.log(36.0)))


@pytest.mark.parametrize("step, told", [(0.0, []), (0.047, []), (0.0495, ["m"])])
def test_blocks_that_scatter_or_step_by_little_tell_no_change(step, told):
    scatter = 0.004 * np.cos(2.4 * np.arange(15))
    assert list(changed(math.log(30.0) + step * (np.arange(15) < 7) + scatter)) == told


@pytest.mark.parametrize("apart", [1e-9, 1e-6, 1e-3])
def test_numbers_that_half_of_a_log_does_not_tell_apart_have_not_changed(apart):
    """Two numbers have not changed if their columns are almost equal in the log's first half."""
    rng = np.random.default_rng(1)
    x = rng.normal(size=(16, 100, 2))
    x[:8, :, 1] = x[:8, :, 0] * (1 + apart * rng.normal(size=(8, 100)))
    y = rng.normal(size=(16, 100))
    theta = np.linalg.lstsq(x.reshape(-1, 2), y.ravel(), rcond=None)[0]
    gradient = -np.einsum("bni,bn->bi", x, y - x @ theta)
    fit = Fitted(theta, np.array([True, True]), gradient, x.swapaxes(1, 2) @ x)

    assert changes(fit, ("m", "I"), SimpleNamespace(t=np.array([0.0, 9.0]), period=0.05)) == {}


def test_a_width_that_is_no_number_tells_no_change(monkeypatch):
    monkeypatch.setattr(fitting, "errors_of", lambda _, fisher, free: np.full(len(free), np.nan))

    assert changed(np.where(np.arange(15) < 7, 0.0, 1.0)) == {}


def test_bounds_that_are_too_narrow_are_contradicted_until_dbar_is_wide_enough(found):
    """With the monitor's least push as dbar nothing contradicts; with slightly less it does."""
    narrow = replace(found.bounds, dbar=(0.01, 0.01))

    against = contradictions(found.white, narrow)

    assert 1 in {item.axis for item in against} <= {0, 1}
    assert contradictions(found.white, explaining(found.white, narrow)) == ()
    for item in against:
        least = [0.0, 0.0]
        least[item.axis] = 0.999 * item.push
        still = contradictions(found.white, replace(narrow, dbar=tuple(least)))
        assert item.axis in {each.axis for each in still}
        assert "dbar" in item.against(narrow)


def test_a_push_is_seen_for_what_the_lightest_robot_needed():
    """Without a force, from 0.1 to 0.3 m/s in 0.1 s, for 40 to 60 kg; with 50 N only the
    remainder.
    """
    for force, push in ((0.0, 80.0), (50.0, 30.0)):
        assert float(_monitor()(0.3, 0.1, force, 0.1, 0.0, 40.0, 60.0)) == pytest.approx(push)
