"""Lag of the drives: the torque follows what arrives by a first order, exact over a plant step."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from wmr_ctrl.fields.section import Section, quantity
from wmr_ctrl.model.parameters import Parameters
from wmr_ctrl.model.system import Output, System, port, ports, stack
from wmr_ctrl.signals import TORQUE, Signal
from wmr_ctrl.symbolic import ca
from wmr_ctrl.world.effect import Bound, Effect, EffectRole, Rate

if TYPE_CHECKING:
    from wmr_ctrl.scenario import Scenario

ACTING = Signal("tau_lagging", "N.m", "torque behind the lag (right, left)", 2)


@dataclass(frozen=True, kw_only=True)
class Lag(Section):
    """How slow the torque is."""

    KEY: ClassVar[str] = "actuator"

    lag: float = quantity(0.0, unit="s", doc="time constant of the torque's lag", minimum=0)


def build(scenario: Scenario) -> System:
    """System of the plant's rate: torque that arrives to torque that acts [N m]."""
    torque, acting, p = ports(TORQUE), port(ACTING), Parameters(scenario)
    wanted = stack(item.sym for item in torque)
    decay = ca.exp(-p.take("clock.plant") / p.take("actuator.lag"))
    following = wanted + decay * (acting.sym - wanted)
    return System(
        "lag",
        "first-order lag of the drives",
        torque,
        (acting,),
        p.ports,
        following,
        tuple(Output(signal, following[i]) for i, signal in enumerate(TORQUE)),
        period=scenario.clock.plant,
    )


def acts(scenario: Scenario) -> bool:
    """Whether there is a lag."""
    return scenario.section(Lag).lag > 0


def bound(scenario: Scenario) -> Bound:
    """None that holds: the guard's theorem knows torque that acts at once or after a delay."""
    lag = scenario.section(Lag).lag
    if lag == 0:
        return Bound()
    return Bound(
        void=f"actuator.lag = {lag:g} s: the guard's theorem knows torque that acts at once or "
        "after a delay, so it filters but promises nothing here."
    )


LAG = Effect(
    name="lag",
    role=EffectRole.DRIVE,
    section=Lag,
    build=build,
    acts=acts,
    bound=bound,
    rate=Rate.STEP,
)
