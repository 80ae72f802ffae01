"""Toy law: drives the velocity to v_c0 in proportion.

Source: none, it shows what another package's law looks like.
Differences from the paper: it is not in there.
Choose it never.
"""

from __future__ import annotations

import casadi as ca

from wmr_ctrl.control.laws.law import Law, Traits
from wmr_ctrl.core.fields.section import Section, quantity
from wmr_ctrl.core.signals import Signal
from wmr_ctrl.world.model.system import port

SUM = Signal("toy_sum", "m, rad", "integral of the velocity error", 2)


class ToyGains(Section, key="gains.toy"):
    """One gain per axis."""

    K: tuple[float, float] = quantity((200.0, 20.0), unit="kg/s, kg.m2/s", doc="gain", above=0.0)


def build(context):
    """F = K (v_c0 - v), with a memory that nothing reads."""
    memory, error = port(SUM), context.v_c0 - context.v
    force = ca.vertcat(*(context.gain("K")[i] * error[i] for i in (0, 1)))
    return context.system("toy law", force, (memory,), memory.sym + context.period * error)


LAW = Law("toy", gains=ToyGains, build=build, traits=Traits(auxiliary=True), doc=__doc__ or "")
