"""Warnings about the reference and the kinematic gains."""

import pytest


def test_too_fast_reference_names_the_lag_that_it_ends_in(told):
    (warning,) = told("mb", scenario="fast-reference", key="reference")

    assert "reaches 0.9 m/s" in warning.sentence
    assert "about 1 m behind" in warning.sentence


def test_reference_at_the_threshold_is_too_fast(told):
    line = {"reference.kind": "line", "reference.speed": 0.8}

    assert len(told("mb", line, key="reference")) == 1


def test_reference_just_below_the_threshold_is_fine(told):
    line = {"reference.kind": "line", "reference.speed": 0.79}

    assert told("mb", line, key="reference") == []


def test_reference_beyond_the_limit_cannot_be_followed(told):
    line = {"reference.kind": "line", "reference.speed": 1.2}
    (warning,) = told("mb", line, key="reference")

    assert "may not drive that fast" in warning.sentence


def test_reference_that_turns_too_fast_winds_up(told):
    circle = {"reference.radius": 0.1, "reference.rate": 1.4}
    (warning,) = told("mb", circle, key="reference")

    assert "1.4 rad/s" in warning.sentence
    assert "wind up" in warning.sentence


@pytest.mark.parametrize(
    ("overrides", "words"),
    [
        ({"reference.kind": "stop-and-go"}, "stands still"),
        ({"reference.kind": "line", "reference.speed": 0}, "stands still"),
        ({"reference.rate": -0.1}, "backwards"),
    ],
)
def test_reference_that_does_not_move_forwards(told, overrides, words):
    (warning,) = told("nn", overrides, key="reference")

    assert words in warning.sentence


@pytest.mark.parametrize("speed", [1e-3, 0.05])
def test_a_slow_reference_moves_forwards(told, speed):
    line = {"reference.kind": "line", "reference.speed": speed}

    assert told("nn", line, key="reference") == []


def test_second_kinematic_gain_below_one(told):
    (warning,) = told("mb", {"gains.kinematics.k": (10, 0.5, 4)}, key="gains.kinematics.k")

    assert "k[2] = 0.5 is below 1" in warning.sentence


@pytest.mark.parametrize("kind", ["circle", "line", "lemniscate"])
@pytest.mark.slow_but("circle", "lemniscate")
def test_default_references_keep_the_preconditions(told, kind):
    assert told("mb", {"reference.kind": kind}, key="reference") == []
