"""The match: its page names every contender, and its parts do what they are called."""

import numpy as np
import pytest

from benchmarks import contenders, match, velocity_match
from tests.benchmarks.pages import MATCH, cells, table

SHORT = match.Case(0.1, 0.05, track=2.0, attack=2.0)


def test_the_page_has_every_contender_in_every_case_and_guards_keep_the_limit():
    _, mark, tables = MATCH.partition(match.MARK)
    rows = [cells(line)[:2] for line in tables.splitlines() if line.startswith("| ")]
    names = [one.name for one in contenders.contenders()]
    guarded = [worst for name, worst in rows if name.endswith("+ guard")]

    assert mark
    assert [name for name, _ in rows if name != "contender"] == names * len(match.CASES)
    assert guarded == ["none"] * 4 * len(match.CASES)


def test_what_a_filter_admits_keeps_the_believed_robot_inside():
    case = match.Case(0.1, 0.0)
    v = 0.7 * contenders.LIMIT
    force = contenders.nominal_ceiling(case, v) - np.array((39.24, 0.0))

    assert v + case.period * force / np.array((50.0, 5.4)) == pytest.approx(
        contenders.LIMIT, rel=1e-4
    )


@pytest.mark.slow
def test_the_quick_mode_plays_a_law_against_a_predictive_controller(capsys):
    match.main(["--quick"])
    told = capsys.readouterr().out

    assert "## 100 ms, a delay of 50 ms" in told
    assert "| prox + guard | none |" in told
    assert "| NMPC, nominal |" in told


def test_the_adversary_breaks_the_limit_without_a_guard():
    start = np.array((-5.0, -5.0, -0.7, 0.0, 0.0))
    rows = match._rows(SHORT, SHORT.scenario)
    robot = match.Plant(SHORT, {"robot.m": 45.0, "robot.I": 4.86, "robot.mu": 0.0})
    fastest = {}
    for contender in contenders.contenders()[1:3]:
        step = contender.build(SHORT, contender.start(SHORT))
        fastest[contender.name] = match.run(SHORT, step, robot, 2.0, rows, start).fastest

    assert fastest["kanayama + clip"] > 1.02
    assert fastest["kanayama + guard"] <= 1 + 1e-9


def test_on_bases_that_take_velocities_every_filter_keeps_the_limit_and_no_law_alone_does():
    rows = table(MATCH, "velocity")
    found = [(row[0], row[1], row[2]) for row in rows if row[0] in velocity_match.PLAYERS]

    assert [row[:2] for row in found] == [
        (law, way)
        for place in velocity_match.PLACES
        for law in velocity_match.PLAYERS
        for way in place.ways
    ]
    assert all((kept == "none") == (way != "none") for _, way, kept in found)
