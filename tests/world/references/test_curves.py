"""References in closed form, against their twins in plain Python."""

import numpy as np
import pytest

from tests.oracle.references import reference_of
from tests.papers_robot import paper
from wmr_ctrl.world.references import StopAndGo, sample
from wmr_ctrl.world.references.curves import Circle, Lemniscate, Line


@pytest.mark.parametrize(
    "kind",
    [
        Circle(radius=2.0, rate=0.5),
        Line(speed=0.2, heading=0.3, origin=(1.0, -1.0)),
        Lemniscate(size=1.5, rate=0.5),
        StopAndGo(radius=2.0, speed=0.4, period=10.0),
    ],
    ids=str,
)
def test_a_curve_is_its_twin(kind):
    times = np.random.default_rng(0).uniform(0, 30, 50)
    twin = [list(reference_of(kind)(t).columns().values()) for t in times.tolist()]

    assert sample(paper(reference=kind), times) == pytest.approx(np.array(twin), abs=1e-12)
