"""Statements 1 to 5 of docs/explanation/guarantee.md, each tested on exact robots.

Nothing here integrates with the product's code; only the guard's graph is the product's.
"""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.control.guard.late_trial import LIMITS, Case, Thrown, composed, settled, trial
from tests.control.guard.test_lateness_any import returned

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
    """Statements 1 and 3: at every instant, for every law."""
    found = trial(CASES[name], ROBOTS, 60, 1)

    assert (found.fastest <= 1).all()
    assert (found.fastest > 0.99).all()


@pytest.mark.parametrize("name", ["10 ms", "100 ms"])
def test_outside_comes_back_in_time_and_not_through_the_other_side(name):
    """Statement 2: the speed never grows, and the limit is reached within the stated samples."""
    case, way = CASES[name], np.random.default_rng(3).choice([-1.0, 1.0], ROBOTS)
    thrown = Thrown(way, start=2.0)
    found = trial(case, ROBOTS, 40, 3, thrown=thrown)

    for axis in (0, 1):
        returned(found, axis, case.formula(axis), thrown)
    assert (np.abs(found.seen[-1]) <= LIMITS[:, None]).all()


@pytest.mark.parametrize("name", ["10 ms", "100 ms"])
@pytest.mark.parametrize("way", [1, -1])
def test_a_refused_force_could_leave_the_limit(name, way):
    """Statement 4: with alpha = 1/T and exact measurement, the lightest robot under a push just
    reaches it.

    Friction may instantly stop a robot that moves the other way, and then vanish.
    """
    case, (system, step) = CASES[name], composed(CASES[name])
    share, robot = np.array([1.0, 0.2]), settled(case).scenario.robot
    for v in np.linspace(-1, 1, 20)[:, None] * LIMITS:
        right, left = step([way * 1e6, way * 1e6, *v], system.x0, system.p0)[1].full().ravel()
        force = np.array([right + left, robot.l * (right - left)]) / robot.r
        pushed = way * force + share * case.dbar
        reached = np.maximum(way * v, 0) + case.T * pushed / (share * case.M_min)
        assert reached == pytest.approx(LIMITS, rel=1e-9)


@every_case
def test_a_broken_bound_costs_what_it_says(name):
    """Statement 5: |d| <= dbar + D keeps the speed below v_u1 + D (T + delay)/M_min."""
    case = CASES[name]
    found = trial(case, ROBOTS, 60, 7, replace(case, dbar=1.1 * case.dbar), compare=False)
    most = LIMITS + 0.1 * case.dbar * case.T * (1 + case.hi) / case.M_min

    assert (found.fastest * LIMITS <= most * (1 + 1e-9)).all()
    assert (found.fastest > 1).any()


def test_the_page_has_no_guarantee_that_is_not_tried_here():
    """Five items, and each is the subject of a test above."""
    page = (Path(__file__).parents[3] / "docs/explanation/guarantee.md").read_text("utf-8")
    items = re.findall(r"^(\d)\. \*\*(.+?)\.\*\*", page.split("## How it works")[0], re.MULTILINE)
    own = Path(__file__).read_text(encoding="utf-8")

    assert [number for number, _ in items] == ["1", "2", "3", "4", "5"]
    assert all(
        re.search(rf'"""Statements? (\d and )?{number}( and \d)?: ', own) for number, _ in items
    )
