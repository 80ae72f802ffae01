"""Engines: from a checked scenario and a law to a Run, compiled or by NumPy."""

from __future__ import annotations

from collections.abc import Callable

from wmr_ctrl.codegen.build import build_batch, build_loop, build_plantless
from wmr_ctrl.compiled import CompiledLoop
from wmr_ctrl.control.controller import watched_controller
from wmr_ctrl.control.setup import Setup, settle
from wmr_ctrl.errors import ArgumentError, UnknownNameError
from wmr_ctrl.laws.sample import own_diagnostics
from wmr_ctrl.results import Monitor, Run
from wmr_ctrl.scenario import Scenario
from wmr_ctrl.signals import LOG_HEAD
from wmr_ctrl.sim.finish import finished
from wmr_ctrl.sim.native import run_native
from wmr_ctrl.sim.oracle import simulate_oracle
from wmr_ctrl.sim.ready import Ready

PLANTS = ("ode", "mujoco")


def ready_batch(scenario: Scenario, law: str) -> Ready:
    """The closed loop of a law, compiled for many runs at a time.  Raises as `settle` does."""
    setup = settle(scenario, law)
    return ready_of(build_batch(setup), setup)


def run_compiled(scenario: Scenario, law: str, seed: int) -> Run:
    """One run of the loop that is compiled for one robot."""
    setup = settle(scenario, law)
    loop = ready_of(build_loop(setup), setup)
    columns, monitor = run_native(loop, seed)
    logged = (loop.compiled.layout.columns, columns, monitor)
    facts = {"kernel_hash": loop.compiled.digest}
    return finished(scenario, law, seed, "native", logged, facts, loop.bounds)


def ready_plantless(scenario: Scenario, law: str) -> Ready:
    """The loop of a law for one robot, compiled without its plant.  Raises as `settle` does."""
    setup = settle(scenario, law)
    return ready_of(build_plantless(setup), setup)


def run_numpy(
    scenario: Scenario, law: str, seed: int, progress: Callable[[float], None] | None = None
) -> Run:
    """One run by NumPy: slow, and without a compiler.

    Raises ArgumentError for a law, reference or effect that has no twin there.
    """
    setup = settle(scenario, law)
    own = {signal.name: signal for signal in own_diagnostics(watched_controller(setup))}
    gains, kinematics = vars(setup.gains), vars(setup.kinematics)
    effects = [item.name for item in setup.effects]
    columns, numbers = simulate_oracle(
        setup.scenario, law, gains, kinematics, seed, progress, effects
    )
    signals = (*LOG_HEAD, *(own[name] for name in columns if name in own))
    logged = (signals, columns, Monitor(**numbers))
    facts = {"kernel_hash": ""}
    return finished(scenario, law, seed, "numpy", logged, facts, setup.assumptions)


def ready_of(compiled: CompiledLoop, setup: Setup) -> Ready:
    """What was compiled from a setup, with that setup's scenario, law and assumptions."""
    return Ready(compiled, setup.scenario, setup.name, setup.assumptions)


def check_plant(plant: str, engine: str = "native") -> None:
    """Raise UnknownNameError or ArgumentError unless there is such a plant and it runs it."""
    if plant not in PLANTS:
        raise UnknownNameError("plant", plant, PLANTS)
    if plant != "ode" and engine != "native":
        raise ArgumentError(
            f"the plant {plant!r} runs beside compiled laws only, and the engine asked for is "
            f"{engine!r}. Take the engine native, or the plant ode."
        )
