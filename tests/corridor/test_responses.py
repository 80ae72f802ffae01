"""Sums of a loop's responses, for a loop with known sums: x' = a x + b u."""

from itertools import product

import numpy as np
import pytest

from wmr_ctrl.theory.checks.error_coordinates import COMMAND, ROBOT
from wmr_proofs.corridor.responses import Responses, largest, stacked
from wmr_proofs.corridor.sample import OutputRows

A, N, SAMPLES, STEPS = -0.5, 3, 4, 2
RNG = np.random.default_rng(4)
LAW = 2
B = RNG.choice([-1.0, 1.0], (N, 1)) * RNG.uniform(0.2, 2.0, COMMAND + LAW + ROBOT)
"""Each input moves all three states as far, so that no norm is larger than a state."""
D = RNG.normal(size=(N, B.shape[1]))
LEFT = abs(A) ** SAMPLES
TAIL = LEFT / (1 - LEFT)
STEADY, NOW = RNG.normal(size=(2, N))
START, WITHIN = RNG.normal(size=(N, 2)), np.abs(RNG.normal(size=(N, STEPS)))
OWN = np.abs(RNG.normal(size=(N, STEPS)))


def near_above(found, least, spare=0.0):
    """Assert that bounds are never too small, and too large by rounding and ``spare`` at most."""
    assert (found >= least).all()
    assert (found <= (least + spare) * (1 + 1e-9) + 1e-9).all()


@pytest.fixture(scope="module")
def responses():
    powers = A ** np.arange(SAMPLES)
    every = np.hstack([np.eye(N), B])
    course = powers[:, None, None] * every
    steady = powers[:, None] * STEADY
    rest = np.abs(steady).max(axis=1).sum()
    sizes = np.abs(course).max(axis=1)
    backwards = np.arange(every.shape[1])[::-1]
    return Responses(
        course[..., ::-1], np.abs(powers).sum() * np.eye(N), np.abs(every), sizes, np.ones(N), LEFT,
        N, WITHIN, START, 1, 0, steady, np.abs(steady).sum(axis=0), rest, backwards,
    )  # fmt: skip


@pytest.fixture(scope="module")
def rows():
    push, law, measured = np.split(D, [COMMAND, COMMAND + LAW], axis=1)
    return OutputRows(np.eye(N), np.eye(N), push, law, np.zeros((N, 0)), measured, OWN)


@pytest.fixture(scope="module")
def gains(responses, rows):
    return responses.gains(rows, NOW)


def test_what_is_carried_from_sample_to_sample_adds_up_with_its_signs(responses, rows):
    """y' = T y + rows, from 0, against responses to single inputs of the test's own recursion."""
    turned = np.array([[1.0, 0.3, 0.0], [-0.3, 1.0, 0.0], [0.0, 0.0, 0.9]])
    each = list(responses.carried(rows, turned, NOW, 3))
    for count, found in enumerate(each, start=1):
        sums = np.zeros(B.shape)
        for column, ago in product(range(B.shape[1]), range(30)):
            x, y = np.zeros(N), np.zeros(N)
            for k in range(-30, count):
                u = float(k == count - 1 - ago)
                if k >= 0:
                    y = turned @ y + x + D[:, column] * u
                x = A * x + B[:, column] * u
            sums[:, column] += np.abs(y)
        own = sum(np.abs(np.linalg.matrix_power(turned, i)) for i in range(count))
        by = np.delete(found.by, COMMAND + LAW, axis=1)

        near_above(by, sums, TAIL * 2 * 3 * count**2 * np.abs(B))
        assert (found.steps >= own @ OWN).all()


def test_each_start_and_what_is_left_of_it_counts(gains):
    """The largest values are those of the first sample, with the norm that is left of the last."""
    unit = np.eye(N)
    course = np.cumsum([NOW, *(A**k * STEADY for k in range(60))], axis=0)

    near_above(gains.start, np.abs(START).sum(axis=1) + LEFT * np.abs(START).sum())
    near_above(gains.misled, np.hypot(unit[1], unit[2]) + 2 * LEFT)
    near_above(gains.before, unit[:, :COMMAND] + LEFT)
    near_above(gains.constant, np.abs(course).max(axis=0), 2 * TAIL * np.abs(STEADY).max())


def test_rows_stand_one_after_the_other_or_entry_by_entry(gains, responses, rows):
    other = responses.gains(rows, -2 * NOW)
    both, most = stacked([gains, other]), largest([gains, other])

    assert np.array_equal(both.constant, np.concatenate((gains.constant, other.constant)))
    assert np.array_equal(most.constant, np.maximum(gains.constant, other.constant))
    assert np.array_equal(most.by, gains.by)
    assert both.first[1].shape == (2 * N, gains.by.shape[1])
