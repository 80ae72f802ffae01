"""Verdicts, mixtures and informative seconds of a log's parameters, from information alone."""

import numpy as np
import pytest

from wmr_ctrl.identification.bounds import informative_seconds, mixtures, sizes, verdict
from wmr_ctrl.identification.kalman import BLOCKS


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


@pytest.mark.parametrize(
    "changed, key, size",
    [
        ({}, "Fc", 4.0),
        ({}, "Mv", 0.1 / 2),
        ({}, "delay", 0.02),
        ({}, "lag", 0.5),
        ({"Fc": 0.0, "c": 0.0, "Fv": 0.0}, "Fc", 0.0),
        ({"Fc": 0.0, "Fv": 0.0}, "Fv", 2.0 / 4 / 0.5),
        ({"Fc": 1e-9}, "Fc", (2 * 1.0 + 4.0 * 0.5) / 4),
    ],
)
def test_friction_is_compared_with_a_quarter_of_all_of_it_and_times_with_a_period(
    changed, key, size
):
    values = {"m": 9.0, "Fc": 4.0, "c": 1.0, "Fv": 4.0, "Mv": 0.0, "delay": 0.0, "lag": 0.5}

    assert sizes(values | changed, np.array([0.5, 2.0]), 0.02)[key] == pytest.approx(size)
