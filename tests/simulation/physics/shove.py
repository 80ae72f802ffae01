"""A single push along the heading, as another package would add it; the guard does not know it."""

from __future__ import annotations

from wmr_ctrl.core.fields.section import Section, quantity
from wmr_ctrl.core.signals import BODY_FORCE, Signal
from wmr_ctrl.core.symbolic import ca
from wmr_ctrl.world.effect import Bound, Effect, EffectRole
from wmr_ctrl.world.model.system import Output, Parameters, System, port

COUNT = Signal("shove_count", "1", "samples so far")


class Shove(Section, key="shove"):
    """Size, beginning and length."""

    force: float = quantity(0.0, unit="N", doc="force along the heading", minimum=0)
    start: float = quantity(0.0, unit="s", doc="when it begins", minimum=0)
    time: float = quantity(0.2, unit="s", doc="how long it lasts", above=0)


def build(scenario):
    """Sampled System: the count of samples to the thrust."""
    p, count = Parameters(scenario), port(COUNT)
    t, start = count.sym * p.take("clock.control"), p.take("shove.start")
    half = p.take("clock.control") / 2
    acts_now = ca.logic_and(t > start - half, t < start + p.take("shove.time") - half)
    thrust = ca.if_else(acts_now, p.take("shove.force"), 0)
    return System(
        "shove",
        "a single push",
        state=(count,),
        params=p.ports,
        update=count.sym + 1,
        outputs=(Output(BODY_FORCE[0], thrust),),
        period=scenario.clock.control,
    )


SHOVE = Effect("shove", EffectRole.DISTURBANCE, Shove, build, lambda scenario: Bound())
