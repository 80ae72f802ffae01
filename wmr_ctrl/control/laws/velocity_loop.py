"""Velocity loop with computed torque below a law that commands velocities.

Source: as it is commonly built around a kinematic law:

    command  = last + cut(cut(wanted, share v_u1) - last, a_max T),  last: the previous command
    a        = v_d' + (1 - exp(-rate T))/T (command - v)
    F        = M1 a + F1(v + T a) + observer

The first command starts from the measured velocity.  The observer (wo = 0 switches it off)
compensates friction and mass that differ from the model.  With delay > 0 all of this is about the
instant at which the command acts (see `prediction`).  A base that takes velocities receives the
command itself.  Its ``last`` is the velocity that was sent, so nothing winds up behind a filter.
"""

from collections.abc import Callable

import casadi as ca

from wmr_ctrl.core.fields.section import quantity
from wmr_ctrl.core.signals import ASKED, SENT_BEFORE, Signal
from wmr_ctrl.world.model.system import System, port

from .context import LawContext
from .law import Basis, Predicting
from .observer import STARTED, Observer
from .prediction import ahead

COMMAND = Signal("v_command", "m/s, rad/s", "velocity commanded at the previous sample", 2)

Limiting = Callable[[str, ca.SX, ca.SX], ca.SX]
"""Limits values (2,) to a size (2,) that is called by a name."""
Wanting = Callable[[LawContext], ca.SX]
"""Velocity (2,) [m/s, rad/s] that a law wants, before any limit."""
CHANGE = "the command's change"
"""Name of what is limited last: a first command's is counted from the measured velocity."""


class VelocityLoopGains(Predicting, key="gains"):
    """Gains of the velocity loop, per axis where two."""

    rate: tuple[float, float] = quantity(
        (20.0, 10.0), "1/s", "bandwidth of the velocity loop", above=0.0
    )
    wo: float = quantity(5.0, "1/s", "bandwidth of the disturbance observer, 0 = off", minimum=0.0)
    share: float = quantity(
        0.95, "1", "largest command as a share of limits.v_u1", above=0.0, maximum=1.0
    )
    a_max: tuple[float, float] = quantity(
        (2.0, 6.0), "m/s2, rad/s2", "largest rate of the command", above=0.0
    )


def loop_rule(basis: Basis) -> dict[str, object]:
    """Gains of the loop derived from the base and its path."""
    return {"rate": basis.rate, "wo": basis.wo, "a_max": basis.accel}


def cut(values: ca.SX, most: ca.SX) -> ca.SX:
    """Values (2,) limited to the range from -most to most."""
    return ca.fmax(-most, ca.fmin(most, values))


def cut_named(_: str, values: ca.SX, most: ca.SX) -> ca.SX:
    """`cut` of values (2,), ignoring the limit's name."""
    return cut(values, most)


def largest_command(context: LawContext) -> ca.SX:
    """Largest command (2,) [m/s, rad/s]: a share of the limits."""
    return context.gain("share") * context.u1


def with_torque(
    context: LawContext, title: str, wanting: Wanting, limited: Limiting = cut_named
) -> System:
    """The law as a System whose output is the force F."""
    observer = Observer(context, context.gain("wo"), context.friction_at)
    last = port(COMMAND)
    then, sent = ahead(context, observer.force)
    start = ca.if_else(observer.started > 0, last.sym, then.v)
    command = _commanded(then, start, wanting, limited)
    pull = -ca.expm1(-context.gain("rate") * context.period) / context.period
    a = then.v_d_dot + pull * (command - then.v)
    asked = context.mass * a + context.friction_at(then.v + context.period * a)
    state, update = (last, *observer.state), ca.vertcat(command, observer.update)
    force, inputs = asked + observer.force, (observer.input, *sent)
    return context.system(title, force, state, update, observer.diagnostics, inputs)


def with_command(
    context: LawContext, title: str, wanting: Wanting, limited: Limiting = cut_named
) -> System:
    """The law as a System whose output is the velocity for a base with its own loop."""
    before, started = port(SENT_BEFORE), port(STARTED)
    start = ca.if_else(started.sym > 0, before.sym, context.v)
    v = _commanded(context, start, wanting, limited)
    return context.system(title, v, (started,), ca.SX(1), further_inputs=(before,), asked=ASKED)


def _commanded(context: LawContext, start: ca.SX, wanting: Wanting, limited: Limiting) -> ca.SX:
    top, most = largest_command(context), context.gain("a_max") * context.period
    wanted = limited("the command", wanting(context), top)
    return start + limited(CHANGE, wanted - start, most)
