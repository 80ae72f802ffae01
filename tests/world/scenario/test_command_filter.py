"""The section of the command filter: keys that cannot be combined."""

import pytest

from tests.tables import cases, changes
from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.core.fields.section import build
from wmr_ctrl.world.scenario.command_filter import Filter
from wmr_ctrl.world.scenario.raw import parse_value

PI = {"loop": "pi", **{name: [1.0, 2.0] for name in ("mass", "inertia", "kp", "ki")}}
LOOPS = {
    "FAST": "SECOND; frequency = [3.0, 5.0]",
    "SECOND": "loop = second-order; damping = [0.5, 1.0]",
    "PI": "loop = pi; mass = [1, 2]; inertia = [1, 2]; kp = [1, 2]; ki = [1, 2]",
}
INTERVALS = ("tau", "gain", "delay", "damping", "frequency", "mass", "inertia", "kp", "ki",
                    "friction")  # fmt: skip


@pytest.mark.parametrize("name", INTERVALS)
def test_an_interval_of_a_filter_is_the_right_way_round(name):
    with pytest.raises(ScenarioError, match=rf"filter\.{name}\b"):
        build(Filter, {"kind": "clip", name: [2.0, 1.0]})


REFUSED = """
    kind = clip; scale = axes; wheel_speed = 1.0 | filter.scale = "axes"
    kind = clip; scale = axes; channels = wheels | filter.scale = "axes"
    kind = governor; tau = [1e-4, 101.0] | more than a factor of 1e6
    kind = governor | filter.tau is missing
    kind = clip; loop = pi | filter.mass is missing
    kind = governor; tau = [0.1, 0.2]; SECOND | does not hold for filter.loop
    kind = clip; PI; channels = wheels | different masses for v and omega
    kind = clip; slew = [1.0, 1.0] | filter.slew is for
    kind = clip; slew = [1.0, 1.0]; SECOND | filter.frequency is missing
    kind = clip; slew = [1.0, 1.0]; FAST; hold = 0.1 | covers neither a base
    kind = clip; slew = [1.0, 1.0]; FAST; changing = true | Leave out filter.slew
    kind = clip; channels = wheels; changing = true | Leave out filter.channels
    kind = clip; decel = [1.0, 2.0] | filter.decel is for
    kind = governor; tau = [0.1, 0.2]; free_error = 0.0; decel = [1.0, 2.0] | filter.decel is for
    kind = band | is for loops that overshoot
    kind = band; SECOND | filter.frequency is missing
    kind = band; FAST; losses = 1 | filter.losses:
    kind = band; FAST; delay = [0.1, 0.2] | filter.delay:
    kind = band; FAST; odometry = [0.0, 0.1] | from its own commands
"""


@pytest.mark.parametrize("text, word", cases(REFUSED))
def test_what_a_filter_cannot_be_asked_for_together_is_refused(text, word):
    for name, more in LOOPS.items():
        text = text.replace(name, more)
    with pytest.raises(ScenarioError) as refused:
        build(Filter, {key: parse_value(value) for key, value in changes(text).items()})
    assert word in str(refused.value)


def test_a_filter_may_know_a_time_constant_within_a_factor_of_a_million():
    assert build(Filter, {"kind": "governor", "tau": [1e-4, 99.0]}).tau == (1e-4, 99.0)


def test_a_gain_that_a_preset_states_need_not_be_left_out():
    with pytest.raises(ScenarioError, match=r"state filter\.gain = \[1, 1\]"):
        build(Filter, {"kind": "clip", "gain": [0.9, 1.1], **PI})
    assert build(Filter, {"kind": "clip", "gain": [1, 1], **PI}).gain == (1.0, 1.0)


@pytest.mark.parametrize(
    "values, keys",
    [
        ({"kind": "none"}, ()),
        ({"kind": "clip"}, ()),
        ({"kind": "clip", "wheel_speed": 1.0}, ("robot.l",)),
        ({"kind": "clip", "gain": [1, 1], **PI}, ("robot.l",)),
    ],
)
def test_only_what_knows_wheels_reads_the_track(values, keys):
    assert build(Filter, values).reads == keys
