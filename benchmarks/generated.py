"""The generated C as candidates for `timing`: steps, calls from Python, closed loops, the VM."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from functools import cache, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray
from wmr_ctrl.codegen.manifest import Kernels
from wmr_ctrl.sim.batch_memory import VectorSet, vector_sets
from wmr_ctrl.sim.structs import loop_struct

from wmr_ctrl.api import compile_loop
from wmr_ctrl.codegen.build import build_loop
from wmr_ctrl.codegen.kernels import loop_systems
from wmr_ctrl.scenario import Scenario, load_scenario
from wmr_ctrl.sim.batch import Task, run_tasks
from wmr_ctrl.sim.compiled_law import CompiledLaw
from wmr_ctrl.sim.native import load, settings_of
from wmr_ctrl.sim.ready import Ready

from .drive import out_of_place, update_only
from .inputs import plant_torques, tracking_rows
from .setup import Setup
from .timing import Candidate

Array = NDArray[np.float64]


@cache
def scenario(control: float = 1e-2) -> Scenario:
    """The paper's simulation with a control period [s]."""
    return load_scenario("paper-simulation", {"clock.control": control})


@cache
def kernels(law: str, control: float = 1e-2) -> Kernels:
    """The compiled loop of a law."""
    return build_loop(scenario(control), law)


def inputs_of(law: str) -> Array:
    """The ring of tracking inputs, with zeros for what a law is given beside (torque applied)."""
    rows = tracking_rows()
    width = kernels(law).manifest["systems"]["controller"]["sizes"]["NU"]
    return np.pad(rows, ((0, 0), (0, width - rows.shape[1])))


def step(law: str, steps: int) -> Candidate:
    """One control sample, in a loop in C, called through a pointer."""
    role = kernels(law).manifest["systems"]["controller"]
    entry = load(kernels(law).library).wmr_export_controller_step
    x, p = np.array([*role["start"], 0.0]), np.array(role["parameter_values"])
    return Candidate(partial(out_of_place(entry, inputs_of(law), x, p, 2), steps), steps)


def call_from_python(law: str, steps: int) -> Candidate:
    """One control sample called from Python, arrays and pointers kept."""
    compiled = CompiledLaw(kernels(law))
    compiled.u[:] = inputs_of(law)[0]
    return Candidate(_repeated(compiled.step, steps), steps)


def virtual_machine(law: str, steps: int) -> Candidate:
    """One control sample by CasADi's virtual machine, through ``Function.call``."""
    item = loop_systems(scenario(), law).controller
    function = item.function("step", [item.update, item.y])
    given = [inputs_of(law)[0], np.array(item.x0), np.array(item.p0)]
    return Candidate(_repeated(lambda: function.call(given), steps), steps)


def closed_loop(law: str, control: float = 1e-3) -> Candidate:
    """80 s of closed loop in C, without a log; a step is one control sample."""
    built = kernels(law, control)
    library, settings, keep = (
        load(built.library),
        *settings_of(built.manifest, scenario(control), 0),
    )
    state = loop_struct(built.manifest["systems"])()

    def run(kept: Any = keep) -> None:
        library.wmr_run(ctypes.byref(settings), ctypes.byref(state), None)

    return Candidate(run, scenario(control).clock.samples)


def _repeated(function: Callable[[], object], steps: int) -> Callable[[], None]:
    def run() -> None:
        for _ in range(steps):
            function()

    return run


def plant_step(steps: int) -> Candidate:
    """One Runge-Kutta step of 1 ms, in a loop in C, under torques that keep it moving."""
    role = kernels("mb").manifest["systems"]["plant"]
    library = load(kernels("mb").library)
    torques = np.pad(plant_torques(Setup(), scenario().clock.plant), ((0, 0), (0, 2)))
    p = np.array(role["parameter_values"])
    start = np.array([0.0, 0.0, 0.0, 0.15, 0.1])
    run = update_only(library.wmr_export_plant_step, torques, start, p)
    return Candidate(partial(run, steps), steps)


def batches(control: float = 1e-3) -> dict[str, Candidate]:
    """NN closed loops side by side on one core; a step is one control sample of one robot.

    ``nn_batch`` takes the best vector instructions of this processor.
    """
    loop = compile_loop(scenario(control), "nn")
    sets = vector_sets(loop.kernels.library)
    found = {f"nn_batch_{item.name}": _batch(loop, item) for item in sets}
    return {"nn_batch": next(iter(found.values())), **found}


def _batch(loop: Ready, vectors: VectorSet) -> Candidate:
    tasks = [Task(loop, seed, vectors=vectors.name) for seed in range(vectors.lanes)]
    samples = loop.scenario.clock.samples * vectors.lanes
    return Candidate(partial(run_tasks, tasks, jobs=1), samples)
