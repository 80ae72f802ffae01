"""The generated C as candidates for `timing`: steps, calls from Python, closed loops, the VM."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache, partial

import numpy as np
from numpy.typing import NDArray

from wmr_ctrl.codegen.build import build_law, build_loop
from wmr_ctrl.control.controller import watched_controller
from wmr_ctrl.control.setup import Setup as Settled
from wmr_ctrl.control.setup import settle
from wmr_ctrl.core.compiled import CompiledLoop
from wmr_ctrl.core.errors import ArgumentError
from wmr_ctrl.core.signals import elements
from wmr_ctrl.simulation.batch import run_tasks
from wmr_ctrl.simulation.compiled_law import CompiledLaw
from wmr_ctrl.simulation.engines import runnable, runnable_of
from wmr_ctrl.simulation.memory import Task, laid_out, load, opened, vector_sets
from wmr_ctrl.world.scenario import Scenario, load_scenario

from .drive import out_of_place, plant_only
from .inputs import plant_torques, tracking_rows
from .setup import Setup
from .timing import Candidate

Array = NDArray[np.float64]


@cache
def scenario(control: float = 1e-2) -> Scenario:
    """The paper's simulation with a control period [s]."""
    return load_scenario("paper-simulation", {"clock.control": control})


@cache
def settled(law: str, control: float = 1e-2) -> Settled:
    """Settled scenario with a law."""
    return settle(scenario(control), law)


@cache
def compiled(law: str, control: float = 1e-2) -> CompiledLoop:
    """The compiled loop of a law."""
    return build_loop(settled(law, control), watched=True)


@cache
def compiled_law(law: str) -> CompiledLoop:
    """The compiled controller of a law by itself."""
    return build_law(settled(law))


def inputs_of(law: str) -> Array:
    """Ring of tracking inputs, padded with zeros for a law's other inputs (torque applied)."""
    rows = tracking_rows()
    width = len(elements(compiled(law).law.inputs))
    return np.pad(rows, ((0, 0), (0, width - rows.shape[1])))


def step(law: str, steps: int) -> Candidate:
    """One control sample, in a loop in C, called through a pointer."""
    numbers = compiled(law).law
    entry = opened(compiled_law(law).library).wmr_export_controller
    x, p = np.array([*numbers.start, 0.0]), np.array(numbers.values)
    return Candidate(partial(out_of_place(entry, inputs_of(law), x, p, 2), steps), steps)


def call_from_python(law: str, steps: int) -> Candidate:
    """One control sample called from Python, arrays and pointers kept."""
    one = CompiledLaw(compiled_law(law))
    one.u[:] = inputs_of(law)[0]
    return Candidate(_repeated(one.step, steps), steps)


def virtual_machine(law: str, steps: int) -> Candidate:
    """One control sample by CasADi's virtual machine, through ``Function.call``."""
    item = watched_controller(settled(law))
    function = item.function("step", [item.update, item.y])
    given = [inputs_of(law)[0], np.array(item.x0), np.array(item.p0)]
    return Candidate(_repeated(lambda: function.call(given), steps), steps)


def closed_loop(law: str, control: float = 1e-3) -> Candidate:
    """80 s of closed loop in C, without a log; a step is one control sample."""
    setup = settled(law, control)
    loop = runnable_of(compiled(law, control), setup)
    return Candidate(laid_out([Task(loop, 0)], []).run, scenario(control).clock.samples)


EXACT: Mapping[str, object] = {
    "encoder.counts": None,
    "gyro.enabled": False,
    "sensor.pose_period": 0.0,
    "sensor.pose_noise": 0.0,
    "sensor.correction": 1.0,
}
"""Overrides that remove all sensor errors from the preset robot-10ms."""


def robot(changes: Mapping[str, object]) -> Candidate:
    """80 s of the guarded NN loop of robot-10ms with some changes; a step is one control sample."""
    setup = settle(load_scenario("robot-10ms", changes), "nn")
    loop = runnable_of(build_loop(setup, watched=True), setup)
    return Candidate(laid_out([Task(loop, 0)], []).run, setup.scenario.clock.samples)


def _repeated(function: Callable[[], object], steps: int) -> Callable[[], None]:
    def run() -> None:
        for _ in range(steps):
            function()

    return run


def plant_step(steps: int) -> Candidate:
    """One Runge-Kutta step of 1 ms, in a loop in C, under torques that keep it moving."""
    loop = compiled("mb")
    torques = np.pad(plant_torques(Setup(), scenario().clock.plant), ((0, 0), (0, 2)))
    start = np.array([0.0, 0.0, 0.0, 0.15, 0.1])
    entry = load(loop.library).wmr_export_step
    run = plant_only(entry, torques, start, np.array(loop.parameters[0]))
    return Candidate(partial(run, steps), steps)


def batch(name: str | None = None, control: float = 1e-3) -> Candidate:
    """NN closed loops side by side on one core; a step is one control sample of one robot.

    ``name``: of the vector instructions, else the best of this processor.
    """
    loop = runnable(scenario(control), "nn")
    sets = vector_sets(loop.compiled.library)
    vectors = next((item for item in sets if name in (None, item.name)), None)
    if vectors is None:
        raise ArgumentError(f"no loop for {name} was built, or this processor has no {name}")
    tasks = [Task(loop, seed, vectors=vectors.name) for seed in range(vectors.lanes)]
    samples = loop.scenario.clock.samples * vectors.lanes
    return Candidate(partial(run_tasks, tasks, jobs=1), samples)
