"""Everyday robots: presets keep the limit behind guard or filter, and leave it without."""

import pytest

from wmr_ctrl.api import simulate
from wmr_ctrl.control.given import scenario_of

BOUGHT = (
    "turtlebot3-burger",
    "clearpath-jackal",
    "turtlebot3-waffle",
    "clearpath-husky",
    "irobot-create3",
)
"""Bases that take velocities."""


def at_the_ends(name):
    """Changes to bases that are as strong and quick, or as weak and slow, as the filter is told.

    Friction that changes within a plant step makes them slower near rest, by a hundredth.
    """
    stated = scenario_of(name).filter
    quick_, slow = stated.tau or (0.02, 0.5)
    weak, strong = zip(*stated.intervals("gain"), strict=True)
    return [
        {"base.gain": list(gain), "base.tau": [tau] * 2}
        for gain, tau in ((strong, quick_), (weak, 0.99 * slow))
    ]


@pytest.mark.parametrize("name", BOUGHT)
@pytest.mark.slow_but("turtlebot3-burger")
def test_presets_keep_their_limits_at_the_ends_of_the_stated_intervals(name):
    """And a robot that is told to keep to its command alone does not: the gain alone is enough."""
    far = {"initial.pose": [-5.0, -5.0, 2.0], "clock.duration": 20.0}
    runs = [simulate(name, "kanayama", overrides={**far, **own}) for own in at_the_ends(name)]
    free = {**far, **at_the_ends(name)[0], "filter.kind": "none", "gains.kanayama.share": 1.0}

    assert all(run.monitor.violations == 0 for run in runs)
    assert simulate(name, "kanayama", overrides=free).monitor.violations > 0
