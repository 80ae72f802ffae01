"""Standstill control: a base without commands stands under any push, until a command comes."""

import casadi as ca
import numpy as np
import pytest

from tests.tables import changes
from tests.world.motion import based
from wmr_ctrl import ArgumentError, ScenarioError, simulate, simulate_many
from wmr_ctrl.control.setup import settle
from wmr_ctrl.simulation.engines import run_numpy, runnable
from wmr_ctrl.world.model.evaluate import evaluated
from wmr_ctrl.world.scenario import override
from wmr_ctrl.world.standstill import STANDSTILL

PUSHED = changes("""
    disturbance = {push = [3.0, 0.0]}; world.wall = [[1.0, -2.0], [1.0, 2.0]]
    body.radius = 0.2; reference = {kind = "line", speed = 0.4}; clock.duration = 6.0
    initial.pose = [0.0, 0.0, -1.5707963267948966]; robot.mu = 0.0
    filter = {kind = "governor", tau = [0.2, 0.2], d = [0.05, 0.05], rest = 0.5, free_error = 0.0}
""")


def pushed(**base):
    return override(based(**base), PUSHED)


def braked(scenario, commands):
    """Return whether the base is held, for one command per plant step."""
    system = STANDSTILL.system(scenario)
    step = system.function("act", [ca.densify(system.update), ca.densify(system.d)])
    state, found = np.array(system.x0), []
    for command in commands:
        state, held = evaluated(step, list(command), state, system.p0)
        found.append(bool(held.item()))
    return found


def test_it_holds_after_its_time_without_commands_and_until_another_one():
    commands = [(0.1, 0.0)] * 3 + [(0.0, 0.0)] * 30 + [(0.0, -1e-9)] * 2 + [(0.0, 0.0)] * 21

    wanted = [False] * 23 + [True] * 10 + [False] * 22 + [True]
    assert braked(based(rest=0.02), commands) == wanted
    assert braked(based(rest=0.0), commands) == [c == (0.0, 0.0) for c in commands]


def test_nothing_moves_a_base_that_stands():
    held = simulate(pushed(rest=0.5), "kanayama")
    rolls = simulate(override(pushed(), {"filter.trust": True}), "kanayama")

    assert (held["v1"][-20:] == 0.0).all()
    assert len(np.unique(held["x"][-20:])) == 1
    assert np.abs(held["v1"]).max() > 0.3
    assert 0 < 0.8 - held["x"][-1] < 0.1
    assert rolls["x"][-1] > 0.8


def test_every_engine_holds_it_alike():
    scenario = override(pushed(rest=0.5), {"disturbance.std": 0.02})
    runs = [simulate(scenario, "kanayama", seed=seed) for seed in range(2)]

    assert simulate_many(scenario, "kanayama", [0, 1])["final_x"].tolist() == [
        run["x"][-1] for run in runs
    ]
    assert run_numpy(scenario, "kanayama", 0)["x"] == pytest.approx(runs[0]["x"], abs=1e-9)


def test_a_plant_outside_of_the_loop_is_refused():
    with pytest.raises(ArgumentError, match=r"base\.rest = 0\.5: a plant outside"):
        runnable(pushed(rest=0.5), "kanayama", "mujoco")


OVERSHOOTS = "filter.kind = clip; filter.loop = second-order; filter.damping = [0.9, 1.1]"
UNTOLD = "filter.rest = none; filter.free_error = none"


@pytest.mark.parametrize("base, text, words", [
    ({}, "", "base.rest = inf is longer"), ({"rest": 0.6}, "", "base.rest = 0.6 is longer"),
    ({"rest": 0.5}, UNTOLD, "filter.rest does not say when"),
    ({"rest": 0.5, "loop": "second-order"}, f"{OVERSHOOTS}; {UNTOLD}",
     "base.rest = 0.5: a base that stands at once"),
])  # fmt: skip
def test_a_filter_has_to_be_told(base, text, words):
    settle(override(pushed(rest=0.5), {"disturbance.push": [0.0, 0.0]}), "kanayama")
    with pytest.raises(ScenarioError, match=words):
        settle(override(pushed(**base), changes(text)), "kanayama")
