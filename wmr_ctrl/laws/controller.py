"""controller: a law's force mapped onto the wheels, as one sampled System."""

from __future__ import annotations

from dataclasses import replace

from wmr_ctrl.laws.registry import LAWS
from wmr_ctrl.laws.wheel_map import linear_first
from wmr_ctrl.model.dynamics import force_to_wheel
from wmr_ctrl.model.parameters import Parameters
from wmr_ctrl.model.system import Output, System
from wmr_ctrl.scenario import Scenario
from wmr_ctrl.signals import TORQUE


def controller(scenario: Scenario, law: str) -> System:
    """The law, then the map onto the wheels' torque limit: outputs tau_right, tau_left [N m]."""
    core = LAWS[law].build(scenario)
    p = Parameters(scenario, core.params)
    r, half_track, tau_max = p.take("robot.r"), p.take("robot.l"), p.take("actuator.tau_max")
    force = linear_first(core.outputs[0].expr, 2 * tau_max / r, half_track)
    torque = force_to_wheel(r, half_track, force)
    outputs = tuple(Output(signal, torque[i]) for i, signal in enumerate(TORQUE))
    return replace(core, params=p.ports, outputs=outputs)
