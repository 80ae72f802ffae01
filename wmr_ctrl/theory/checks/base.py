"""What a base that takes velocities makes of its commands, and where a path asks for more."""

from collections.abc import Iterator

import numpy as np

from wmr_ctrl.results.remarks import HELD_BACK, percent
from wmr_ctrl.results.verdicts import Warning
from wmr_ctrl.world.references.kind import GRID, sample
from wmr_ctrl.world.scenario import Scenario

from .error_coordinates import Floats
from .loop import Loop

STILL = 1e-9
"""Speed [m/s, rad/s] that counts as none."""
SAME = 1e-6
"""Share by which a path may turn tighter than the base and yet as tightly."""


def rims(scenario: Scenario, pairs: Floats) -> Floats:
    """Speeds of the right and left rim (n, 2) [m/s] for (v, omega) (n, 2)."""
    return pairs @ np.array([[1.0, 1.0], [scenario.robot.l, -scenario.robot.l]])


def dead(scenario: Scenario, pairs: Floats) -> dict[str, Floats]:
    """Where commands (n, 2) other than 0 lie within a dead band, by its key."""
    base = scenario.base
    bands = {
        "base.deadband": (pairs, np.array(base.deadband)),
        "base.wheel_deadband": (rims(scenario, pairs), np.array(base.wheel_deadband)),
    }
    return {
        key: ((np.abs(asked) < band) & (np.abs(asked) > STILL)).any(axis=1)
        for key, (asked, band) in bands.items()
        if band.any()
    }


def beyond_base(loop: Loop) -> Iterator[Warning]:
    """Yield where the path turns tighter than the base, or asks for less than its dead band."""
    scenario = loop.scenario
    if not loop.setup.takes_velocity:
        return
    end = min(scenario.clock.duration, scenario.reference.cycle)
    pairs = sample(scenario, np.linspace(0, end, GRID))[:, 3:5]
    turns, least = pairs[np.abs(pairs[:, 1]) > STILL], scenario.base.min_radius
    tightest = float(np.min(np.abs(turns[:, 0] / turns[:, 1]), initial=np.inf))
    if tightest < least * (1 - SAME):
        yield Warning(
            "base.min_radius",
            f"the path turns with a radius of {tightest:.3g} m, tighter than base.min_radius = "
            f"{least:g} m: the base leaves it there. Ask for wider turns.",
            "docs/howto/velocity_base.md",
        )
    for key, within in dead(scenario, pairs).items():
        if (share := float(within.mean())) >= HELD_BACK:
            yield Warning(
                key,
                f"for {percent(share)} of its time the path asks for less than {key}, and such "
                "commands do nothing: the base leaves the path until the law asks for more. Ask "
                "for a faster or tighter path.",
                "docs/howto/velocity_base.md",
            )
