"""Commands that a base cannot follow, reduced to what it can do before they are filtered.

A base with a least turning radius cannot turn on the spot: omega is limited to |v| over that
radius.
"""

from dataclasses import replace

import casadi as ca

from wmr_ctrl.core.signals import ASKED, LARGEST
from wmr_ctrl.world.model.system import Output, Parameters, System
from wmr_ctrl.world.scenario import Scenario

from .channels import FLAGS, TURN_RADIUS, within


def turning(asked: ca.SX, radius: ca.SX) -> ca.SX:
    """The command (2,) whose radius is at least ``radius``, with the same v."""
    most = ca.fabs(asked[0]) / radius
    tight = ca.logic_and(ca.fabs(asked[1]) > most, within(asked[1], LARGEST))
    omega = ca.if_else(tight, ca.sign(asked[1]) * most, asked[1])
    return ca.vertcat(asked[0], omega)


def turned(scenario: Scenario, p: Parameters, asked: ca.SX) -> ca.SX:
    """The part of the command ``asked`` (2,) that a base of this scenario can follow."""
    able = not scenario.takes_velocity or not scenario.base.min_radius
    return asked if able else turning(asked, p.take("base.min_radius"))


def for_base(system: System, scenario: Scenario) -> System:
    """A filter that receives only what the base can do."""
    p = Parameters(scenario, system.params)
    (asked,) = (item.sym for item in system.inputs if item.signal == ASKED)
    able = turned(scenario, p, asked)
    if able is asked:
        return system
    exprs = [system.update, *(item.expr for item in system.outputs)]
    update, *outputs = ca.substitute(exprs, [asked], [able])
    tight = ca.if_else(able[1] == asked[1], 0, TURN_RADIUS)
    told = [
        Output(item.signal, expr + tight if item.signal == FLAGS else expr)
        for item, expr in zip(system.outputs, outputs, strict=True)
    ]
    return replace(system, update=update, outputs=tuple(told), params=p.ports)
