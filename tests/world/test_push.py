"""The push of an adversary."""

import pytest

from tests.papers_robot import paper
from wmr_ctrl.world.push import PUSH
from wmr_ctrl.world.scenario import override


def test_at_rest_the_adversary_pushes_forward():
    scenario = override(paper(), {"disturbance.push": [8.0, 2.0]})
    system = PUSH.build(scenario)
    shown = system.function("shown", [system.y])

    for v, omega, force in ((0.0, 0.0, (8.0, 2.0)), (-0.1, 0.0, (-8.0, 2.0)), (0.2, -1, (8, -2))):
        right, left = shown([v, omega], [], system.p0).full().ravel()
        assert ((right + left) / 0.1, 0.25 * (right - left) / 0.1) == pytest.approx(force)
    assert PUSH.bounded(scenario).dbar == (8.0, 2.0)
