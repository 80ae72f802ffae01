"""Lost velocities, and the reported age of the velocity in use."""

import pytest

from tests.papers_robot import paper
from wmr_ctrl.world.scenario import override
from wmr_ctrl.world.velocity_loss import VELOCITY_LOSS


def shown(system, sample, state, drawn=1.0):
    graph = system.function("shown", [system.y])
    return graph([0.3, 0.1, sample], state, system.p0, [drawn, 0.0]).full().ravel()


@pytest.mark.parametrize("old", [0, 1, 3])
def test_an_age_is_told_from_the_first_velocity_on_that_is_no_older_than_the_start(old):
    changes = {"base.kind": "velocity", "base.tau": [0.1, 0.1], "sensor.velocity_age": old * 0.01}
    system = VELOCITY_LOSS.build(override(paper(), changes))

    ages = [shown(system, k, [0.0] * 3)[2] for k in range(6)]

    assert ages == pytest.approx([-1.0] * old + [old * 0.01] * (6 - old))


def test_what_is_lost_leaves_the_last_that_came_but_not_too_often_in_a_row():
    scenario = override(paper(), {"sensor.velocity_losses": 2})
    system = VELOCITY_LOSS.build(scenario)

    assert shown(system, 7, [0.5, 0.6, 1.0], -0.1) == pytest.approx([0.5, 0.6, 0.02])
    assert shown(system, 7, [0.5, 0.6, 2.0], -0.1) == pytest.approx([0.3, 0.1, 0.0])
    assert shown(system, 0, [0.5, 0.6, 0.0], -0.1) == pytest.approx([0.3, 0.1, 0.0])
    assert "velocity_losses = 2" in VELOCITY_LOSS.bounded(scenario).void
