"""The jerk limit of the firmware."""

import numpy as np
import pytest

from tests.world.motion import acting, based
from wmr_ctrl.world.command_jerk import COMMAND_JERK, build

JERKY = {"jerk": [3.0, 40.0]}


def test_a_jerk_limit_bends_the_command_so_much_and_reaches_it_without_passing():
    wanted = np.repeat([[0.5, 1.0], [-0.4, -2.0], [0.0, 0.0]], 2500, axis=0)
    found = acting(based(**JERKY), wanted)
    bends = np.diff(np.vstack((np.zeros((2, 2)), found)), n=2, axis=0)
    assert (np.abs(bends) <= np.array([3.0, 40.0]) * 1e-6 * (1 + 1e-6)).all()
    assert np.abs(bends).max(axis=0) == pytest.approx(np.array([3.0, 40.0]) * 1e-6, rel=1e-6)
    assert found[[2499, 4999, 7499]] == pytest.approx(wanted[[2499, 4999, 7499]], abs=1e-12)
    assert np.abs(found).max(axis=0) == pytest.approx([0.5, 2.0], rel=1e-12)
    reached = np.argmax(np.isclose(found[:2500, 0], 0.5, rtol=1e-9))
    assert reached * 1e-3 == pytest.approx(2 * (0.5 / 3.0) ** 0.5, rel=0.02)


@pytest.mark.parametrize("more", [{}, {"accel": [0.8, 5.0]}])
def test_the_command_stays_between_all_commands_so_far(more):
    """This is the clip's only hypothesis on a stage of the base."""
    rng = np.random.default_rng(0)
    held = np.repeat(rng.uniform(-1, 1, (60, 2)), rng.integers(1, 150, 60), axis=0)
    found, so_far = acting(based(**JERKY, **more), held), np.vstack((np.zeros((1, 2)), held))
    assert (found <= np.maximum.accumulate(so_far)[1:] + 1e-12).all()
    assert (found >= np.minimum.accumulate(so_far)[1:] - 1e-12).all()
    assert np.abs(found - held).max() > 0.1


@pytest.mark.parametrize("accel, decel", [(1.0, 3.0), (3.0, 1.0)])
def test_the_rate_grows_to_the_larger_limit(accel, decel):
    system = build(based(accel=[accel] * 2, decel=[decel] * 2))
    step = system.function("step", [system.y, system.update])

    sent, after = (part.full().ravel() for part in step([9.0, -9.0], [0.0] * 4, system.p0))

    assert after[2:] == pytest.approx([3.0, -3.0])
    assert sent == pytest.approx([3e-3, -3e-3])
    assert "rounds" in COMMAND_JERK.bounded(based(**JERKY)).hidden
