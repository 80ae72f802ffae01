"""What bounds by axis give back, as `benchmarks/axes.py` counts it."""

import pytest

from benchmarks.axes import CASES, rows


@pytest.mark.slow
def test_bounds_by_axis_give_back_what_the_other_axis_cost():
    found = {name: (limit, both, apart) for name, limit, both, apart in rows()}
    assert list(found) == list(CASES)
    assert list(found.values()) == [
        pytest.approx(row, abs=1e-3)
        for row in (
            (0.3, 0.1686, 0.29),
            (2.0, 1.3, 1.857),
            (1.0, 0.95 * 0.95 / 1.5, 0.95 * 0.95 / 1.05),
            (1.0, 0.863, 0.951),
            (1.0, 0.797, 0.911),
            (1.0, 0.890, 0.952),
        )
    ]
