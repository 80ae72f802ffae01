"""Lag of the drives: the torque follows the command by a first-order lag, exact per plant step.

With a spread the time constant changes in each control period, uniform between lag (1 - spread) and
lag (1 + spread); laws and observer assume the mean.  Source: motors whose winding warms up, drives
of unknown tuning.
"""

from __future__ import annotations

import math

from wmr_ctrl.core.fields.section import Section, quantity
from wmr_ctrl.core.signals import TORQUE, Signal
from wmr_ctrl.core.symbolic import ca

from .effect import Bound, Effect, EffectRole, Rate, Scenario
from .model import system

ACTING = Signal("tau_lagging", "N.m", "torque behind the lag (right, left)", 2)
NUMBERS = Signal("lag", "1", "uniform numbers on [-1, 1) of a sample", 2)
ROUNDING = 2.0**-34
"""Bound of the difference between expm1 and exp - 1, for a lag of up to 2^17 plant steps."""
MANY = 500.0
"""Time constants in a step after which nothing is left."""


class Lag(Section, key="actuator"):
    """Time constant of the torque, and its spread."""

    lag: float = quantity(0.0, "s", "time constant of the torque's lag", minimum=0, usual=(0, 2))
    lag_spread: float = quantity(
        0.0, "1", "share by which the time constant may vary", minimum=0, below=1
    )


def build(scenario: Scenario) -> system.System:
    """Plant-rate System: from arriving to acting torque [N m]."""
    torque, acting, p = system.ports(TORQUE), system.port(ACTING), system.Parameters(scenario)
    wanted = system.stack(item.sym for item in torque)
    time = p.take("actuator.lag")
    draws: tuple[system.Draw, ...] = ()
    if scenario.section(Lag).lag_spread > 0:
        spread = p.take("actuator.lag_spread")
        draws = (system.draw(NUMBERS, system.UNIFORM, spread > 0, held=True),)
        time = time * (1 + spread * draws[0].port.sym[0])
    decay = ca.exp(-p.take("clock.plant") / time)
    following = followed(wanted, decay, acting.sym)
    return system.System(
        "lag",
        "first-order lag of the drives",
        inputs=torque,
        state=(acting,),
        params=p.ports,
        update=following,
        outputs=system.outputs(TORQUE, following),
        draws=draws,
    )


def followed(wanted: ca.SX, decay: ca.SX, acting: ca.SX) -> ca.SX:
    """Torque [N m] after a step, in which the share ``decay`` of the difference remains."""
    return wanted + decay * (acting - wanted)


def bound(scenario: Scenario) -> Bound:
    """Range of the time constant; if it varies, the lower end is slightly below lag (1 - spread).

    The torque is held over a plant step h at its value of the step's end, which is earlier than a
    first-order lag.  With e = exp(-h/tau) of the smallest tau, a guard that assumes time constants
    from a = h e/(1 - e) on covers such a lag (ledger: world.lag.stepped); ROUNDING of it is
    subtracted, as a graph that compares h with a (1/e - 1) computes both.
    """
    lag, spread = scenario.section(Lag).lag, scenario.section(Lag).lag_spread
    if not spread:
        return Bound(lag=(lag, lag))
    least = stepped(lag * (1.0 - spread), scenario.clock.plant) * (1.0 - ROUNDING)
    return Bound(lag=(least, lag * (1.0 + spread)))


def stepped(lag: float, step: float) -> float:
    """Lower bound of the time constant [s] of a lag that is held over a plant step [s].

    About lag - step/2.
    """
    if lag == 0 or step / lag > MANY:
        return 0.0
    return equivalent_lag(step, math.expm1(step / lag))


def equivalent_lag(step: system.Number, growth: system.Number) -> system.Number:
    """`stepped` for growth = exp(step/lag) - 1, a number or a symbol."""
    return step / growth


LAG = Effect("lag", EffectRole.DRIVE, Lag, build, bound, switches=("lag",), rate=Rate.STEP)
