"""The transcribed approach rule: commands scaled by the time that is left before a collision."""

import numpy as np
import pytest

from tests.export.page.walled import walled
from wmr_ctrl.control.controller import law_graph
from wmr_ctrl.control.laws import LAWS
from wmr_ctrl.export.page.approach import HORIZON, approaching
from wmr_ctrl.export.page.scenes import members_of
from wmr_ctrl.world.model.system import values

EAST = -np.pi / 2
"""Orientation that looks along +X, counted from +Y."""


def commanded(member, x, theta, v_d):
    """Output of a robot's law on the line, at x [m], for a desired speed [m/s]."""
    setup = member.settled(walled())
    system = law_graph(setup)
    known = {"x_d": x, "theta_d": theta, "v1_d": v_d, "x": x, "theta": theta}
    inputs = np.hstack(
        [[known.get(item.signal.name, 0.0)] * item.signal.size for item in system.inputs]
    )
    p = [number for item in system.params for number in setup.value(item.signal.name)]
    law = system.function("law", [system.y])
    return law(inputs, values(system.state), p).full().ravel()


@pytest.mark.parametrize("speed, x", [(0.8, 0.0), (0.8, 2.0), (0.8, 2.5), (0.8, 2.76), (-0.5, 2.7)])
def test_a_command_leaves_a_horizon_to_the_wall(speed, x):
    clipped, approach, _ = members_of(walled(), ["kanayama"])
    way = np.inf if speed < 0 else max(3.0 - 0.25 - x, 0.0)
    asked = commanded(clipped, x, EAST, speed)

    assert asked[0] == pytest.approx(speed)
    share = min(1.0, way / (HORIZON * abs(speed)))
    assert commanded(approach, x, EAST, speed) == pytest.approx(share * asked, abs=1e-9)


def test_a_law_behind_the_rule_is_made_once_and_keeps_its_name():
    law = LAWS["kanayama"]

    assert approaching(law) is approaching(law)
    assert approaching(law) != law
    assert approaching(law).name == law.name
