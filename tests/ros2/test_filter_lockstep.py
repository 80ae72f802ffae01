"""The filter over real DDS, in Python and in C: bit for bit the graph's and the run's commands."""

from functools import cache

import numpy as np
import pytest

from tests.ros2.conftest import OVER_DDS, in_both
from tests.ros2.lockstep import BASES, COMMON, START, carried_run, messages, sent_by
from wmr_ctrl.ros2.c_node import node_settings
from wmr_ctrl.ros2.compiled_system import Gate
from wmr_ctrl.world.scenario import load_scenario, to_toml

SETTINGS = (
    "trigger=command", "command_timeout=60.0", "odometry_timeout=60.0", "rise=[1e6, 1e6]",
    "fall=[1e6, 1e6]", "excess=[1.0, 1.0]", "odometry=watched",
)  # fmt: skip
GOVERNOR = BASES["velocity, governor"][1]
AT_REST, WILD = 300, 100
SAMPLES = 200
"""Number of samples of a run behind the drive."""
pytestmark = [pytest.mark.slow, OVER_DDS]


@cache
def wild():
    """Scenario, rows for the filter, and the answers of the compiled graph.

    Odometry is that of a base that covers a third of the remaining difference each period.
    """
    scenario = load_scenario("paper-simulation", {**COMMON, **GOVERNOR})
    asked = np.random.default_rng(0).standard_cauchy((AT_REST + WILD, 2)) * scenario.limits.v_u1
    asked[:AT_REST] = 0.0  # what came before the first row is forgotten
    stamps = START + round(scenario.clock.control * 1e9) * np.arange(len(asked))
    gate, rows = Gate(scenario, node_settings(SETTINGS).gate), []
    expected, speed = [], np.zeros(2)
    for pair, stamp in zip(asked, stamps, strict=True):
        expected.append(gate.step(pair, 0.0, tuple(speed), 0.0).command)
        rows.append([*pair, *speed, int(stamp)])
        speed = speed + (np.array(expected[-1]) - speed) / 3
    return scenario, rows, np.array(expected)


@cache
def behind():
    """Rows for the drive, and the commands of the same run."""
    period = float(GOVERNOR["clock.control"])
    run = carried_run({**COMMON, **GOVERNOR, "clock.duration": period * SAMPLES}, "kanayama")
    rows = [[*message, stamp] for message, stamp in messages(run, period)]
    assert len(rows) >= SAMPLES
    return rows, sent_by(run)


def JOBS():
    scenario, rows, _ = wild()
    text = to_toml(scenario, comments=False)

    def jobs(law, rows):
        return in_both("lockstep_outside.py", text, ("{rows}", law), SETTINGS, rows)

    found = {f"wild, {node}": job for node, job in jobs("-", rows).items()}
    return found | {"behind": jobs("kanayama", behind()[0])["C"]}


@pytest.mark.parametrize("node", ["Python", "C"])
def test_wild_commands_become_those_of_the_graph(report, node):
    _, rows, expected = wild()
    found = report(f"wild, {node}")

    assert (set(found["codes"]), found["last"]) == ({0}, [0.0, 0.0])
    assert np.array(found["answers"], dtype=float).tobytes() == expected.tobytes()
    asked = np.array([row[:2] for row in rows])
    assert (np.abs(asked) > np.abs(expected))[AT_REST:].mean() > 0.3


def test_behind_the_drive_every_command_is_that_of_the_run(report):
    _, expected = behind()
    found = report("behind")

    assert (set(found["codes"]), found["last"]) == ({0}, [0.0, 0.0])
    assert np.array(found["answers"], dtype=float).tobytes() == expected.tobytes()
