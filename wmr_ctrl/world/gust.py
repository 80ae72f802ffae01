"""Gusts: coloured noise on the body that never exceeds a stated size.

Source: a first-order filter (time constant ``time``) of uniform numbers, one for each control
period, over which the force is held.
"""

from __future__ import annotations

from wmr_ctrl.core.fields.section import Section, quantity
from wmr_ctrl.core.signals import BODY_FORCE, Signal
from wmr_ctrl.core.symbolic import ca

from .effect import Bound, Effect, EffectRole, Scenario
from .model.system import UNIFORM, Parameters, System, draw, outputs, port

NUMBERS = Signal("gust", "1", "uniform numbers on [-1, 1)", 2)
SHARE = Signal("gust_share", "1", "force and moment as shares of their size", 2)


class Gust(Section, key="gust"):
    """Size and colour."""

    size: tuple[float, float] = quantity(
        (0.0, 0.0), "N, N.m", "largest force, moment on the body", minimum=0
    )
    time: float = quantity(1.0, "s", "time constant of the noise's filter", above=0)


def build(scenario: Scenario) -> System:
    """Sampled System: random numbers to force on the body."""
    p, share = Parameters(scenario), port(SHARE)
    size = p.take("gust.size")
    number = draw(NUMBERS, UNIFORM, ca.logic_or(size[0] > 0, size[1] > 0))
    keep = ca.exp(-p.take("clock.control") / p.take("gust.time"))
    now = filtered(share.sym, number.port.sym, keep)
    shown = outputs(BODY_FORCE, size * now)
    return System(
        "gust", "gusts", state=(share,), params=p.ports, update=now, outputs=shown, draws=(number,)
    )


def filtered(share: ca.SX, number: ca.SX, keep: ca.SX) -> ca.SX:
    """Next share of the size: weighted mean of the last one and a new number."""
    return keep * share + (1 - keep) * number


def bound(scenario: Scenario) -> Bound:
    """Their size: a mean of numbers within [-1, 1] stays there (ledger: world.gust)."""
    return Bound(dbar=scenario.section(Gust).size)


GUST = Effect("gust", EffectRole.DISTURBANCE, Gust, build, bound, switches=("size",))
