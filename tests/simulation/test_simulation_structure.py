"""Scenarios of one structure, which differ only in numbers, share graphs and C."""

import dataclasses

import numpy as np
import pytest

from tests.papers_robot import preset
from tests.tables import cases
from wmr_ctrl.codegen import build
from wmr_ctrl.codegen.build import Program, build_batch, numbers_of
from wmr_ctrl.control.loop import LoopGraphs
from wmr_ctrl.control.numbers import structure_of
from wmr_ctrl.control.setup import settle
from wmr_ctrl.core.fields.section import quantities
from wmr_ctrl.simulation.engines import runnable_of
from wmr_ctrl.simulation.many import PREPARING, part, planned_tasks, tabulated
from wmr_ctrl.world.model.system import values
from wmr_ctrl.world.scenario import override

BASES = {
    "plain": "",
    "everything on": """
        disturbance.push = [3.0, 0.5]; disturbance.truncate = 2.0; sensor.pose_period = 0.04
        sensor.pose_noise = 0.01; sensor.velocity_noise = [0.002, 0.004]; actuator.lag = 0.02
        actuator.delay = 0.013; actuator.tau_max = 30.0; guard.enabled = true
    """,
}
TIMES = {"clock.control", "clock.plant", "clock.duration", "actuator.delay", "actuator.lag"}
FIXED = {*TIMES, "sensor.pose_period", "limits.v_min", "limits.v_max"}
"""Keys whose values are numbers of the graph: all times, which set the weights of past commands.
Separate limits by direction make another graph."""
TABLES = ("robot", "limits", "initial", "disturbance", "sensor", "actuator")


def nudged(base, law):
    """All numbers of a scenario a little larger, where they are not 0 or infinite."""
    changes = {}
    for key in TABLES:
        part = base.table(key)
        for name, what in quantities(type(part)):
            old = getattr(part, name)
            if f"{key}.{name}" not in FIXED and (isinstance(old, float) or what.size):
                changes[f"{key}.{name}"] = _larger(old, what.bounds.maximum)
    gains = settle(base, law).gains
    for item in dataclasses.fields(gains):
        old = getattr(gains, item.name)
        if isinstance(old, float | tuple):
            changes[f"gains.{law}.{item.name}"] = _larger(old, None)
    return override(base, changes)


def _larger(old, most):
    if isinstance(old, tuple):
        return [_larger(number, most) for number in old]
    return old if old in (0.0, np.inf) or most is not None else float(old) * 1.001


@pytest.mark.parametrize(
    "law, base",
    cases("mb | everything on\nprox | plain\nnn | everything on | slow\nkanayama | plain | slow"),
)
def test_numbers_are_no_part_of_the_structure(law, base):
    """The graphs' text is the same, and the numbers by key are those of a newly built graph."""
    first = preset("paper-simulation", BASES[base])
    one, other = settle(first, law), settle(nudged(first, law), law)
    texts = [Program(item, structure_of(item)).generated for item in (one, other)]
    fresh = LoopGraphs(other)
    signals = tuple(item.signal for item in fresh.parameters.ports)

    assert structure_of(one) == structure_of(other)
    assert texts[0] == texts[1]
    assert list(numbers_of(other, signals)) == values(fresh.parameters.ports)
    assert numbers_of(one, signals) != numbers_of(other, signals)


@pytest.mark.parametrize(
    "one, other",
    cases("""
        robot.mu = 0.08 | actuator.lag = 0.01
        robot.mu = 0.08 | actuator.delay = 0.02
        robot.mu = 0.08 | guard.enabled = true
        robot.mu = 0.08 | gains.nn.barrier = "smooth"
        robot.mu = 0.08 | reference.kind = "line"
        encoder.window = 0.02 | encoder.window = 0.03
        sensor.pose_delay = 0.02 | sensor.pose_delay = 0.03
        guard.enabled = true | guard.enabled = true; guard.map = "rotation-first"
    """),
)
def test_what_changes_the_graphs_changes_the_structure(one, other):
    """Drives, guard and its map, kinds, and the number of samples that an effect stores."""
    seeing = "encoder.counts = 512; sensor.pose_period = 0.05"
    first, second = (preset("paper-simulation", seeing, told) for told in (one, other))

    assert structure_of(settle(first, "nn")) != structure_of(settle(second, "nn"))


def test_a_sweep_over_numbers_builds_its_graphs_once(monkeypatch):
    made = []

    def graphs(*given, **named):
        made.append(given)
        return LoopGraphs(*given, **named)

    monkeypatch.setattr(build, "LoopGraphs", graphs)
    monkeypatch.setattr(build, "_PROGRAMS", {})
    masses = [f"robot.m = {40 + k}; clock.duration = 0.1; changes = []" for k in range(20)]
    scenarios = [preset("paper-simulation", mass) for mass in masses]

    def ready(scenario):
        setup = settle(scenario, "mb")
        return runnable_of(build_batch(setup), setup)

    shares = []
    tasks = planned_tasks(ready, scenarios, [0] * 20, None, shares.append)
    table = tabulated(tasks, progress=part(shares.append, PREPARING))

    assert len(made) == 1
    assert len(set(table["ise_total"])) == 20
    assert shares[0] == 0.0
    assert shares == sorted(shares)
