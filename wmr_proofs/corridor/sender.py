"""Loop of a base that takes velocities: its command and its plant step, away from all limits.

The command is the graph of the controller without its filter (ledger: corridor.filter).  The base
is its plant step without the effects that `idle_base` omits; each of these is a condition on the
command or a bounded error of it.
"""

from collections.abc import Iterator
from dataclasses import replace

import casadi as ca
import numpy as np

from wmr_ctrl.control.filter.filter import passing_commands
from wmr_ctrl.control.laws.law import Inside
from wmr_ctrl.control.setup import Setup, settle
from wmr_ctrl.control.velocity import SentVelocity
from wmr_ctrl.core.signals import ASKED, TORQUE
from wmr_ctrl.theory.checks.error_coordinates import Floats
from wmr_ctrl.theory.checks.surroundings import idle_base
from wmr_ctrl.world.model.dynamics import force_to_wheel
from wmr_ctrl.world.model.system import Output, Parameters, Port, System
from wmr_ctrl.world.phases import drag
from wmr_ctrl.world.scenario import Scenario
from wmr_ctrl.world.speed_loop_pi import INTEGRAL

from .condition import Asked, Condition


def sending(setup: Setup, law: Inside, asked: Asked) -> tuple[System, list[Condition]]:
    """The command that a law sends away from its limits, and the conditions under which no limit
    changes it.
    """
    core = law.system
    plain = settle(idle_base(setup.scenario), setup.name)
    sender = SentVelocity(plain, core, Parameters(plain, core.params), core.outputs[0].expr)
    limits = [] if core.outputs[0].signal == ASKED else asked(core.outputs[0].expr, sender.v)
    system = replace(sender.system(), outputs=(Output(ASKED, sender.asked),), diagnostics=())
    return system, [*limits, *_passing(setup, sender.asked)]


def _passing(setup: Setup, command: ca.SX) -> Iterator[Condition]:
    """Conditions under which filter and firmware leave a ``command`` (2) unchanged."""
    scenario = setup.scenario
    for name, row, (low, high) in passing_commands(scenario):
        value = row[0] * command[0] + row[1] * command[1] - (low + high) / 2
        yield Condition(f"the filter's limit ({name})", value, ca.SX((high - low) / 2))
    if np.isfinite(scenario.base.w_max):
        base = scenario.base
        off = base.quantum[0] / 2 + base.deadband[0]
        off += scenario.robot.l * (base.quantum[1] / 2 + base.deadband[1])
        rim = (scenario.robot.r * base.w_max - off) * (1 - 1e-15)
        for side, way in (("right", 1), ("left", -1)):
            speed = command[0] + way * scenario.robot.l * command[1]
            yield Condition(f"the firmware's limit of the {side} wheel's speed", speed, ca.SX(rim))


def balanced(scenario: Scenario, state: tuple[Port, ...], v_d: Floats) -> Floats:
    """A base's state while it drives at ``v_d`` (2), with a force that balances friction."""
    robot = scenario.robot
    force = drag(robot, np.asarray(v_d))[:, 0]
    torque = np.asarray(
        ca.evalf(force_to_wheel(ca.SX(robot.r), ca.SX(robot.l), ca.SX(ca.DM(force)))), dtype=float
    ).ravel()
    known = {INTEGRAL: force}
    return np.concatenate([
        np.zeros(0),
        *(torque if item.signal.unit == TORQUE[0].unit else known.get(item.signal, item.value)
          for item in state),
    ])  # fmt: skip
