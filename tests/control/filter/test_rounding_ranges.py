"""Numbers for which nobody proved that the filter's margin covers its roundings are named."""

import pytest

from tests.control.filter.test_filter import scenario
from tests.tables import changes
from wmr_ctrl.control.filter.rounding_ranges import unproved_roundings
from wmr_ctrl.control.setup import settle
from wmr_ctrl.theory.checks import warnings_for
from wmr_ctrl.world.scenario import override

INSIDE = {
    "jitter": {"jitter": 0.025},
    "age": {"age": 0.6, "tau": (0.01, 0.3), "odometry": (0.02, 0.02)},
    "tau": {"tau": (0.2, 409.0)},
}
BEYOND = {
    "jitter": ({"jitter": 0.026}, "half of clock.control, 0.025 s"),
    "age": ({"age": 0.61, "tau": (0.01, 0.3), "odometry": (0.02, 0.02)}, "60 filter.tau[1], 0.6 s"),
    "tau": ({"tau": (0.2, 410.0)}, "clock.control 2^13/1, 409.6 s"),
}


@pytest.mark.parametrize("name", INSIDE)
def test_a_governor_names_the_number_and_its_bound(name):
    assert not [*unproved_roundings(scenario(**INSIDE[name]))]
    changes, bound = BEYOND[name]
    ((key, sentence),) = unproved_roundings(scenario(**changes))
    assert key == f"filter.{name}"
    assert bound in sentence


def test_check_says_it():
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
