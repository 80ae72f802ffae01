"""The laws that have a NumPy twin."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from wmr_ctrl.errors import ArgumentError
from wmr_ctrl.scenario import Scenario
from wmr_ctrl.sim.oracle.kanayama import Kanayama
from wmr_ctrl.sim.oracle.law import Law
from wmr_ctrl.sim.oracle.mb import ModelBased
from wmr_ctrl.sim.oracle.nn import NeuralNetwork
from wmr_ctrl.sim.oracle.pid import Pid
from wmr_ctrl.sim.oracle.prox import Prox
from wmr_ctrl.sim.oracle.smc import Smc

TWINS: dict[str, Callable[[Mapping[str, Any], Scenario], Law]] = {
    "pid": Pid,
    "smc": Smc,
    "mb": ModelBased,
    "nn": NeuralNetwork,
    "prox": Prox,
    "kanayama": Kanayama,
}


def build_law(name: str, gains: Mapping[str, Any], scenario: Scenario) -> Law:
    """The twin of law ``name`` with its resolved gains; ArgumentError if it has none."""
    if name not in TWINS:
        raise ArgumentError(
            f"the numpy engine knows only the laws {', '.join(TWINS)}, and was asked for {name!r}; "
            "the native engine serves any law (engine native)."
        )
    return TWINS[name](gains, scenario)
