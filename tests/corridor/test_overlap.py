"""Overlap of commands behind a ramp, against a ramp of the tests' own."""

import numpy as np
import pytest

from tests.corridor.further import burger
from wmr_proofs.corridor.overlap import ROOM, ramp_overlap

RAMP = "base.accel = [0.5, 4.0]; base.decel = [1.0, 3.0]; clock.control = 0.1; clock.plant = 0.01"


def ramped(now, to, grow, shrink):
    """The command after a plant step, which stops at 0 on its way to the other sign."""
    if now * (to - now) >= 0:
        return now + np.clip(to - now, -grow, grow)
    after = now + np.clip(to - now, -shrink, shrink)
    return after if after * now >= 0 else 0.0


@pytest.mark.parametrize("heard", [0.0, 0.002])
@pytest.mark.parametrize("changes", [(0.0, 0.01), (0.005, 0.05), (1.0, 1.0)])
def test_a_ramp_leaves_no_more_of_a_change_than_its_overlap(changes, heard):
    scenario = burger(RAMP, {"base.deadband": [heard / 2] * 2})
    overlap, rng = ramp_overlap(scenario, np.array(changes)), np.random.default_rng(1)
    times = np.array(scenario.clock.substeps - 1)
    off = np.vstack([overlap.off, np.zeros((times + 1 - overlap.steps, 2))])
    rates = 0.01 * np.array([scenario.base.accel, scenario.base.decel])
    for axis in (0, 1):
        grow, shrink = rates[:, axis]
        for _ in range(200):
            change = rng.uniform(-1, 1) * (overlap.most[axis] + heard)
            first = now = rng.uniform(-1, 1) * abs(change) * 2
            for left in off[:, axis]:
                now = ramped(now, first + change, grow, shrink)
                assert abs(first + change - now) <= left * abs(change) + 1e-12

    least = rates.min(axis=0)
    room = np.minimum(ROOM * np.array(changes), times * least - heard)
    assert (room * (1 - 1e-9) <= overlap.most).all()
    assert (overlap.most <= room + 2 * least).all()


def test_a_ramp_slower_than_a_dead_band_is_for_no_change():
    slow = burger(RAMP, "base.accel = [1e-3, 1e-3]; base.deadband = [0.1, 0.1]")

    assert not ramp_overlap(slow, np.zeros(2)).most.any()
