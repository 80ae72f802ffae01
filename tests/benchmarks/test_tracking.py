"""The page of tracking: its parts are whole, and say what the sentences around them claim."""

import pytest

from benchmarks import front, tracking
from benchmarks.parts import renew
from tests.benchmarks.pages import RESULTS, table
from wmr_ctrl.control.laws.registry import NAMES
from wmr_ctrl.core.errors import ArgumentError


def test_every_law_has_a_row_at_every_period():
    named = [row[0] for row in table(RESULTS, tracking.NAME)[1:] if row[0] != "law"]

    assert named == list(NAMES) * len(tracking.PLACES)


def test_both_laws_are_on_one_front():
    """The product of RMS and torque change of prox is at most 5 % above that of kanayama."""
    found = [row[5] for row in table(RESULTS, front.NAME)[1:] if row[1] == "prox"]

    assert len(found) == len(front.CASES)
    assert all(float(ratio) <= 1.05 for cell in found for ratio in cell.split(","))


def test_both_are_stable_for_masses_of_0_6_to_1_6_times_the_believed_one():
    for row in table(RESULTS, front.NAME)[1:]:
        low, high = map(float, row[6].split(" to "))
        assert low <= 0.6
        assert high >= 1.6


def test_a_part_of_a_page_is_renewed_and_nothing_else(tmp_path):
    page = tmp_path / "a.md"
    page.write_text("one\n<!-- begin x -->\nold\n<!-- end x -->\ntwo\n", "utf-8")
    renew(page, "x", "new")

    assert page.read_text("utf-8") == ("one\n<!-- begin x -->\n\nnew\n\n<!-- end x -->\ntwo\n")
    with pytest.raises(ArgumentError, match="begin y"):
        renew(page, "y", "new")
