"""Verdicts, mixtures and seconds: what a log tells of its parameters, from information alone."""

import numpy as np
import pytest

from wmr_ctrl.identification.bounds import informative_seconds, mixtures, sizes, verdict
from wmr_ctrl.identification.fit import errors_of
from wmr_ctrl.identification.kalman import BLOCKS

STUDENT = 2.1448
"""97.5 % of Student's distribution with 14 degrees of freedom, by tables."""


@pytest.mark.parametrize(
    "share, word",
    [(0.1, "determined"), (0.11, "roughly"), (0.3, "roughly"), (0.31, "undetermined")],
)
def test_a_tenth_is_determined_and_three_tenths_are_so_roughly(share, word):
    assert verdict(share) == word


@pytest.mark.parametrize(
    "names, said",
    [
        (("delay", "lag"), "torques changed too slowly or too little"),
        (("Fc", "Fv"), "the log knows one speed"),
        (("m", "delay"), "the robot hardly accelerated"),
        (("m", "Mv"), "by this log"),
    ],
)
def test_what_the_log_cannot_tell_apart_is_named_with_what_it_lacks(names, said):
    near, apart = (np.array([[4.0, 6 * c], [6 * c, 9.0]]) for c in (0.99, 0.9))

    assert [said in text for text in mixtures(names, near, {names[0]})] == [True]
    assert list(mixtures(names, near, set())) == []
    assert list(mixtures(names, apart, set(names))) == []


def test_half_of_the_information_is_where_it_is():
    share, t = np.full(BLOCKS, 0.1 / BLOCKS), np.array([5.0, 5.0 + BLOCKS])
    share[3] = 1.0

    assert informative_seconds(t, share) == (pytest.approx(8.0), pytest.approx(9.0))
    low, high = informative_seconds(t, np.ones(BLOCKS))
    assert high - low == pytest.approx(np.ceil(BLOCKS / 2))


def test_friction_is_compared_with_a_quarter_of_all_of_it_and_times_with_a_period():
    values = {"m": 9.0, "Fc": 4.0, "c": 1.0, "Fv": 4.0, "Mv": 0.0, "delay": 0.0, "lag": 0.5}

    found = sizes(values, np.array([0.5, 2.0]), 0.02)

    friction = 4.0 + 2 * 1.0 + 4.0 * 0.5
    assert found == pytest.approx(
        {"m": 9.0, "Fc": 4.0, "c": 1.0, "Fv": 4.0, "Mv": 0.1 / 2, "delay": 0.02, "lag": 0.5}
    )
    few = sizes(values | {"Fc": 0.0, "c": 0.0, "Fv": 0.0}, np.array([0.5, 2.0]), 0.02)
    some = sizes(values | {"Fc": 0.0, "Fv": 0.0}, np.array([0.5, 2.0]), 0.02)
    assert sizes(values | {"Fc": 1e-9}, np.array([0.5, 2.0]), 0.02)["Fc"] == pytest.approx(
        (friction - 4.0) / 4
    )
    assert (few["Fc"], some["Fv"]) == (0.0, pytest.approx(2.0 / 4 / 0.5))


def test_intervals_of_a_mean_are_those_of_student_where_blocks_scatter_and_fishers_else():
    """Of a constant in white noise: the information is the count, and a block left out moves it."""
    rng, count = np.random.default_rng(1), 40
    free = np.array([True])
    data = rng.normal(size=(BLOCKS, count))
    data -= data.mean()
    gradient, fisher = data.sum(axis=1)[:, None], np.full((BLOCKS, 1, 1), float(count))

    without = np.array([np.delete(data, b, axis=0).mean() for b in range(BLOCKS)])
    jackknife = np.sqrt((BLOCKS - 1) / BLOCKS * ((without - without.mean()) ** 2).sum())
    by_fisher = [1.96 / np.sqrt(BLOCKS * count)]
    assert errors_of(0 * gradient, fisher, free) == pytest.approx(by_fisher, rel=1e-3)
    assert errors_of(gradient, fisher, free) == pytest.approx(
        np.maximum(by_fisher, STUDENT * jackknife), rel=1e-3
    )
    assert errors_of(10 * gradient, fisher, free) == pytest.approx(
        [10 * STUDENT * jackknife], rel=1e-3
    )
