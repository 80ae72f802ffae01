"""Sentences of docs/explanation/guarantee.md, each tried on robots that are exact.

Nothing here integrates with the product's code; of the product there is the guard's graph alone.
"""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.control.guard.late_trial import LIMITS, Case, Thrown, composed, trial
from tests.control.guard.test_lateness_any import returned
from tests.tables import changes
from wmr_ctrl.control.setup import settle
from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.world.model.evaluate import evaluated
from wmr_ctrl.world.scenario import load_scenario

ROBOTS = 150
PUSHED = Case(dbar=60.0)
CASES = {
    "10 ms": replace(PUSHED, T=0.01),
    "100 ms": PUSHED,
    "10 ms, late by 25 ms": replace(PUSHED, T=0.01, lo=2.5, hi=2.5),
    "100 ms, late by 25 ms": replace(PUSHED, lo=0.25, hi=0.25),
}
every_case = pytest.mark.parametrize("name", CASES)


@every_case
def test_inside_stays_inside_and_there_is_always_a_safe_force(name):
    """1 and 3: at every instant, for every law."""
    found = trial(CASES[name], ROBOTS, 60, 1)

    assert (found.fastest <= 1).all()
    assert (found.fastest > 0.99).all()


@pytest.mark.parametrize("name", ["10 ms", "100 ms"])
def test_outside_comes_back_in_time_and_not_through_the_other_side(name):
    """2: the speed never grows, and the limit is reached within the stated samples."""
    case, way = CASES[name], np.random.default_rng(3).choice([-1.0, 1.0], ROBOTS)
    thrown = Thrown(way, start=2.0)
    found = trial(case, ROBOTS, 40, 3, thrown=thrown)

    for axis in (0, 1):
        returned(found, axis, case.formula(axis), thrown)
    assert (np.abs(found.seen[-1]) <= LIMITS[:, None]).all()


@pytest.mark.parametrize("name", ["10 ms", "100 ms"])
def test_a_refused_force_could_leave_the_limit(name):
    """4: for some admissible mass, push and friction, with alpha = 1/T and exact measurement.

    Friction may stop at once a robot that moves the other way, and then vanish.
    """
    case, draw = CASES[name], np.random.default_rng(5)
    share, top = np.array([[1.0], [0.2]]), LIMITS[:, None]
    v = draw.uniform(-1, 1, (2, ROBOTS)) * top
    wanted = 10.0 ** draw.uniform(0, 5, (2, ROBOTS)) * draw.choice([-1.0, 1.0], (2, ROBOTS))
    system, step = composed(case)
    x, p = (np.tile(row, (ROBOTS, 1)) for row in (system.x0, system.p0))
    _, (right, left), _ = evaluated(step.map(ROBOTS), np.vstack([wanted, v]).T, x, p)
    robot = case.setup.scenario.robot
    forces = np.array([right + left, robot.l * (right - left)]) / robot.r

    cut = (np.abs(wanted - forces) > 1e-6 * np.abs(wanted)) & (np.abs(wanted) > np.abs(forces))
    out, push = np.sign(wanted), share * case.dbar
    for factor, leaves in ((1 + 1e-6, True), (1 - 1e-6, False)):
        tried = forces + out * ((factor - 1) * np.maximum(np.abs(forces), push) + push)
        start = out * np.maximum(out * v, 0.0)
        speeds = [np.abs(start + case.T * tried / (share * mass)) for mass in (case.M_min, 70.0)]
        beyond = np.maximum(*speeds) > top * (1 + 1e-12)
        assert beyond[cut].all() if leaves else not beyond[cut].any()
    assert cut.sum() > ROBOTS / 2


@every_case
def test_a_broken_bound_costs_what_it_says(name):
    """5: |d| <= dbar + D keeps the speed below v_u1 + D (T + delay)/M_min."""
    case = CASES[name]
    found = trial(case, ROBOTS, 60, 7, replace(case, dbar=1.1 * case.dbar), compare=False)
    most = LIMITS + 0.1 * case.dbar * case.T * (1 + case.hi) / case.M_min

    assert (found.fastest * LIMITS <= most * (1 + 1e-9)).all()
    assert (found.fastest > 1).any()


@pytest.mark.parametrize(
    "broken",
    [
        "clock.control = 0.246; clock.duration = 24.6",
        "guard.nbar = [0.51, 0]",
        "guard.alpha = 100.1",
        f"actuator.tau_max = {0.99 * (60 + 15 / 0.25) * 0.1 / 2}",
    ],
)
def test_what_cannot_hold_is_refused_with_the_number(broken):
    """The inequalities of the page, just met and just missed: 2 dbar <= M_min u1/T on axis 2."""
    stated = changes("""
        changes = []
        guard.M_min = [45, 4.86]
        guard.M_max = [71.5, 7.7]
        guard.dbar = [60, 15]
    """)
    met = stated | changes("clock.control = 0.24; clock.duration = 24")
    settle(load_scenario("safe-simulation", met), None)
    with pytest.raises(ScenarioError, match="guard"):
        settle(load_scenario("safe-simulation", stated | changes(broken)), None)


def test_the_page_has_no_guarantee_that_is_not_tried_here():
    """Five items, and each is the subject of a test above."""
    page = (Path(__file__).parents[3] / "docs/explanation/guarantee.md").read_text("utf-8")
    items = re.findall(r"^(\d)\. \*\*(.+?)\.\*\*", page.split("## How it works")[0], re.MULTILINE)
    own = Path(__file__).read_text(encoding="utf-8")

    assert [number for number, _ in items] == ["1", "2", "3", "4", "5"]
    assert all(re.search(rf'"""(\d and )?{number}( and \d)?: ', own) for number, _ in items)
