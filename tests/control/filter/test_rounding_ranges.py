"""Numbers outside the proved range of the filter's rounding margin are named."""

import pytest

from tests.control.filter.test_filter import scenario
from tests.tables import cases, changes
from wmr_ctrl.control.filter.rounding_ranges import unproved_roundings
from wmr_ctrl.control.setup import settle
from wmr_ctrl.theory.checks import warnings_for
from wmr_ctrl.world.scenario import override


@pytest.mark.parametrize(
    "key, most, beyond, stated, bound",
    cases("""
        filter.jitter | 0.025 | 0.026 | filter.d = [0.05, 0.05]  | half of clock.control, 0.025 s
        filter.age    | 0.6   | 0.61  | filter.tau = [0.01, 0.3] | 60 filter.tau[1], 0.6 s
        filter.tau    | [0.2, 409] | [0.2, 410] | filter.age = 0 | clock.control 2^13/1, 409.6 s
    """),
)
def test_a_governor_names_the_number_and_its_bound(key, most, beyond, stated, bound):
    inside, outside = (
        override(scenario(), changes(f"{stated}; {key} = {value}")) for value in (most, beyond)
    )
    assert not [*unproved_roundings(inside)]
    ((named, sentence),) = unproved_roundings(outside)
    assert named == key
    assert bound in sentence


def test_check_warns_that_roundings_are_not_proved():
    stated = override(
        scenario(jitter=0.03),
        changes("""
            base.kind = velocity
            base.gain = [1.0, 1.0]
            filter.trust = true
        """),
    )
    texts = [str(item) for item in warnings_for(settle(stated, "kanayama"))]
    assert sum("proved for exact arithmetic only" in text for text in texts) == 1
