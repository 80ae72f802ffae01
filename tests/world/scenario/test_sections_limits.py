"""Limits of both directions: omitted ones are derived, and impossible ones are refused."""

import pytest

from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.world.scenario.sections import Limits


def test_missing_values_are_derived():
    alone = Limits(v_u1=(1.0, 1.5))
    assert (alone.v_min, alone.v_max, alone.apart) == ((-1.0, -1.5), (1.0, 1.5), False)

    box = Limits(v_min=(-0.2, -1.5), v_max=(0.5, 1.0))
    assert box.v_u1 == (0.5, 1.5), "the larger side of each axis"
    assert box.v_u2 == pytest.approx((0.425, 1.275))
    assert box.smaller == (0.2, 1.0)
    assert box.unequal == (0, 1)

    forward = Limits(v_u1=(1.0, 2.0), v_min=(0.0, -2.0))
    assert forward.v_max == (1.0, 2.0)
    assert forward.unequal == (0,)


@pytest.mark.parametrize(
    "stated, said",
    [
        ({"v_min": (0.1, -1.0)}, r"v_min\[1\] = 0.1 must be at most 0: .*may stop"),
        ({"v_max": (1.0, -0.5)}, r"v_max\[2\] = -0.5 must be at least 0"),
        ({"v_max": (1.2, 1.0)}, r"v_max\[1\] = 1.2 m/s is beyond limits.v_u1\[1\] = 1.0, .*Lower"),
        ({"v_min": (-1.0, -3.0)}, r"v_min\[2\] = -3.0 rad/s is beyond limits.v_u1\[2\] = 1.5"),
        ({"v_min": (0.0, -1.0), "v_max": (0.0, 1.0)}, r"v_max\[1\] are both 0 m/s: .*could not"),
    ],
)
def test_impossible_limits_are_refused_with_their_numbers(stated, said):
    with pytest.raises(ScenarioError, match=said) as refused:
        Limits(v_u1=(1.0, 1.5), **stated)
    assert "\n" not in str(refused.value)
