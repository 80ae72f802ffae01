"""The corridor over a whole run, along a path with varying velocity and past changes."""

from time import sleep
from types import SimpleNamespace
from unittest.mock import Mock

import numpy as np
import pytest

from tests.papers_robot import safe
from tests.tables import changes
from tests.world.toys import GUST
from wmr_ctrl.control.setup import settle
from wmr_ctrl.theory.corridor import find_corridor
from wmr_ctrl.world.registry import EFFECTS
from wmr_proofs.corridor import following, masses, whole
from wmr_proofs.corridor.along import Along
from wmr_proofs.corridor.asked import run_corridor
from wmr_proofs.corridor.inputs import bounded_inputs
from wmr_proofs.corridor.instant import RunBounds
from wmr_proofs.corridor.masses import certified, mass_courses
from wmr_proofs.corridor.passage import Passing
from wmr_proofs.corridor.peaks import Tube
from wmr_proofs.corridor.whole import certified_run

PERIOD = 0.02
HEAVIER = [{"t": 4.0, "m": 65.0, "I": 7.0, "mu": 0.15}]


@pytest.mark.slow
def test_a_set_that_stands_serves_for_many_samples_and_is_as_large(monkeypatch):
    told = {"clock.control": PERIOD, "clock.duration": 20.0, "changes": HEAVIER,
            "disturbance.std": 1.0}  # fmt: skip
    setup = settle(safe(told), "prox")
    along = Along(setup)
    samples, exact = [], Passing._follow
    monkeypatch.setattr(
        Passing,
        "_follow",
        lambda item, now, reach: samples.extend(now.block.at) or exact(item, now, reach),
    )
    first = Passing(along, bounded_inputs(setup), np.zeros(3)).run()
    few = len(samples)
    monkeypatch.setattr(Passing, "_held", lambda item, k: None)
    second = Passing(along, bounded_inputs(setup), np.zeros(3)).run()

    assert few < 900
    assert len(first.position) == len(second.position) == len(samples) - few == 1000
    assert first.position == pytest.approx(second.position, rel=0.002)
    assert (first.heading >= second.heading - 1e-9).all()


def test_a_start_that_alone_stops_it_is_named_and_no_push_is_blamed():
    told = {"clock.control": PERIOD, "clock.duration": 1.0, "changes": []}
    far = safe(told, "corridor.start = [0.02, 0.02, 0.1]")
    refused = run_corridor(far, "prox").refused

    assert refused.endswith(
        "; corridor.start alone is too large for it, also without pushes and errors"
    )
    assert "1/256" not in refused


def test_cells_have_the_widest_of_their_corridors(monkeypatch):
    """Position, heading, linear position, long run and most used limit are from other cells."""
    cells = [(3.0, 1.0, 0.1, 0.5, 2.0), (4.0, 2.0, 0.1, 0.5, 1.0), (1.0, 1.0, 0.3, 0.9, 1.0),
             (2.0, 1.0, 0.2, 0.6, 3.0)]  # fmt: skip
    tubes = [Tube(None, at, late, turn, f"limit {share}", share)
             for at, late, turn, share, _ in cells]  # fmt: skip
    found = [SimpleNamespace(inputs=bounded_inputs(settle(safe(), "prox")), linear_position=far)
             for *_, far in cells]  # fmt: skip
    monkeypatch.setattr(masses, "Certifier", Mock(side_effect=found))
    monkeypatch.setattr(masses, "_certified_tube", Mock(side_effect=tubes))
    monkeypatch.setattr(masses, "checked", lambda *given: given[-1])
    two = changes("corridor.cells = 2; changes = [{t = 2.0, mu = 0.1}, {t = 3.0, mu = 0.2}]")
    tube = certified(settle(safe({**LOADED, **two}), "prox"))

    assert (tube.position, tube.position_late, tube.heading, tube.linear) == (4.0, 2.0, 0.3, 3.0)
    assert (tube.binding, tube.share, tube.until) == ("limit 0.9", 0.9, 2.0)


def test_runs_of_cells_have_the_widest_of_their_courses(monkeypatch):
    runs = np.array([[[1, 5, 0, 2], [0, 1, 0, 0]], [[3, 1, 1, 4], [0, 0, 2, 0]],
                     [[2, 2, 2, 1], [3, 0, 0, 0]]])  # fmt: skip
    limits = SimpleNamespace(conditions=[SimpleNamespace(name=name) for name in "abcd"])
    results = [(SimpleNamespace(loop=limits), RunBounds(
        run[0], run[0] / 2, run[1], run[0] / 10, np.arange(4), None)) for run in runs]  # fmt: skip
    monkeypatch.setattr(whole, "_passed", Mock(side_effect=results))
    monkeypatch.setattr(whole, "mass_courses", lambda setup: [(setup, np.zeros(2))] * len(runs))
    tube = certified_run(settle(safe("changes = []"), "prox"))

    assert tube.course.tolist() == [[3, 5, 2, 4], [3, 1, 2, 0]]
    assert (tube.position, tube.position_late, tube.linear, tube.heading) == (5, 4, 2.5, 3)
    assert (tube.binding, tube.share) == ("b", 0.5)


@pytest.mark.slow
def test_what_closes_with_one_cell_is_not_said_of_all():
    told = changes("""
        reference.kind = lemniscate
        reference.size = 2.0
        reference.rate = 0.1
        changes = []
        disturbance.std = 0.5
        clock.duration = 3.0
        corridor.cells = 2
        guard.trust = true
        actuator.tau_max = 8.0
    """) | {"clock.control": PERIOD}  # fmt: skip
    tube = certified_run(settle(safe(told), "prox"))

    assert tube.position is None
    assert tube.closes is not None
    assert "around that mass alone (others were not tried) it closes" in tube.sentence


LOADED = changes("""
    guard.M_min = [58.0, 6.2]
    guard.M_max = [64.0, 6.9]
    robot.m = 61.0
    robot.I = 6.5
    model.m = 50.0
    model.I = 5.4
    guard.trust = true
    disturbance.std = 0.02
    changes = [{t = 3.0, m = 62.0, I = 6.6}]
""") | {"clock.control": PERIOD}  # fmt: skip


@pytest.mark.parametrize("named", [{"m": 62.0}, {"I": 6.6}], ids=str)
def test_with_cells_a_change_of_mass_or_inertia_is_one_of_both(named):
    """A body whose inertia changes also has another mass, within what the guard assumes."""
    told = {"corridor.cells": 2, "changes": [{"t": 1.0, "mu": 0.03}, {"t": 3.0, **named}]}
    setup = settle(safe({**LOADED, **told}), "prox")
    courses = [
        [(robot.m, robot.I) for robot in (cell.scenario.robot, *cell.scenario.changes)]
        for cell, _ in mass_courses(setup)
    ]

    assert len(courses) == 16
    assert {course[1] for course in courses} == {(None, None)}
    for moved in (0, 1):
        assert len({course[2][moved] for course in courses}) == 2
    assert len({(course[0], course[2]) for course in courses}) == 16


@pytest.mark.parametrize(
    "told",
    [{"robot.m": 120.0}, changes("changes = [{t = 3.0, m = 62.0, I = 12.6}]")],
    ids=["robot", "change"],
)
@pytest.mark.parametrize("whole", [False, True])
def test_a_robot_outside_the_masses_that_are_counted_has_no_corridor(told, whole):
    given = {**LOADED, "corridor.cells": 1, "guard.trust": False, **told}
    scenario = safe(given)
    refused = (certified_run if whole else certified)(settle(scenario, "prox")).refused

    assert "which is not within" in refused
    assert "set cells = 0" in refused


def test_too_many_mass_histories_are_refused():
    scenario = safe(
        LOADED,
        """
            corridor.cells = 3
            changes = [{t = 3.0, m = 62.0, I = 6.6}, {t = 6.0, m = 60.0}]
        """,
    )
    refused = certified_run(settle(scenario, "prox")).refused

    assert "corridor.cells = 3 with changes needs 729 mass/inertia histories" in refused


@pytest.mark.slow
def test_what_stays_free_counts_on_the_corridor_that_there_is():
    """Friction that the wheels cannot bear leaves the whole run without a corridor; until then
    there is one.
    """
    told = changes("""
        reference.keep_out = [[0.0, 2.0, 1.0]]
        body.radius = 0.3
        changes = [{t = 0.5, mu = 0.9}]
    """)
    tube = find_corridor(safe(told), "prox", whole=True)

    assert tube.whole.position is None
    assert tube.clearance.free == pytest.approx(1.0 - 0.3 - tube.position, abs=1e-3)


@pytest.mark.parametrize("whole", [False, True])
@pytest.mark.slow_but("True")
def test_a_law_that_predicts_is_refused_by_a_sentence(whole):
    told = changes("""
        guard.enabled = false
        actuator.delay = 0.02
        gains.prox.delay = 0.02
    """)
    tube = find_corridor(safe(told), "prox", whole=whole)

    assert tube.refused == "a law that predicts (its gain delay) is not covered"


def test_the_first_estimate_of_a_pose_is_off_by_what_the_heading_makes_of_a_period():
    """Poses are corrected in part and predicted with a wrong heading."""
    told = changes("""
        sensor.correction = 0.4
        clock.control = 0.1
        reference.rate = 0.6
        reference.radius = 0.4
        clock.duration = 2.0
        changes = []
    """)
    along = Along(setup := settle(safe(told), "prox"))
    passing = Passing(along, bounded_inputs(setup), np.zeros(3))
    place = len(passing.pending) - along.loop.acting - along.loop.filter
    *off, turned = passing.pending[place : place + 3]

    way = 0.24 * 0.1
    assert (np.array(off) >= way * turned).all()
    assert passing.pending[0] == 0.0


@pytest.mark.parametrize("kind", ["circle", "lemniscate"])
def test_what_pushes_at_each_plant_step_by_chance_is_refused_by_name(monkeypatch, kind):
    """The plant step's graph is read with all random numbers 0."""
    monkeypatch.setitem(EFFECTS.__dict__, "plugins", (GUST,))
    told = {"toy_gust.torque": 1.0, "guard.enabled": False, "reference.kind": kind}
    tube = find_corridor(safe(told), "prox", whole=True)

    assert tube.refused == (
        "the loop with the effect toy gust ([toy_gust]) is not covered: leave out "
        "toy_gust.torque = 1.0"
    )


def test_a_whole_run_beyond_its_work_is_not_checked_on_a_machine_of_any_speed(monkeypatch):
    told = {"clock.control": PERIOD, "clock.duration": 6.0, "changes": HEAVIER}
    scenario, spent = safe(told), []
    with monkeypatch.context() as patch:
        patch.setattr(following, "spend", lambda _, work: spent.append(work))
        certified_run(settle(scenario, "prox"))
    work, quick = sum(spent), Passing._until
    monkeypatch.setattr(Passing, "_until", lambda item, now: sleep(1e-3) or quick(item, now))

    enough, less = (find_corridor(scenario, "prox", whole=True, work=w) for w in (work, work - 1))

    assert enough.whole.position is not None
    assert ", in a run of 6 s; " in enough.whole.sentence
    assert less.whole.figures["refused"].startswith("not checked: ")
    assert less.position == enough.position
    assert "not checked" in less.sentence
