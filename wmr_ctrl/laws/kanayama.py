"""Kinematic tracking with limited commands and computed torque (kanayama).

Source: Kanayama, Kimura, Miyazaki and Noguchi, A stable tracking control method for an autonomous
mobile robot (ICRA 1990), above a velocity loop as it is commonly built around it:

    wanted   = (v1_d cos e3 + kx e1,  v2_d + v1_d (ky e2 + kt sin e3))
    command  = last + cut(cut(wanted, share v_u1) - last, a_max T),  last: the previous command
    a        = v_d' + (1 - exp(-rate T))/T (command - v)
    F        = M1 a + F1(v + T a) + observer

Differences from the paper: not in it, and not Eq. (7), whose angular gain does not fade with v1_d.
No barrier and no theorem: it cuts the command a margin below the limit, and whatever overshoots
the command overshoots the margin.  The first command starts from the measured velocity; the
observer (wo = 0 switches it off) makes up for friction and mass that differ from the model.  With
delay > 0 all of this is about the instant at which the command acts (see `prediction`).
A base that takes velocities is sent the command itself, which starts from what was sent to it.
Choose it to have something plain and good to compare with, or behind the guard.
"""

from __future__ import annotations

from collections.abc import Callable

import casadi as ca

from wmr_ctrl.fields.section import quantity
from wmr_ctrl.laws.context import AXES, LawContext
from wmr_ctrl.laws.law import Inside, Law, Predicting, Traits
from wmr_ctrl.laws.observer import STARTED, Observer
from wmr_ctrl.laws.prediction import ahead
from wmr_ctrl.model.system import System, port
from wmr_ctrl.signals import ASKED, SENT_BEFORE, Signal

COMMAND = Signal("v_command", "m/s, rad/s", "velocity commanded at the previous sample", 2)

Limiting = Callable[[str, ca.SX, ca.SX], ca.SX]
"""Limits values (2,) to a size (2,) that is called by a name."""


class KanayamaGains(Predicting, key="gains.kanayama"):
    """Gains of the kinematic law and of the velocity loop below it, per axis where two."""

    k: tuple[float, float, float] = quantity(
        (4.0, 64.0, 16.0), unit="1/s, 1/m2, 1/m", doc="kx, ky, kt of the kinematic law", above=0.0
    )
    rate: tuple[float, float] = quantity(
        (20.0, 10.0), unit="1/s", doc="bandwidth of the velocity loop", above=0.0
    )
    wo: float = quantity(
        5.0, unit="1/s", doc="bandwidth of the disturbance observer, 0 = off", minimum=0.0
    )
    share: float = quantity(
        0.95, unit="1", doc="share of limits.v_u1 that is commanded at most", above=0.0, maximum=1.0
    )
    a_max: tuple[float, float] = quantity(
        (2.0, 6.0), unit="m/s2, rad/s2", doc="largest rate of the command", above=0.0
    )


def build(context: LawContext) -> System:
    """F = M1 a + F1(v + T a) + observer, a = v_d' + (1 - exp(-rate T))/T (command - v)."""
    return _around(context, _cut_named)


def inside(context: LawContext) -> Inside:
    """The law whose command is cut nowhere."""
    within: dict[str, tuple[ca.SX, ca.SX]] = {}

    def whole(name: str, values: ca.SX, most: ca.SX) -> ca.SX:
        within[name] = values, most
        return values

    return Inside(_around(context, whole), within)


def _around(context: LawContext, limited: Limiting) -> System:
    """The law around what cuts its command, (2,) at a size (2,), which is named."""
    observer = Observer(context, context.gain("wo"), context.friction_at)
    last = port(COMMAND)
    then, sent = ahead(context, observer.force)
    command = _commanded(then, ca.if_else(observer.started > 0, last.sym, then.v), limited)
    pull = -ca.expm1(-context.gain("rate") * context.period) / context.period
    a = then.v_d_dot + pull * (command - then.v)
    asked = context.mass * a + context.friction_at(then.v + context.period * a)
    return context.system(
        "kinematic tracking with limited commands (kanayama)",
        asked + observer.force,
        (last, *observer.state),
        ca.vertcat(command, observer.update),
        observer.diagnostics,
        (observer.input, *sent),
    )


def build_command(context: LawContext) -> System:
    """Velocity that is sent to a base which follows it by a loop of its own."""
    before, started = port(SENT_BEFORE), port(STARTED)
    start = ca.if_else(started.sym > 0, before.sym, context.v)
    return context.system(
        "kinematic tracking with limited commands (kanayama)",
        _commanded(context, start, _cut_named),
        (started,),
        ca.SX(1),
        further_inputs=(before,),
        asked=ASKED,
    )


def _commanded(context: LawContext, start: ca.SX, limited: Limiting) -> ca.SX:
    top, most = context.gain("share") * context.u1, context.gain("a_max") * context.period
    wanted = limited("the command", wanted_velocity(context), top)
    return start + limited("the command's change", wanted - start, most)


def wanted_velocity(context: LawContext) -> ca.SX:
    """Kanayama's velocity (2,) [m/s, rad/s], before any limit."""
    kx, ky, kt = ca.vertsplit(context.gain("k"))
    (e1, e2, e3), (v1_d, v2_d) = ca.vertsplit(context.e), ca.vertsplit(context.v_d)
    return ca.vertcat(v1_d * ca.cos(e3) + kx * e1, v2_d + v1_d * (ky * e2 + kt * ca.sin(e3)))


def cut(values: ca.SX, most: ca.SX) -> ca.SX:
    """Values (2,) within -most and most."""
    return ca.vertcat(*(ca.fmax(-most[i], ca.fmin(most[i], values[i])) for i in AXES))


def _cut_named(_: str, values: ca.SX, most: ca.SX) -> ca.SX:
    return cut(values, most)


TRAITS = Traits(model=True, observer=True)
LAW = Law(
    "kanayama",
    KanayamaGains,
    build,
    TRAITS,
    __doc__,
    ("k", "rate", "wo", "a_max"),
    build_command,
    inside,
)
