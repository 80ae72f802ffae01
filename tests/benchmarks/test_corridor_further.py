"""The page's table of further adversaries is what its command makes today."""

import pytest

from benchmarks.corridor_cases import ROWS
from benchmarks.corridor_further import FIFTH, FINE, HEAD, NAME, row
from tests.benchmarks.pages import RESULTS, cells, table

RUN_AGAIN = (
    "the same, acceleration limited to 0.5 m/s2 and 3 rad/s2",
    "kanayama, acceleration limited, poses off by 0.2 mm an axis",
    "the same, jitter of 2 ms in its place",
)
"""Rows that take seconds."""
LAST = 0.011
"""The last digit of a length [mm] or a ratio may be another one elsewhere."""


def shown():
    head, *rows = table(RESULTS, NAME)
    assert tuple(head) == HEAD
    return {words: others for words, *others in rows}


def test_the_page_has_all_rows_and_none_contradicts_itself():
    found = shown()

    assert list(found) == list(ROWS)
    for certified, reached, ratio, beyond, left, times in found.values():
        assert float(reached) <= float(certified)
        least, most = float(certified) - LAST, float(certified)  # rounded up
        half = LAST / 2
        assert least / (float(reached) + half) - half < float(ratio)
        assert float(ratio) < most / (float(reached) - half) + half
        assert (left == "yes") == (float(times) <= FIFTH)
        assert float(beyond) > least if left == "yes" else float(beyond) <= most


@pytest.mark.slow
@pytest.mark.parametrize("words", RUN_AGAIN)
def test_a_row_is_reproduced(words):
    _, *made = cells(row(words))
    *numbers, left, times = shown()[words]

    assert [float(x) for x in made[:-2]] == pytest.approx([float(x) for x in numbers], abs=LAST)
    assert made[-2] == left
    assert float(made[-1]) == pytest.approx(float(times), abs=FINE + 1e-9)
