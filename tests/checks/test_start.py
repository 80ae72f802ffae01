"""Warnings about where the run starts."""

import pytest

from tests.tables import cases, changes

AXES = (
    "initial.velocity[1] = 1.3 m/s is outside limits.v_u1[1] = 1",
    "initial.velocity[2] = 2 rad/s is outside limits.v_u1[2] = 1.5",
)
FAR = "|v1| = 7.17 m/s (limit 1) and |omega| = 3.02 rad/s (limit 1.5)"


def assert_told(found, *said):
    assert len(found) == len(said)
    assert all(words in item.sentence for words, item in zip(said, found, strict=True))


@pytest.mark.parametrize("law", ["pid", "smc", "mb", "nn"])
def test_a_start_beyond_the_limit_is_told_per_axis(told, law):
    assert_told(told(law, {}, scenario="outside-start", key="initial.velocity"), *AXES)


@pytest.mark.parametrize(
    "law, v1, omega, said",
    cases("""
        mb | -1.3 | 0.0 | is outside
        mb | -0.9999995 | 0.0 | within limits.clip
        mb | 0.9999995 | 0.0 | within limits.clip
        mb | 1.0 | 0.0 | limits.v_u1[1]
        mb | 0.9999999 | 0.0 | 0.9999999 m/s is within limits.clip
        pid | 1.0 | 1.5 | -
        mb | 0.0 | 0.0 | -
        mb | 0.95 | 0.0 | -
        mb | -0.99999 | 0.0 | -
    """),
)
def test_a_start_at_or_near_the_limit_is_told(told, law, v1, omega, said):
    found = told(law, {"initial.velocity": [float(v1), float(omega)]}, key="initial.velocity")

    assert_told(found, *([said] if said != "-" else []))


def test_a_guard_brings_back_what_starts_outside(told):
    found = told("mb", {"guard.enabled": True}, scenario="outside-start", key="initial.velocity")

    assert_told(found, "only the guard brings it back", "")


def test_start_exactly_at_the_limit_is_not_outside_it(told):
    """The promise |v| <= v_u1 includes equality."""
    (warning,) = told("mb", {"initial.velocity": [1.0, -1.0]}, key="initial.velocity")

    assert "outside" not in warning.sentence


@pytest.mark.parametrize(
    "law, set_, told_of",
    [
        ("pid", "", True), ("smc", "", True), ("mb", "", False), ("nn", "", False),
        ("pid", "initial.pose = [0.0, 0.0, -1.57]", False), ("pid", "guard.enabled = true", False),
    ],
)  # fmt: skip
def test_laws_that_ignore_the_limit_are_told_apart(told, law, set_, told_of):
    assert_told(told(law, changes(set_), key="law"), *([FAR] if told_of else []))
