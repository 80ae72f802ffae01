"""wmr_ctrl: velocity-constrained control of wheeled mobile robots, from laws to reports.

>>> import wmr_ctrl
>>> run = wmr_ctrl.simulate("paper-simulation", "nn", seed=3)  # doctest: +SKIP
>>> print(run.outcome)  # doctest: +SKIP

Public names are loaded when they are first used, so that importing the package costs little.
"""

from __future__ import annotations

from importlib import import_module

from wmr_ctrl.version import __version__ as __version__

TYPE_CHECKING = False
if TYPE_CHECKING:  # said without the module typing, which costs more than all else here
    from wmr_ctrl.api import (
        Run,
        Scenario,
        compile_law,
        cosimulate,
        export_fmu,
        linearize,
        load_run,
        load_scenario,
        prove,
        reproduce,
        simulate,
        simulate_many,
        simulate_runs,
        study,
        write_page,
    )
    from wmr_ctrl.control.filter import command_filter
    from wmr_ctrl.identification import identify
    from wmr_ctrl.results.bag_topics import load_drive
    from wmr_ctrl.results.compare import compare
    from wmr_ctrl.results.drive import RecordedDrive
    from wmr_ctrl.simulation.tuning import tune

__all__ = [
    "RecordedDrive", "Run", "Scenario", "command_filter", "compare", "compile_law", "cosimulate",
    "export_fmu", "identify", "linearize", "load_drive", "load_run", "load_scenario", "prove",
    "reproduce", "simulate", "simulate_many", "simulate_runs", "study", "tune", "write_page",
]  # fmt: skip
_HOMES = {
    "RecordedDrive": "results.drive", "command_filter": "control.filter", "compare": "results.compare",
    "identify": "identification", "load_drive": "results.bag_topics", "tune": "simulation.tuning",
}  # fmt: skip
"""Modules of the names that are not in api.py."""


def __getattr__(name: str) -> object:
    """Load a public name from where it is defined, once."""
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    home = _HOMES.get(name, "api")
    value = getattr(import_module(f"wmr_ctrl.{home}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
