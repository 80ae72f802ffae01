"""The main job with the real engine."""

from __future__ import annotations

import pytest

pytestmark = pytest.mark.slow


@pytest.mark.parametrize("seeds", [1, 2])
def test_the_verdicts_are_the_committed_ones_for_any_number_of_seeds(tmp_path, seeds):
    from wmr_ctrl.api import reproduce

    verdicts = reproduce(tmp_path / "out", seeds=seeds)

    assert verdicts.changed == ()
    assert verdicts.ok
    assert verdicts.report.stat().st_size < 8_000_000
