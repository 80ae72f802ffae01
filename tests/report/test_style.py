"""Numbers, colours and units for readers."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from wmr_ctrl.report.style import colours_of, look, shown, unit_text


@pytest.mark.parametrize(
    "value, text",
    [
        (None, "–"),
        (0.0, "0"),
        (0.99986, "1.00"),
        (123456.0, "1.23·10⁵"),
        (21934.0, "21900"),
        (-0.0000123, "−1.23·10⁻⁵"),
        (-2.5, "−2.50"),
        (float("nan"), "–"),
    ],
)
def test_numbers_are_short(value, text):
    assert shown(value) == text


@given(st.floats(1e-300, 1e300))
def test_numbers_keep_three_digits(value):
    text = shown(value).replace("·10", "e").translate(str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789"))

    assert float(text) == pytest.approx(value, rel=5.1e-3)


def test_units_are_written_for_readers():
    assert unit_text("m2.s + rad2.s") == "m² s + rad² s"
    assert unit_text("1") == ""


def test_runs_of_one_law_are_told_apart():
    blue, other = colours_of(["mb", "mb"])
    reds, greens, blues = (
        abs(int(blue[at : at + 2], 16) - int(other[at : at + 2], 16)) for at in (1, 3, 5)
    )

    assert blue == look("mb").colour
    assert reds + greens + blues > 255
    assert look("pid").colour not in colours_of(["mb", "mb", "pid"])[:2]
    assert len(set(colours_of(["mb"] * 8))) == 8
