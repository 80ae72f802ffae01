"""One robot and lanes of robots give the same bits, for any parts of the loop."""

import random

import pytest

from tests.world.motion import EFFECTS as OURS
from tests.world.motion import PARTS
from tests.world.test_registry import TOYS
from wmr_ctrl.codegen.build import build_batch, build_loop
from wmr_ctrl.control.laws.registry import NAMES
from wmr_ctrl.control.setup import settle
from wmr_ctrl.simulation.engines import runnable_of
from wmr_ctrl.simulation.memory import Task, laid_out, vector_sets
from wmr_ctrl.world.references.registry import REFERENCES
from wmr_ctrl.world.scenario import load_scenario

pytestmark = pytest.mark.usefixtures("every_set_of_instructions", "toy_world")

BASE = {"clock.duration": 1.2, "changes": [{"t": 0.6, "m": 60.0, "I": 6.5, "mu": 0.12}]}
PATH = {"reference.points": [[0.0, 0.0], [1.0, 0.2], [2.0, 1.0], [2.5, 2.0]]}
EFFECTS = [*TOYS.values(), *(OURS[name] for name in PARTS)]


def structure(number):
    """Return a law and random changes for it: effects, guard, and each kind of reference in
    turn.
    """
    kinds = [*REFERENCES]
    kind = kinds[number % len(kinds)]
    changes = {**BASE, **(PATH if kind == "waypoints" else {})}
    for effect in random.Random(number).sample(EFFECTS, 6):
        changes |= effect
    guard = number % 3 > 0 and "toy_ramp.rate" not in changes
    return NAMES[number % len(NAMES)], changes | {"guard.enabled": guard, "reference.kind": kind}


def bits(tasks):
    """All results of a batch's runs, with their log."""
    memory = laid_out(tasks, [], log=True)
    memory.run()
    return [
        [memory.logged(lane).tobytes(), memory.findings[..., lane].tobytes(),
         memory.state[..., lane].tobytes()]
        for lane in range(len(tasks))
    ]  # fmt: skip


@pytest.mark.parametrize("number", range(10))
@pytest.mark.slow
def test_lanes_are_single_runs(number):
    law, changes = structure(number)
    setup = settle(load_scenario("paper-simulation", changes), law)
    alone, lanes = (
        runnable_of(item, setup) for item in (build_loop(setup, watched=True), build_batch(setup))
    )
    wanted = [bits([Task(alone, seed)])[0] for seed in range(8)]
    for item in vector_sets(lanes.compiled.library):
        shown = bits([Task(lanes, seed, vectors=item.name) for seed in range(item.lanes)])
        assert shown == wanted[: item.lanes], item.name
