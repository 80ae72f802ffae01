"""Reduction of a command to what the base can do, before it is filtered.

A base with a least turning radius cannot turn on the spot: omega is limited to |v| over that
radius.  With filter.least a command within the dead band becomes 0 or b, the least command that
acts, so that the base moves as requested on average.  With r, the requested but not yet sent sum, a
pulse of b begins once |r + u| >= b and ends once r + u has changed its sign: |r| stays within b.
The filter treats the result like any other command.
"""

from dataclasses import replace

import casadi as ca

from wmr_ctrl.core.signals import ASKED, LARGEST, Signal
from wmr_ctrl.world.model.system import Output, Parameters, Port, System, port
from wmr_ctrl.world.scenario import Scenario
from wmr_ctrl.world.wheel_commands import from_rims, to_rims

from .channels import FLAGS, TURN_RADIUS, within

JUST_ABOVE = 1 + 2.0**-26
"""Share of a dead band at which a command acts, whatever is rounded."""
OWN = (
    ("rest", "m/s, rad/s", "what was asked for and not sent"),
    ("way", "1", "sign of the least command that was sent last, or 0"),
)


def turning(asked: ca.SX, radius: ca.SX) -> ca.SX:
    """The command (2,) whose radius is at least ``radius``, with the same v."""
    most = ca.fabs(asked[0]) / radius
    tight = ca.logic_and(ca.fabs(asked[1]) > most, within(asked[1], LARGEST))
    omega = ca.if_else(tight, ca.sign(asked[1]) * most, asked[1])
    return ca.vertcat(asked[0], omega)


def turned(scenario: Scenario, p: Parameters, asked: ca.SX) -> ca.SX:
    """Part of the command ``asked`` (2,) that a base of this scenario can follow."""
    able = not scenario.takes_velocity or not scenario.base.min_radius
    return asked if able else turning(asked, p.take("base.min_radius"))


def least_or_none(asked: ca.SX, least: ca.SX, rest: ca.SX, way: ca.SX) -> tuple[ca.SX, ...]:
    """Command (2,) that is 0 or large enough to act, the sum not yet sent, and the pulse's sign
    (2,).
    """
    total = rest + asked
    begins = ca.if_else(ca.fabs(total) >= least, ca.sign(total), 0)
    now = ca.if_else(total * way > 0, way, begins)
    small = ca.logic_and(ca.fabs(asked) < least, asked != 0)
    sent = ca.if_else(small, now * least, asked)
    return sent, ca.if_else(small, total - sent, 0), ca.if_else(small, now, 0)


def pulsed(
    scenario: Scenario, p: Parameters, asked: ca.SX
) -> tuple[ca.SX, list[Port], list[ca.SX]]:
    """Command (2,) made 0 or large enough to act, for v and omega, then for each rim; state and its
    update.
    """
    base, state, following = scenario.base, list[Port](), list[ca.SX]()
    for name, size in (("deadband", max(base.deadband)), ("wheel_deadband", base.wheel_deadband)):
        if not scenario.filter.least or size == 0:
            continue
        rims, least = name != "deadband", p.take(f"base.{name}") * JUST_ABOVE
        own = [port(Signal(f"{name}_{what}", unit, said, 2)) for what, unit, said in OWN]
        state += own
        l = p.take("robot.l") if rims else ca.SX(1)
        parts = to_rims(asked, l) if rims else asked
        parts, *updates = least_or_none(parts, least, own[0].sym, own[1].sym)
        asked, following = from_rims(parts, l) if rims else parts, [*following, *updates]
    return asked, state, following


def for_base(system: System, scenario: Scenario) -> System:
    """A filter that receives only what the base can do."""
    p = Parameters(scenario, system.params)
    (asked,) = (item.sym for item in system.inputs if item.signal == ASKED)
    acts, state, following = pulsed(scenario, p, asked)
    able = turned(scenario, p, acts)
    if able is asked:
        return system
    exprs = [system.update, *(item.expr for item in system.outputs)]
    update, *outputs = ca.substitute(exprs, [asked], [able])
    tight = ca.if_else(able[1] == acts[1], 0, TURN_RADIUS)
    told = [
        Output(item.signal, expr + tight if item.signal == FLAGS else expr)
        for item, expr in zip(system.outputs, outputs, strict=True)
    ]
    return replace(
        system, update=ca.vertcat(update, *following), outputs=tuple(told), params=p.ports,
        state=(*system.state, *state),
    )  # fmt: skip
