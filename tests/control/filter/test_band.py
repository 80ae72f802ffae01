"""The band filter: its tables against step responses, and the cases that it refuses."""

import itertools
from functools import cache

import casadi as ca
import numpy as np
import pytest
from scipy.signal import lti, step

from tests.control.filter.test_peak_gain import LOOP, scenario
from tests.tables import cases, changes
from wmr_ctrl import command_filter
from wmr_ctrl.control.filter.band import MOST_COMMANDS, PIECES, response_table
from wmr_ctrl.control.filter.step_response import band, pi_cells, second_order_cells
from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.world.scenario import override

T = 0.05


@cache
def banded():
    return command_filter(scenario(kind="band", push=(0.0, 0.0)))


def test_a_stop_is_never_held_back():
    rng, limit = np.random.default_rng(5), banded()
    limit.start()
    for _ in range(300):
        asked = tuple(rng.choice([-9.0, 0.0, 9.0], 2))
        sent = limit.step(asked).command
        assert all(s == 0 for s, r in zip(sent, asked, strict=True) if r == 0)
    assert limit.step((0.0, 0.0)).command == (0.0, 0.0)


def test_opposite_commands_are_sent_opposite():
    asked = np.random.default_rng(6).uniform(-4, 4, (60, 2))
    sent = []
    for way in (1, -1):
        banded().start()
        sent.append([banded().step(tuple(way * r)).command for r in asked])
    assert np.array_equal(np.array(sent[0]), -np.array(sent[1]))


@pytest.mark.parametrize(
    "cells, members",
    [
        (pi_cells(LOOP), [([kp, ki], [M, kp + c, ki]) for M, kp, ki, c in
                          itertools.product((50, 57, 65), (135, 165), (270, 330), (0, 7, 20))]),
        (second_order_cells((3.0, 5.0), (0.4, 1.4)), [([w * w], [1, 2 * z * w, w * w]) for w, z in
                                   itertools.product((3, 3.7, 5), (0.4, 0.8, 1.0, 1.4))]),
    ],
)  # fmt: skip
@pytest.mark.slow
def test_tables_hold_every_step_response_and_little_more(cells, members):
    known = band(cells, T, PIECES, MOST_COMMANDS)
    t = np.arange(4 * len(known.low) + 1) * T / PIECES / 4
    all_of = np.array([step(lti(*member), T=t)[1] for member in members])
    pieces = np.stack([all_of[:, k : k + len(t) - 1 : 4] for k in range(5)])
    assert (pieces.max(axis=(0, 1)) <= known.high + 1e-9).all()
    assert (pieces.min(axis=(0, 1)) >= known.low - 1e-9).all()
    assert (known.high - pieces.max(axis=(0, 1))).max() < 0.05
    assert known.high.max() <= 5  # `filter.rounding.band`
    fine = np.arange(2 * len(t)) * t[1]
    behind = np.array([step(lti(*m), T=fine)[1] for m in members])[:, len(t) - 1 :]
    later = fine[len(t) - 1 :] - t[-1]
    assert (abs(behind - 1) <= known.left * np.exp(-known.rate * later) + 1e-9).all()


def test_the_graph_s_table_is_that_of_the_family_rounded_outward():
    known = band(second_order_cells((4.0, 5.0), (0.9, 1.0)), T, PIECES, MOST_COMMANDS)
    table = response_table(known)
    for bound, exact in ((table.above, known.high - 1), (table.below, 1 - known.low)):
        found = ca.evalf(bound).full().ravel()
        assert (found >= exact).all()
        assert found == pytest.approx(exact, abs=1e-12)


@pytest.mark.parametrize(
    "stated, words",
    cases("""
        filter.loop = first-order       | for loops that overshoot
        filter.losses = 1               | filter.losses: .*a constant delay after
        filter.jitter = 0.013           | at most a quarter of
        filter.hold = 0.5               | filter.hold
        filter.delay = [0, 0.02]        | filter.delay
        filter.odometry = [0.1, 0.1]    | from its own commands
        filter.loop = second-order; filter.damping = [0.5, 1]  | filter.frequency is missing
        filter.kp = [135, 3000]; filter.friction = [0, 0]      | may still be  | slow
    """),
)
def test_what_a_band_does_not_cover_is_refused_by_name(stated, words):
    with pytest.raises(ScenarioError, match=words):
        command_filter(override(scenario(kind="band"), changes(stated)))


@pytest.mark.slow
def test_a_family_that_leaves_more_than_a_fifth_behind_the_tables_is_refused():
    """(1 + w t) exp(-w t) is 0.22 after 128 periods, and the bound is above that."""
    slow = {"kind": "band", "loop": "second-order", "frequency": (0.45, 0.6), "damping": (1.0, 1.2),
            "push": (0.0, 0.0)}  # fmt: skip
    with pytest.raises(ScenarioError, match=r"off its final value by 0\.[2-4]\d* times that"):
        command_filter(scenario(**slow))
    with pytest.raises(ScenarioError, match="off its final value by any amount, and the band"):
        command_filter(scenario(**slow | {"frequency": (0.01, 10.0)}))
