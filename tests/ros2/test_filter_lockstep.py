"""The filter over real DDS, in Python and in C: bit for bit the graph's and the run's commands."""

from __future__ import annotations

from functools import cache

import casadi as ca
import numpy as np
import pytest

from tests.ros2.conftest import OVER_DDS, in_both
from tests.ros2.lockstep import BASES, COMMON, SMALL, carried_run, messages, sent_by
from wmr_ctrl.control.filter.gate import gate_system
from wmr_ctrl.ros2.c_node import node_settings
from wmr_ctrl.ros2.compiled_system import Gate
from wmr_ctrl.world.scenario import load_scenario, to_toml

COMPILED = (
    "trigger=command", "command_timeout=60.0", "odometry_timeout=60.0", "rise=[1e6, 1e6]",
    "fall=[1e6, 1e6]", "excess=[1.0, 1.0]",
)  # fmt: skip
CLIP = {**SMALL, "filter.kind": "clip", "clock.control": 0.02}
GOVERNOR = BASES["velocity, governor"][1]
AT_REST, WILD = 300, 100
LATER = 100_000_000_000
"""Stamp [ns] that is late enough for a clock that runs before the first row."""
WILDLY = {
    "clip": (CLIP, "none"),
    "governor without odometry": ({**GOVERNOR, "filter.odometry": [0.0, 0.0]}, "none"),
    "governor with odometry": (GOVERNOR, "watched"),
}
BEHIND = {"clip": (CLIP, "none", 200), "governor with odometry": (GOVERNOR, "watched", 200)}
"""Changes, what the filter does with odometry, and samples of a run behind the drive."""
pytestmark = [pytest.mark.slow, OVER_DDS]


def gate_of(changes, odometry):
    scenario = load_scenario("paper-simulation", {**COMMON, **changes})
    return scenario, node_settings([*COMPILED, f"odometry={odometry}"]).gate


def asked_of(scenario):
    asked = np.random.default_rng(0).standard_cauchy((AT_REST + WILD, 2)) * scenario.limits.v_u1
    asked[:AT_REST] = 0.0  # what came before the first row is forgotten
    return asked


@cache
def wild(name):
    """Rows for the filter, and the answers of the graph: to the clip by CasADi's virtual machine.

    The governor's exponentials are not those of CasADi, so its graph is compiled.  Its odometry is
    that of a base which loses a third of what is missing each period.
    """
    changes, odometry = WILDLY[name]
    scenario, settings = gate_of(changes, odometry)
    asked = asked_of(scenario)
    stamps = LATER + round(scenario.clock.control * 1e9) * np.arange(len(asked))
    if name == "clip":
        expected = list(interpreted(gate_system(scenario, settings), asked))
        rows = [[*pair, int(stamp)] for pair, stamp in zip(asked, stamps, strict=True)]
        return rows, np.array(expected)
    gate, rows, expected, speed = Gate(scenario, settings), [], [], np.zeros(2)
    for pair, stamp in zip(asked, stamps, strict=True):
        seen = (tuple(speed), 0.0) if odometry != "none" else ((0.0, 0.0), -1.0)
        expected.append(gate.step(pair, 0.0, *seen).command)
        rows.append([*pair, *(speed if odometry != "none" else ()), int(stamp)])
        speed = speed + (np.array(expected[-1]) - speed) / 3
    return rows, np.array(expected)


def interpreted(system, asked):
    step = system.function("gate", [system.update, system.y])
    x, p = ca.DM(system.x0), ca.DM(system.p0)
    for pair in asked:
        x, y = step(ca.DM([*pair, 0, 0, 0, -1, 0, 0, 0]), x, p)
        yield y.full().ravel()[:2]


@cache
def behind(name):
    """Rows for the drive, and the commands of the run that they are of."""
    changes, _, samples = BEHIND[name]
    period = changes["clock.control"]
    run = carried_run({**COMMON, **changes, "clock.duration": period * samples}, "kanayama")
    rows = [[*message, LATER + stamp] for message, stamp in messages(run, period)]
    assert len(rows) >= samples
    return rows, sent_by(run)


def JOBS():
    jobs = {}
    for what, names, rows_of in (("wild", WILDLY, wild), ("behind", BEHIND, behind)):
        for name, (changes, odometry, *_) in names.items():
            text = to_toml(gate_of(changes, odometry)[0], comments=False)
            words = ("{rows}", "-" if what == "wild" else "kanayama", odometry)
            compiled = (*COMPILED, f"odometry={odometry}")
            both = in_both("filter_lockstep.py", text, words, compiled, rows_of(name)[0])
            jobs |= {f"{what}, {name}, {node}": job for node, job in both.items()}
    return jobs


@pytest.mark.parametrize("node", ["Python", "C"])
@pytest.mark.parametrize("name", WILDLY)
def test_wild_commands_become_those_of_the_graph(report, name, node):
    rows, expected = wild(name)
    found = report(f"wild, {name}, {node}")

    assert set(found["codes"]) == {0}
    assert np.array(found["answers"], dtype=float).tobytes() == expected.tobytes()
    asked = np.array([row[:2] for row in rows])
    assert (np.abs(asked) > np.abs(expected))[AT_REST:].mean() > 0.3


@pytest.mark.parametrize("node", ["Python", "C"])
@pytest.mark.parametrize("name", BEHIND)
def test_behind_the_drive_every_command_is_that_of_the_run(report, name, node):
    _, expected = behind(name)
    found = report(f"behind, {name}, {node}")

    assert set(found["codes"]) == {0}
    assert np.array(found["answers"], dtype=float).tobytes() == expected.tobytes()


def test_odometry_changes_what_the_governor_sends():
    """Else the claim with odometry would be the one without."""
    _, with_it = wild("governor with odometry")
    _, without = wild("governor without odometry")

    assert (with_it != without)[AT_REST:].mean() > 0.3
