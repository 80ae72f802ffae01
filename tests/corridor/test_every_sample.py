"""Bounds of each sample of a whole run: as far as all that disturbs leads at worst, hardly more.

On a circle they are also what holds for good, which is found in quite another way.
"""

from __future__ import annotations

import numpy as np
import pytest

from tests.corridor.further import burger
from tests.corridor.one_by_one import HEADING, ROUND, SIDES, of_base, of_torques
from wmr_ctrl.corridor import certified_corridor, run_corridor
from wmr_ctrl.scenario import load_scenario, override


def timed(period, samples):
    """Samples of two plant steps each."""
    return {"clock.control": period, "clock.plant": period / 2,
            "clock.duration": samples * period, "changes": []}  # fmt: skip


def heavier(time):
    return {"changes": [{"t": time, "m": 62.0, "I": 6.6, "mu": 0.12}]}


def simulated(*changes):
    told = {key: value for part in changes for key, value in part.items()}
    return override(load_scenario("safe-simulation"), {"guard.enabled": False, **told})


EIGHT = {"reference.kind": "lemniscate", "reference.size": 1.0}
LITTLE = {"disturbance.std": 0.02, "sensor.pose_noise": 1e-5, "actuator.tau_max": 10.0,
          "sensor.velocity_noise": [2e-5, 2e-4]}  # fmt: skip
LATE = {"actuator.delay": 0.01, "actuator.lag": 0.01, "sensor.correction": 0.6}
STOPS = {"reference.kind": "stop-and-go", "reference.period": 4.0, "reference.speed": 0.2,
         "robot.mu": 0.02, "disturbance.std": 0.003, "sensor.pose_noise": 0.0,
         "sensor.velocity_noise": [0.0, 0.0], "actuator.tau_max": 10.0}  # fmt: skip
BASE = {"base.delay": 0.03, "disturbance.std": 1e-6, "disturbance.truncate": 3.0,
        "sensor.pose_noise": 1e-6, "sensor.velocity_noise": [1e-6, 1e-5]}  # fmt: skip
OFF = {"corridor.start": [3e-4, 3e-4, 2e-3]}
HEAVIER = (EIGHT, timed(0.05, 16), LITTLE, heavier(0.425))
CASES = {
    "a robot that becomes heavier": ("prox", simulated(*HEAVIER), (1.0319, 1.0601, 1.0084)),
    "from a start off the path": ("prox", simulated(*HEAVIER, OFF), (1.1719, 1.2740, 1.0325)),
    "late drives, poses in part": (
        "prox", simulated(EIGHT, timed(0.02, 16), LITTLE, LATE, heavier(0.17)),
        (1.0345, 1.0686, 1.0023),
    ),
    "from a standstill": ("prox", simulated(STOPS, timed(0.05, 16)), (2.539, 1.197, 1.000)),
    "a base that takes velocities": (
        "kanayama", burger(timed(0.06, 10), EIGHT, BASE), (1.0092, 1.0348, None),
    ),
}  # fmt: skip
"""Law and scenario; how much larger the bounds of position and heading are, a mean of samples, and
that of the torque in the run."""


@pytest.mark.parametrize("case", CASES)
def test_a_bound_is_what_all_that_disturbs_leads_to_and_hardly_more(case):
    law, scenario, (position, heading, torque) = CASES[case]
    base = torque is None
    own, start = (of_base if base else of_torques)(scenario, law), scenario.corridor.start
    sizes = {
        "push": np.full(2, 3 * scenario.disturbance.std),
        "pose": np.sqrt(2) * scenario.sensor.pose_noise,
        "velocity": np.array(scenario.sensor.velocity_noise),
    }
    if base:
        sizes["heard"], rounded = np.array([1e-6, 1e-5]), {"base.quantum": [2e-6, 2e-5]}
        scenario = override(scenario, rounded)
    tube = run_corridor(scenario, law)
    reached = [own.of_samples(ways, sizes, start) for ways in (ROUND, HEADING)]
    far, turned = (one / other for one, other in zip(tube.course, reached, strict=True))

    assert min(far.min(), turned.min()) > 0.999
    assert tube.position == tube.course[0].max()
    if not base:
        used = tube.share * scenario.actuator.tau_max / own.sums(1, SIDES, sizes, start).max()
        assert used > 0.999
        assert used == pytest.approx(torque, rel=0.01)
        assert "torque" in tube.binding
    assert far.mean() == pytest.approx(position, rel=0.01)
    assert turned.mean() == pytest.approx(heading, rel=0.01)


NOISY = {"sensor.pose_noise": 2e-4, "sensor.velocity_noise": [5e-4, 5e-3]}
SENT = {"base.delay": 0.03, "base.quantum": [2e-3, 1e-2], "disturbance.std": 1e-4,
        "disturbance.truncate": 3.0, "sensor.pose_noise": 1e-4}  # fmt: skip
CIRCLES = {
    "prox": (
        "prox",
        simulated(timed(0.05, 160), {"disturbance.std": 0.36}),
        (1.0158, 1.0140, 1.0001, 0.985),
    ),
    "kanayama, poses in part": (
        "kanayama",
        simulated(timed(0.05, 90), NOISY, {"disturbance.std": 0.2, "sensor.correction": 0.6}),
        (0.9391, 0.9223, 0.9894, 0.987),
    ),
    "a base": ("kanayama", burger(timed(0.06, 80), SENT), (0.9867, 0.9844, 1.0553, 0.887)),
}
"""Law and scenario; its run's position, heading, share and linear part over those for good."""


@pytest.mark.parametrize("case", CIRCLES)
def test_on_a_circle_a_whole_run_is_bounded_by_what_holds_for_good(case):
    """A part of the bounds, up to a quarter, is what linear parts leave of the graphs."""
    law, scenario, shares = CIRCLES[case]
    steady, run = certified_corridor(scenario, law), run_corridor(scenario, law)
    every = "position", "heading", "share", "linear"
    found = [getattr(run, key) / getattr(steady, key) for key in every]

    assert found == pytest.approx(shares, rel=0.005)
    assert steady.position > 1.05 * steady.linear
