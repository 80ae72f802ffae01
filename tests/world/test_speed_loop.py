"""What every speed loop has: its input, and the wheels' limit."""

from __future__ import annotations

import casadi as ca
import pytest

from tests.world.motion import based
from wmr_ctrl.world.scenario import override
from wmr_ctrl.world.speed_loop import Drive, has_loop, speed_loop


@pytest.mark.parametrize(("most", "torque"), [(1e6, [3.0, 1.0]), (2.0, [2.0, 1.0])])
def test_a_wanted_force_becomes_torques_within_the_limit_and_the_loop_is_told(most, torque) -> None:
    """Wheels of 0.1 m, 0.25 m from the middle: 40 N and 5 N m are 3 and 1 N m."""
    scenario = override(based(), {"actuator.tau_max": most})
    missing = []
    drive = Drive(ca.SX([40.0, 5.0]), (), lambda given: missing.append(given) or ca.SX(0, 1))
    system = speed_loop(scenario, "toy", lambda _: drive)
    acting = system.function("acting", [system.y])([0.0] * 4, [0.0, 0.0], system.p0)

    assert acting.full().ravel() == pytest.approx(torque)
    assert len(missing) == 1


def test_only_a_base_that_takes_velocities_has_one() -> None:
    assert has_loop(based(), "first-order")
    assert not has_loop(based(), "pi")
    assert not has_loop(override(based(), {"base.kind": "torque"}), "first-order")
