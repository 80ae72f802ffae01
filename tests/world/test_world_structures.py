"""One robot and lanes of robots leave the same bits, whatever their loop is made of."""

import random

import pytest

from tests.world.toys import CLOTHOID
from wmr_ctrl.codegen.build import build_batch, build_loop
from wmr_ctrl.control.laws.registry import NAMES
from wmr_ctrl.control.setup import settle
from wmr_ctrl.results.windows import windows_of
from wmr_ctrl.simulation.engines import runnable_of
from wmr_ctrl.simulation.memory import Task, laid_out
from wmr_ctrl.simulation.memory import vector_sets as usable
from wmr_ctrl.world.references.registry import OURS
from wmr_ctrl.world.scenario import load_scenario

pytestmark = pytest.mark.usefixtures("every_set_of_instructions", "toy_world")

KINDS = (*(kind.name for kind in OURS), CLOTHOID.name)
POINTS = [[0.0, 0.0], [1.0, 0.2], [2.0, 1.0], [2.5, 2.0]]
BASE = {"clock.duration": 1.2, "changes": [{"t": 0.6, "m": 60.0, "I": 6.5, "mu": 0.12}]}
EFFECTS = (
    {"disturbance.truncate": 1.5},
    {"disturbance.push": [3.0, 0.5]},
    {"sensor.pose_period": 0.05, "sensor.pose_noise": 0.004, "sensor.correction": 0.6},
    {"sensor.velocity_noise": [0.002, 0.004]},
    {"actuator.lag": 0.02},
    {"actuator.delay": 0.013},
    {"actuator.tau_max": 25.0},
    {"toy_gyro.walk": 0.001},
    {"toy_encoder.step": 0.0005},
    {"toy_ramp.rate": 100.0},
    {"toy_slope.angle": 0.03},
    {"toy_gust.torque": 0.05},
)
BOUNDLESS = ("toy_encoder", "toy_ramp")
"""Effects with which no guard can be on."""
COUNT = 10


def structure(number):
    """A law, and what is drawn for it: effects, guard, a reference; every kind in its turn."""
    draw, guard = random.Random(number), number % 3 > 0
    known = [item for item in EFFECTS if not (guard and next(iter(item)).startswith(BOUNDLESS))]
    changes = {**BASE, "guard.enabled": guard, "reference.kind": KINDS[number % len(KINDS)]}
    if changes["reference.kind"] == "waypoints":
        changes["reference.points"] = POINTS
    for effect in draw.sample(known, draw.randint(2, len(known))):
        changes |= effect
    return NAMES[number % len(NAMES)], changes


def bits(tasks):
    """All that the runs of a batch leave, with a log and without."""
    windows = list(windows_of(tasks[0].loop.settings).values())
    logged, watched = laid_out(tasks, [], log=True), laid_out(tasks, windows)
    logged.run()
    watched.run()
    left = (logged.findings, logged.state, watched.findings, watched.state, watched.sums)
    return [
        [logged.logged(lane).tobytes(), *(item[..., lane].tobytes() for item in left)]
        for lane in range(len(tasks))
    ]


@pytest.mark.parametrize("number", range(COUNT))
@pytest.mark.slow
def test_lanes_are_single_runs(number):
    law, changes = structure(number)
    setup = settle(load_scenario("paper-simulation", changes), law)
    built = build_loop(setup, watched=True), build_batch(setup)
    alone, lanes = (runnable_of(item, setup) for item in built)
    wanted = [bits([Task(alone, seed)])[0] for seed in range(8)]
    for item in usable(lanes.compiled.library):
        shown = bits([Task(lanes, seed, vectors=item.name) for seed in range(item.lanes)])
        assert shown == wanted[: item.lanes], item.name
