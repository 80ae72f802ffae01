"""Widths of intervals, a guard's numbers from them, and the rows of a log that count, by hand."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from tests.papers_robot import paper
from wmr_ctrl.identification import fit as fitting
from wmr_ctrl.identification.fit import LogProblem, errors_of, intervals_of, plant_step
from wmr_ctrl.identification.kalman import LOGARITHMIC, NAMES
from wmr_ctrl.identification.logs.log import of_columns
from wmr_ctrl.identification.logs.samples import Samples, motion_of
from wmr_ctrl.identification.refuted import guard_bounds, usable_speeds
from wmr_ctrl.world.scenario import load_scenario, override

T_14 = 2.1448
"""Student's t of 14 degrees of freedom at 0.975; at 0.9875 it is 2.5096."""


def seen_at(*times, first=(0,)):
    t, none = np.array(times), np.zeros((len(times), 2))
    return Samples(t, none, np.zeros(2), t, none, np.array(first))


@pytest.mark.parametrize("gradient", [0.0, 0.2, 4.0])
def test_a_half_width_is_the_larger_of_that_by_fisher_and_that_by_blocks(gradient):
    """15 blocks with information 1 and gradients of alternating g and -g, so their mean is g/15."""
    g = gradient * np.array([(-1.0) ** k for k in range(15)])
    by_blocks = math.sqrt(14 / 15 * np.sum((g - g.mean()) ** 2)) / 14
    found = errors_of(g[:, None], np.ones((15, 1, 1)), np.array([True]))

    assert found[0] == pytest.approx(max(T_14 * by_blocks, 1.96 / math.sqrt(15)), rel=1e-4)


def test_no_interval_is_narrower_than_a_step_of_the_plant(monkeypatch):
    theta = np.array([math.log(2.0) if n in LOGARITHMIC else 2.0 for n in NAMES])
    problem = SimpleNamespace(log=SimpleNamespace(period=0.01))
    monkeypatch.setattr(fitting, "half_widths", lambda _: np.zeros(len(NAMES)))
    found = intervals_of(SimpleNamespace(theta=theta, problem=problem))

    for name, (value, low, high) in found.items():
        half = plant_step(0.01) / 2 if name in ("delay", "lag") else 0.004
        assert value == pytest.approx(2.0)
        assert (low, high) == pytest.approx((2 - half, 2 + half), abs=1e-5)


def test_the_first_three_tenths_of_a_second_of_a_stretch_do_not_count():
    problem = LogProblem(seen_at(0, 0.29, 0.31, 9, 9.29, 9.31, first=(0, 3)), None, np.zeros(0))

    assert problem.counts.tolist() == [False, False, True] * 2


@pytest.mark.parametrize("steps, first", [(4.9, [0]), (5.1, [0, 50])])
def test_a_stretch_begins_after_five_steps_without_a_row(steps, first):
    t = 0.01 * np.arange(100.0)
    t[50:] += 0.01 * (steps - 1)
    names = ("v1_measured", "omega_measured", "tau_right", "tau_left")
    log = of_columns("log", {"t": t.tolist(), **{name: t.tolist() for name in names}})

    assert motion_of(log, paper(), "v1_measured").first.tolist() == first


def white_fit(period, duration=60.0):
    """Noise of 2 N and 3 N m; residuals up to 4.5 and 1 standard deviations, and up to 9 in unused
    rows.

    Speeds up to 0.5 m/s and 2 rad/s.
    """
    log = seen_at(*np.arange(0.0, duration + period / 2, period))
    sizes = np.array([[9.0, 9.0], *[[-4.5, 1.0]] * (len(log.t) - 1)])
    counts = np.arange(len(log.t)) > 0
    mean = np.array([[0, 0, -0.5, 2.0]])
    problem = SimpleNamespace(log=log, counts=counts)
    last = SimpleNamespace(sizes=sizes, mean=mean)
    theta = np.where(np.array(NAMES) == "q1", math.log(2.0), math.log(3.0))
    return SimpleNamespace(theta=theta, problem=problem, last=last)


@pytest.mark.parametrize(
    "delay, late, wide",
    [
        ((-0.001, 0.004), (0.0, 0.010), False),
        ((0.020, 0.025), (0.020, 0.030), False),
        ((0.020, 0.035), (0.020, 0.035), True),
    ],
)
def test_a_guard_stands_wider_masses_larger_pushes_and_creeping_tread(delay, late, wide):
    low, high = delay
    intervals = {
        "m": (10.0, 8.0, 12.0), "I": (1.0, 0.5, 3.0), "delay": ((low + high) / 2, low, high),
        "lag": (0.002, -0.001, 0.005),
    }  # fmt: skip
    counted = override(paper(), {"encoder.counts": 4000})
    found = guard_bounds(white_fit(0.01), intervals, counted)
    power = 2.5096 / T_14

    assert found.masses[0] == pytest.approx((10 * 0.8**power, 10 * 1.2**power), rel=1e-3)
    assert found.masses[1] == pytest.approx((0.5**power, 3**power), rel=1e-3)
    assert found.dbar == pytest.approx((2 * 4.5, 3 * 3.0))
    assert found.delay == pytest.approx(late)
    assert found.lag == pytest.approx((0.0, 0.010))
    assert found.wide == wide
    assert "in 60 s, at speeds up to 0.5 m/s and 2 rad/s" in found.sentence


def test_one_more_newton_costs_speed():
    one, other = (
        load_scenario(
            "paper-simulation-nominal", {"guard.enabled": True, "guard.dbar": [push, 0.5]}
        )
        for push in (2.0, 3.0)
    )
    (now, price), (then, _) = usable_speeds(one), usable_speeds(other)

    assert price > 0
    assert price == pytest.approx(now - then)
