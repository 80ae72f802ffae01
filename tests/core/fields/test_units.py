"""Usual sizes, units that may be meant, and digits."""

import pytest

from wmr_ctrl.core.fields.units import is_usual, length, meant, plain, rounded, written


def test_lengths_are_never_said_to_be_less_than_they_are_nor_what_is_free_more():
    assert (length(0.0072532), length(0.0072532, up=False)) == ("7.26 mm", "7.25 mm")
    assert (length(0.1392), length(0.1392, up=False)) == ("0.14 m", "0.139 m")
    assert length(0.1 + 0.2) == length(0.1 + 0.2, up=False) == "0.3 m"  # a double's own rounding
    assert (rounded(-0.0123, 2), rounded(-0.0123, 2, up=False)) == ("-0.012", "-0.013")
    assert (rounded(0.0, 2), rounded(float("inf"), 2)) == ("0", "inf")


def test_a_size_is_usual_within_its_range_and_nothing_is_meant_then():
    assert [is_usual(x, (0.1, 2.0)) for x in (0.1, -2.0, 0.0, float("inf"), 0.09, 2.1)] == [
        True, True, True, True, False, False,
    ]  # fmt: skip
    assert (written((0.0, 15.0)), written((0.003, 1.0))) == ("up to 15", "0.003 to 1")
    assert "500 mm is 0.5 m." in meant(500.0, "m", (0.1, 2.0))
    assert meant(5e9, "m", (0.1, 2.0)) == ""


@pytest.mark.parametrize(
    "value, text",
    [(1e-6, "0.000001"), (123456.0, "123456"), (9.9e-7, "9.9e-07"), (0.1 + 0.2, "0.3")],
)
def test_numbers_are_plain_for_sizes_that_a_robot_may_have(value, text):
    assert plain(value) == text
