"""What acts on the commands of a base that takes velocities, in runs and before a filter."""

import pytest

from tests.world.motion import based
from wmr_ctrl.control.setup import settle
from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.world.scenario import override

IN_RUNS = {
    "ramp": {"accel": [1.0, 3.0]},
    "jerk": {"jerk": [3.0, 9.0]},
    "dead band": {"deadband": [0.2, 0.3]},
    "quantum": {"quantum": [0.03, 0.07]},
    "wheels": {"w_max": 6.0},
    "losses": {"losses": 3, "delay": 0.02},
    "time-out": {"losses": 3, "timeout": 0.06},
}


GOVERNOR = {"kind": "governor", "tau": [0.2, 0.2], "delay": [0.02, 0.02]}


@pytest.mark.parametrize(
    "name, words",
    [
        ("ramp", "ramps"),
        ("jerk", "rounds"),
        ("dead band", "filter.d[1]"),
        ("quantum", "filter.d[1]"),
        ("wheels", "clips"),
        ("losses", "filter.losses"),
        ("time-out", "the base stops"),
    ],
)
def test_a_governor_counts_on_none_of_them_and_a_clip_on_errors_alone(name, words):
    broken = based(**{"delay": 0.02, **IN_RUNS[name]})
    with pytest.raises(ScenarioError) as error:
        settle(override(broken, {"filter": {**GOVERNOR, "losses": 3 * (name == "time-out")}}), None)
    assert words in str(error.value)
    push = [0.02, 0.04] if name == "quantum" else [0.0, 0.0]
    settle(override(broken, {"filter": {"kind": "clip", "d": push}}), None)
