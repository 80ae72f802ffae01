"""The filter over real DDS, in Python and in C: bit for bit the graph's and the run's commands."""

from __future__ import annotations

import json

import casadi as ca
import numpy as np
import pytest

from tests.ros2.conftest import OVER_DDS, built_node, report_of
from tests.ros2.lockstep import BASES, CARRIED, COMMON, SMALL, messages, sent_by
from wmr_ctrl import simulate
from wmr_ctrl.filter.gate import gate_system
from wmr_ctrl.ros2.c_node import node_settings
from wmr_ctrl.ros2.compiled_gate import Gate
from wmr_ctrl.scenario import load_scenario, to_toml
from wmr_ctrl.world.registry import EFFECTS

COMPILED = [
    "odometry=none", "trigger=command", "command_timeout=2.0", "rise=[1e6, 1e6]", "fall=[1e6, 1e6]",
    "excess=[1.0, 1.0]",
]  # fmt: skip
CLIP = {**SMALL, "filter.kind": "clip", "clock.control": 0.02}
BLIND = {**BASES["velocity, governor"][1], "filter.odometry": [0.0, 0.0]}
AT_REST, WILD = 1000, 500
LATER = 100_000_000_000
"""Stamp [ns] that is late enough for a clock that runs before the first row."""
SAMPLES = 3000
pytestmark = [pytest.mark.slow, OVER_DDS]


@pytest.fixture(params=["Python", "C"])
def words(request, ros, tmp_path):
    """What starts the filter of a scenario."""

    def node(scenario):
        if request.param == "Python":
            return []
        return [str(built_node(scenario, COMPILED, ros, tmp_path / "node"))]

    return node


def interpreted(scenario, asked):
    """The gate's answers to commands that have just come, by CasADi's virtual machine."""
    system = gate_system(scenario, node_settings(COMPILED).gate)
    step = system.function("gate", [system.update, system.y])
    x, p = ca.DM(system.x0), ca.DM(system.p0)
    for pair in asked:
        x, y = step(ca.DM([*pair, 0, 0, 0, -1, 0, 0, 0]), x, p)
        yield y.full().ravel()[:2]


def compiled(scenario, asked):
    """The same by the compiled graph: the governor's exponentials are not those of CasADi."""
    gate = Gate(scenario, node_settings(COMPILED).gate)
    return (gate.step(pair, 0.0).command for pair in asked)


def answers_of(rows, law, scenario, ros, environment, folder, node):
    path = folder / "rows.json"
    path.write_text(json.dumps(rows), encoding="utf-8")
    text = to_toml(scenario, comments=False)
    report = report_of("filter_lockstep.py", text, ros, environment, folder, path, law, *node)
    assert set(report["codes"]) == {0}
    return report["answers"]


@pytest.mark.parametrize(
    ("changes", "oracle"), [(CLIP, interpreted), (BLIND, compiled)], ids=["clip", "governor"]
)
def test_wild_commands_become_those_of_the_graph(
    ros, environment, tmp_path, words, changes, oracle
):
    scenario = load_scenario("paper-simulation", {**COMMON, **changes})
    asked = np.random.default_rng(0).standard_cauchy((AT_REST + WILD, 2)) * scenario.limits.v_u1
    period = round(scenario.clock.control * 1e9)
    asked[:AT_REST] = 0.0  # what came before the first row is forgotten
    rows = [[*pair, LATER + k * period] for k, pair in enumerate(asked)]
    expected = list(oracle(scenario, asked))
    answers = answers_of(rows, "", scenario, ros, environment, tmp_path, words(scenario))

    assert np.array(answers, dtype=float).tobytes() == np.array(expected).tobytes()
    assert (np.abs(asked) > np.abs(expected))[AT_REST:].mean() > 0.3


def test_behind_the_drive_every_command_is_that_of_the_run(
    ros, environment, tmp_path, words, monkeypatch
):
    changes = {**COMMON, **CLIP, "clock.duration": 0.02 * SAMPLES}
    scenario = load_scenario("paper-simulation", changes)
    monkeypatch.setitem(EFFECTS.__dict__, "plugins", (CARRIED,))
    carried = load_scenario("paper-simulation", {**changes, "message.sent": 1.0})
    run = simulate(carried, "kanayama")
    rows = [[*message, LATER + stamp] for message, stamp in messages(run, carried.clock.control)]
    answers = answers_of(rows, "kanayama", scenario, ros, environment, tmp_path, words(scenario))

    assert len(answers) >= SAMPLES
    assert np.array(answers, dtype=float).tobytes() == sent_by(run).tobytes()
