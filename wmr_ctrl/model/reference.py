"""The desired trajectory of a scenario as a System without state."""

from __future__ import annotations

import casadi as ca

from wmr_ctrl.model.references import trajectory_of
from wmr_ctrl.model.system import Output, System, port
from wmr_ctrl.scenario import Scenario
from wmr_ctrl.signals import REFERENCE, TIME


def reference(scenario: Scenario) -> System:
    """System from time t [s] to the seven reference signals; numbers stay parameters."""
    kind = trajectory_of(scenario.reference)
    time = port(TIME)
    params = tuple(port(signal, value) for signal, value in kind.parameters(scenario.reference))
    table = {item.signal.name: item.sym for item in params}
    path = kind.trajectory(time.sym, table)
    outputs = tuple(Output(signal, path[i]) for i, signal in enumerate(REFERENCE))
    return System("reference", "desired trajectory", (time,), (), params, ca.SX(0, 1), outputs)
