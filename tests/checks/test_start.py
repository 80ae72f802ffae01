"""Warnings about where the run starts."""

import pytest


@pytest.mark.parametrize("law", ["pid", "smc", "mb", "nn"])
def test_start_outside_the_limit_is_told_per_axis(told, law):
    first, second = told(law, scenario="outside-start", key="initial.velocity")

    assert "initial.velocity[1] = 1.3 m/s is outside limits.v_u1[1] = 1" in first.sentence
    assert "initial.velocity[2] = 2 rad/s is outside limits.v_u1[2] = 1.5" in second.sentence


@pytest.mark.parametrize("v1", [-1.3, -1 + 5e-7, 1 - 5e-7, 1.0])
def test_start_at_or_beyond_the_limit_in_either_direction(told, v1):
    assert len(told("mb", {"initial.velocity": (v1, 0)}, key="initial.velocity")) == 1


def test_start_exactly_at_the_limit_is_not_outside_it(told):
    """|v| <= v_u1 is what is promised, with equality."""
    (warning,) = told("mb", {"initial.velocity": (1.0, -1.0)}, key="initial.velocity")

    assert "outside" not in warning.sentence
    assert told("pid", {"initial.velocity": (1.0, 1.5)}, key="initial.velocity") == []


@pytest.mark.parametrize("v1", [0.0, 0.95, -0.99999])
def test_start_inside_is_not_objected_to(told, v1):
    assert told("mb", {"initial.velocity": (v1, 0)}, key="initial.velocity") == []


def test_start_in_the_last_millionth_is_shown_with_all_its_digits(told):
    (warning,) = told("mb", {"initial.velocity": (0.9999999, 0)}, key="initial.velocity")

    assert "0.9999999 m/s is within limits.clip" in warning.sentence


@pytest.mark.parametrize("law", ["pid", "smc"])
def test_laws_that_ignore_the_limit_are_told_apart(told, law):
    (warning,) = told(law, key="law")

    assert "|v1| = 7.17 m/s (limit 1) and |omega| = 3.02 rad/s (limit 1.5)" in warning.sentence


@pytest.mark.parametrize("law", ["mb", "nn"])
def test_barrier_laws_know_the_limit(told, law):
    assert told(law, key="law") == []


def test_laws_that_ignore_the_limit_are_fine_near_the_reference(told):
    near = {"initial.pose": (0.0, 0.0, -1.57)}

    assert told("pid", near, key="law") == []


def test_guard_brings_back_what_starts_outside(told):
    guarded = {"guard.enabled": True}
    first, _ = told("mb", guarded, scenario="outside-start", key="initial.velocity")

    assert "only the guard brings it back" in first.sentence


def test_guard_makes_up_for_a_law_that_ignores_the_limit(told):
    assert told("pid", {"guard.enabled": True}, key="law") == []
