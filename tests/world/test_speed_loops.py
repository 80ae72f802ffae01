"""Speed loops of both axes, joined."""

import pytest

from tests.world.motion import based
from wmr_ctrl.world.scenario import override
from wmr_ctrl.world.speed_loops import SPEED_LOOP, assumed_lags, loops_of


def forced(scenario, given, state):
    """Thrust [N] and moment [N m] of the wheels' torques, and the next state."""
    system = SPEED_LOOP.build(scenario)
    step = system.function("step", [system.y, system.update])
    torque, after = (part.full().ravel() for part in step(given, state, system.p0))
    right, left = torque
    return ((right + left) / 0.1, 0.25 * (right - left) / 0.1), after


@pytest.mark.parametrize("most, force", [(1e6, (8.0, 0.5)), (0.4, (7.0, 0.25))])
def test_each_wheel_gives_no_more_than_its_limit(most, force):
    """8 N and 0.5 N m are 0.5 N m and 0.3 N m at wheels of 0.1 m, 0.25 m from the middle."""
    gains = {"loop": "pi", "kp": 80.0, "ki": 0.0}
    limited = override(based(**gains), {"actuator.tau_max": most})
    exerted, after = forced(limited, [0.1, 0.1, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0])

    assert exerted == pytest.approx(force)
    assert after[:2] == pytest.approx([min(0.5, most), 0.3])


def test_laws_assume_the_lag_of_each_axis_unless_it_is_stated():
    mixed = based(loop=["first-order", "pi"], tau=[0.2, 0.3], kp=150.0, ki=300.0)

    assert [loop.overshoots for loop in loops_of(mixed)] == [False, True]
    assert assumed_lags(mixed) == pytest.approx([0.2, 5.4 / (150.0 / 16)])
    assert assumed_lags(override(mixed, {"base.tau_believed": [0.1, 0.4]})) == [0.1, 0.4]


def test_a_governor_knows_a_first_order_without_a_limit_of_torque():
    assert SPEED_LOOP.bounded(based()).hidden == ""
    limited = override(based(), {"actuator.tau_max": 5.0})
    assert "actuator.tau_max" in SPEED_LOOP.bounded(limited).hidden
    mixed = based(loop=["first-order", "pi"])
    assert 'base.loop = "pi"' in SPEED_LOOP.bounded(mixed).overshoots
