"""Identification of a base that takes torques: the intervals contain the true values."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.linalg import expm

import wmr_ctrl.identification.identification as identifying
from benchmarks.own_plant import log_of
from tests.identification.conftest import KNOWN, TRUTH
from tests.papers_robot import paper
from wmr_ctrl.core.errors import ArgumentError
from wmr_ctrl.identification import identify
from wmr_ctrl.identification.estimate import searched
from wmr_ctrl.identification.fit import PHYSICAL, packed
from wmr_ctrl.identification.kalman import NAMES, SKIPPED, WATCHED, CompiledFilter
from wmr_ctrl.identification.logs.log import LogError
from wmr_ctrl.identification.logs.samples import Samples
from wmr_ctrl.world.scenario import loads_scenario

MAIN = ("m", "I", "delay", "lag")


def assert_holds(found, names):
    """Three half-widths: an interval of 95 % misses by that much once in 1e8."""
    for name in names:
        item = found.parameters[name]
        middle, half = (item.low + item.high) / 2, (item.high - item.low) / 2
        assert abs(getattr(TRUTH, name) - middle) <= 3 * half, name


def test_the_truth_is_near_every_interval_and_the_scenario_has_the_estimates(found):
    assert_holds(found, PHYSICAL)
    for name in MAIN:
        assert found.parameters[name].value == pytest.approx(getattr(TRUTH, name), rel=0.2)
    assert found.parameters["m"].verdict == "determined"
    text = found.to_toml()
    assert "determined" in text
    scenario = loads_scenario(text, found.scenario.name)
    assert scenario == found.scenario
    assert scenario.robot.m == pytest.approx(found.parameters["m"].value, rel=5e-4)
    assert scenario.guard.M_min[0] <= found.parameters["m"].low * (1 + 1e-9)
    assert scenario.guard.enabled, found.remarks


@pytest.mark.slow
def test_missing_rows_and_a_gap_leave_the_truth_in_reach(driven):
    log = {key: np.array(value) for key, value in log_of(driven, 1).items()}
    lost = np.random.default_rng(0).random(len(log["t [s]"])) < 0.1
    lost[400:500] = True
    log |= {key: np.where(lost, np.nan, row) for key, row in log.items() if "counts" in key}
    lists = {key: row.tolist() for key, row in log.items()}

    assert_holds(identify(lists, overrides=KNOWN), MAIN)


def test_numbers_of_the_motors_are_handed_on(driven):
    log = log_of(driven, 0)
    for side in ("right", "left"):
        log[f"voltage_{side} [V]"] = log.pop(f"tau_{side} [N.m]")

    with pytest.raises(LogError, match="--torque-constant"):
        identify(log, overrides=KNOWN)
    with pytest.raises(ArgumentError, match=r"resistance = -2 must be positive"):
        identify(log, torque_constant=1.0, resistance=-2.0)


@pytest.mark.parametrize("nll, information", [(np.nan, 1.0), (1.0, np.nan), (1.0, np.inf)])
def test_fit_that_is_not_finite_is_refused_in_words(nll, information, driven, monkeypatch):
    bad = SimpleNamespace(nll=nll, information=lambda: np.full((2, 2), information))
    monkeypatch.setattr(identifying, "white_fit", lambda problem: bad)
    monkeypatch.setattr(identifying, "coloured_if_likelier", lambda white: white)

    with pytest.raises(LogError, match=r"no model of the robot explains .* time stamps"):
        identify(log_of(driven, 0), overrides=KNOWN)


def parameters(known, **values):
    """Return the parameters of a filter: all searched ones, then r, l, g, v_s and T."""
    ones = dict.fromkeys(("s1", "s2", "time", "n1", "n2"), 1.0)
    return np.concatenate((searched(ones | values), known))


def test_gradient_and_likelihood_agree():
    """The filter's propagated derivatives, against differences of the likelihood.

    Without derivatives the likelihood has the same bits, so trials may omit them.  The log has a
    gap, after which only measured values are known.
    """
    rng, t = np.random.default_rng(1), np.arange(200) * 0.02
    seen, torques = np.cumsum(rng.normal(size=(200, 2)) * 1e-3, axis=0), rng.normal(size=(200, 2))
    log = Samples(t, seen, np.array([1e-8, 1e-7]), t, torques, np.array([0, 90]))
    p = parameters(
        (0.08, 0.2, 9.81, 0.01, 0.02), m=30.0, I=1.6, Fc=12.0, Fv=6.0, c=3.0, Mv=0.3,
        delay=0.033, lag=0.05, q1=3.0, q2=0.5, s2=0.3, time=0.5,
    )  # fmt: skip
    covariance = packed(np.array([1e-8, 1e-7, 1.0, 1.0, 0.1, 0.1]))
    filter_ = CompiledFilter(paper())

    def read(off=0.0, seen=seen, **how):
        return filter_(replace(log, seen=seen), np.zeros((2, 8)), p + off, covariance, **how)

    whole, alone, skipped = read(), read(slopes=False), read(slopes=False, kinds=SKIPPED)
    assert (alone.nll == whole.nll).all()
    assert (alone.mean == whole.mean).all()
    assert (skipped.mean == alone.mean).all()  # they are taken in, and not counted
    assert not skipped.nll.any()
    first, other = (read(seen=x, slopes=False, kinds=WATCHED).mean for x in (seen, seen + 0.1))
    assert (first == other).all()  # they are not taken in
    assert (first != alone.mean).any()
    gradient = whole.gradient.sum(axis=0)
    steps = 1e-5 * np.eye(len(NAMES), len(p))
    slopes = [(read(step).nll.sum() - read(-step).nll.sum()) / 2e-5 for step in steps]
    assert gradient == pytest.approx(np.array(slopes), rel=1e-5, abs=1e-6 * abs(gradient).max())


def test_the_filter_is_the_kalman_filter_of_a_linear_robot():
    """Without friction the model is linear: likelihood by matrices, of exact discrete steps."""
    r, half, T, lag, masses, q, var = 0.09, 0.21, 0.02, 5e-4, (20.0, 1.1), (2.0, 0.4), (1e-6, 2e-6)
    rng, t = np.random.default_rng(2), np.arange(120) * T
    tau, seen = rng.normal(size=(120, 2)), np.cumsum(rng.normal(size=(120, 2)) * 2e-3, axis=0)
    none = dict.fromkeys(("Fc", "Fv", "c", "Mv", "s1", "s2", "delay"), 0.0)
    p = parameters(
        (r, half, 9.81, 0.01, T), **none, m=masses[0], I=masses[1], lag=lag, q1=q[0], q2=q[1]
    )
    log = Samples(t, seen, np.array(var), t, tau, np.array([0]))
    told = CompiledFilter(paper())(
        log, np.zeros((1, 8)), p, packed(np.array([*var, 0.5, 0.5, 0.0, 0.0])), slopes=False
    )

    whole, a = 0.0, expm(np.array([[0.0, 1.0], [0.0, 0.0]]) * T)
    forces = np.array([tau.sum(axis=1), half * (tau[:, 0] - tau[:, 1])]) / r
    for axis, force in enumerate(forces):
        b = np.array([T**2 / 2, T]) / masses[axis]
        x, covariance, late = np.zeros(2), np.diag([var[axis], 0.5]), 0.0
        for k, reading in enumerate(seen[:, axis]):
            if k:
                # The lag of half a millisecond: its mean over a period, as the filter has it.
                after = force[k - 1] + np.exp(-T / lag) * (late - force[k - 1])
                mean, late = force[k - 1] + lag * (late - after) / T, after
                x = a @ x + b * mean
                covariance = a @ covariance @ a.T + np.outer(b, b) * q[axis] ** 2
            s, e = covariance[0, 0] + var[axis], reading - x[0]
            whole += (e**2 / s + np.log(s)) / 2
            gain = covariance[:, 0] / s
            x, covariance = x + gain * e, covariance - np.outer(gain, covariance[0])
    # Pieces of 10 ms halve the noise's grain: its way is off by a quarter of b's square term.
    assert told.nll.sum() == pytest.approx(whole, rel=5e-3)


def test_scoring_ends_where_the_gradient_is_nothing(found):
    fit = found.white
    gradient = np.abs(fit.last.gradient.sum(axis=0)[fit.free])

    assert np.all(gradient <= 0.05 * np.sqrt(np.diag(fit.information())))
