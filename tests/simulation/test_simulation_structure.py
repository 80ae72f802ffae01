"""Scenarios of one structure share graphs and C: whatever differs in numbers alone."""

import dataclasses

import numpy as np
import pytest

from wmr_ctrl.codegen import build
from wmr_ctrl.codegen.build import Program, build_batch, numbers_of
from wmr_ctrl.control.loop import LoopGraphs
from wmr_ctrl.control.numbers import structure_of
from wmr_ctrl.control.setup import settle
from wmr_ctrl.core.fields.section import quantities
from wmr_ctrl.simulation.engines import runnable_of
from wmr_ctrl.simulation.many import PREPARING, part, planned_tasks, tabulated
from wmr_ctrl.world.model.system import values
from wmr_ctrl.world.scenario import load_scenario, override

BASES = {
    "plain": {},
    "everything on": {
        "disturbance.push": [3.0, 0.5], "disturbance.truncate": 2.0, "sensor.pose_period": 0.04,
        "sensor.pose_noise": 0.01, "sensor.velocity_noise": [0.002, 0.004], "actuator.lag": 0.02,
        "actuator.delay": 0.013, "actuator.tau_max": 30.0, "guard.enabled": True,
    },
}  # fmt: skip
TIMES = {"clock.control", "clock.plant", "clock.duration", "actuator.delay", "actuator.lag"}
FIXED = {*TIMES, "sensor.pose_period", "limits.v_min", "limits.v_max"}
"""What a past command counts for is a number of the graph, and so are all times that it has.
What limits each direction by itself makes another graph."""
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
    [
        ("mb", "everything on"),
        ("prox", "plain"),
        pytest.param("nn", "everything on", marks=pytest.mark.slow),
        pytest.param("kanayama", "plain", marks=pytest.mark.slow),
    ],
)
def test_numbers_are_no_part_of_the_structure(law, base):
    """The graphs' text is the same, and the numbers by key are those of a graph built anew."""
    first = load_scenario("paper-simulation", BASES[base])
    one, other = settle(first, law), settle(nudged(first, law), law)
    texts = [Program(item, structure_of(item)).generated for item in (one, other)]
    fresh = LoopGraphs(other)
    signals = tuple(item.signal for item in fresh.parameters.ports)

    assert structure_of(one) == structure_of(other)
    assert texts[0] == texts[1]
    assert list(numbers_of(other, signals)) == values(fresh.parameters.ports)
    assert numbers_of(one, signals) != numbers_of(other, signals)


COUNTED = {"encoder.counts": 512}
SEEN = {"sensor.pose_period": 0.05}
GUARDED = {"guard.enabled": True}


@pytest.mark.parametrize(
    "one, other",
    [
        ({}, {"actuator.lag": 0.01}),
        ({}, {"actuator.delay": 0.02}),
        ({}, GUARDED),
        ({}, {"gains.nn.barrier": "smooth"}),
        ({}, {"reference.kind": "line"}),
        ({**COUNTED, "encoder.window": 0.02}, {**COUNTED, "encoder.window": 0.03}),
        ({**SEEN, "sensor.pose_delay": 0.02}, {**SEEN, "sensor.pose_delay": 0.03}),
        (GUARDED, {**GUARDED, "guard.map": "rotation-first"}),
    ],
    ids=str,
)
def test_what_changes_the_graphs_changes_the_structure(one, other):
    """Drives, guard and its map, kinds, and how many samples an effect remembers."""
    first, second = (
        settle(load_scenario("paper-simulation", given), "nn") for given in (one, other)
    )

    assert structure_of(first) != structure_of(second)


def test_a_sweep_over_numbers_builds_its_graphs_once(monkeypatch):
    made = []

    class Counted(LoopGraphs):
        def __init__(self, *given, **named):
            made.append(given)
            super().__init__(*given, **named)

    monkeypatch.setattr(build, "LoopGraphs", Counted)
    monkeypatch.setattr(build, "_PROGRAMS", {})
    masses = [{"robot.m": 40.0 + k, "clock.duration": 0.1} for k in range(20)]
    scenarios = [load_scenario("paper-simulation", mass) for mass in masses]

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
