"""Engines: from a checked scenario and a law to one Run, compiled or by NumPy, or to many."""

from collections.abc import Sequence
from functools import partial

from wmr_ctrl.codegen.build import build_batch, build_gpu, build_loop, build_plantless
from wmr_ctrl.codegen.functions import loop_functions
from wmr_ctrl.control.setup import Setup, settle
from wmr_ctrl.core.compiled import CompiledLoop
from wmr_ctrl.core.errors import ArgumentError, UnknownNameError
from wmr_ctrl.results import PLANTS, Run, RunTable
from wmr_ctrl.world.scenario import Scenario

from .batch import Progress
from .gpu import processor
from .interpreted import run_interpreted
from .many import PREPARING, each_task, part, planned_tasks, run_each, tabulated
from .memory import Task
from .physics.rigid import mujoco
from .physics.run import rigid_table, run_rigid_each
from .runnable import RunnableLoop, assemble_run, settings_of

DEVICES = ("cpu", "gpu")
"""Where many runs are made: in vectors on this processor's cores, or on a graphics processor."""


def runnable(scenario: Scenario, law: str, plant: str = "ode", device: str = "cpu") -> RunnableLoop:
    """The closed loop of a law, for many runs at a time on a device.  Raises as `settle` does.

    For the rigid body it is that of one robot, compiled without its plant.
    """
    setup = settle(scenario, law)
    build = build_plantless if plant == "mujoco" else build_gpu if device == "gpu" else build_batch
    return runnable_of(build(setup), setup)


def run_compiled(scenario: Scenario, law: str, seed: int) -> Run:
    """One run of the loop compiled for one robot."""
    setup = settle(scenario, law)
    loop = runnable_of(build_loop(setup), setup)
    (run,) = each_task([Task(loop, seed)], lambda _, run: run, 1, engine="native")
    return run


def run_numpy(scenario: Scenario, law: str, seed: int, progress: Progress | None = None) -> Run:
    """One run of the loop's graphs without a compiler.  Raises as `settle` does."""
    setup = settle(scenario, law)
    loop = loop_functions(setup)
    columns, monitor = run_interpreted(loop, seed, settings_of(setup.scenario), progress)
    logged = (loop.numbers.layout.columns, columns, monitor)
    facts = {"kernel_hash": ""}
    return assemble_run(scenario, law, seed, "numpy", logged, facts, setup.assumptions)


def runs_of(
    plant: str,
    scenario: Scenario,
    law: str,
    seeds: Sequence[int],
    jobs: int | None = None,
    progress: Progress | None = None,
    device: str = "cpu",
) -> list[Run]:
    """A full Run per seed on that plant; errors as `run_each` and `run_rigid_each` raise."""
    loop, run_all = runnable(scenario, law, plant, device), run_each
    if plant == "mujoco":
        run_all = run_rigid_each
    return run_all([(loop, seed) for seed in seeds], lambda _, run: run, jobs, progress)


def table_of(
    plant: str,
    scenarios: Sequence[Scenario],
    law: str,
    seeds: Sequence[int],
    starts: Sequence[Sequence[float]] | None = None,
    figures: Sequence[str] = (),
    jobs: int | None = None,
    progress: Progress | None = None,
    device: str = "cpu",
) -> RunTable:
    """Figures of a run per seed on that plant; errors as `planned_tasks` and the makers raise."""
    build, tabulate = partial(runnable, law=law, plant=plant, device=device), tabulated
    if plant == "mujoco":
        mujoco()
        tabulate = partial(rigid_table, build=build)
    tasks = planned_tasks(build, scenarios, seeds, starts, progress)
    return tabulate(tasks, figures, jobs, part(progress, PREPARING))


def runnable_of(compiled: CompiledLoop, setup: Setup) -> RunnableLoop:
    """A compiled loop with the scenario, law and assumptions of its setup."""
    return RunnableLoop(compiled, setup.scenario, setup.name, setup.assumptions)


def check_device(device: str, plant: str = "ode", *, here: bool = True) -> None:
    """Raise unless device and plant exist, and the device works if it is needed ``here``.

    UnknownNameError, ArgumentError (both together), MissingExtraError or DeviceError.
    """
    check_plant(plant)
    if device not in DEVICES:
        raise UnknownNameError("device", device, DEVICES)
    if device == "gpu" and plant != "ode":
        raise ArgumentError(
            f"device = 'gpu' runs the plant ode alone, and the plant is {plant!r}. Leave out the "
            "device, or choose the plant ode."
        )
    if device == "gpu" and here:
        processor()


def check_plant(plant: str, engine: str = "native") -> None:
    """Raise UnknownNameError or ArgumentError unless the plant exists and the engine runs it."""
    if plant not in PLANTS:
        raise UnknownNameError("plant", plant, PLANTS)
    if plant != "ode" and engine != "native":
        raise ArgumentError(
            f"the plant {plant!r} works only with compiled laws, and the engine is {engine!r}. "
            "Choose the engine native, or the plant ode."
        )
