"""Model-based barrier law of the paper.

Source: Eq. (9), Theorem 1.  Differences from the paper: V1/A and q = (v - v_c1)/A are evaluated by
cancellation-free forms and take their limits where A = 0 (the printed A^-1 := 0 drops the
feed-forward there); rho is one gain per axis, as Section V uses it.  Options that the paper does
not have: decay = "exact" replaces rho by (1 - exp(-rho T))/T, one Newton step towards the decay
exp(-rho T) of a whole period, which no period makes overshoot; barrier = "smooth", the form of
`smooth_barrier`.  Choose it when mass, inertia and friction are known and the control period is
well below the stable limit.
"""

from collections.abc import Mapping

import casadi as ca

from wmr_ctrl.core.fields.section import quantity
from wmr_ctrl.world.model.system import System

from .context import LawContext
from .law import BarrierChoice, Basis, Inside, Law, Traits


class ModelBasedGains(BarrierChoice, key="gains.mb"):
    """Gains of the model-based law."""

    rho: tuple[float, float] = quantity(
        (15.0, 57.6), "1/s", "decay rate of V1 per axis, Eq. (9)", above=0.0
    )
    decay: str = quantity(
        "rate", "1", "meaning of rho: a rate, or the exact decay over T", options=("rate", "exact")
    )


def build(context: LawContext) -> System:
    """F = M1 (-rho V1/A + q vc0') + F1, Eq. (9)."""
    rate = decay_rate(context)
    return _driving(context, rate, context.per_axis("V1_over_A"), context.per_axis("q"))


def inside(context: LawContext) -> Inside:
    """The law where the barrier is inactive: V1/A = (v - v_c0)/2, q = 1 (ledger: corridor.mb)."""
    within = {"v": (context.v, context.u2), "v_c0": (context.v_c0, context.u2)}
    ratio = (context.v - context.v_c0) / 2
    return Inside(_driving(context, decay_rate(context), ratio, ca.SX(1)), within)


def _driving(context: LawContext, rate: ca.SX, V1_over_A: ca.SX, q: ca.SX) -> System:
    command = -rate * V1_over_A + q * context.v_c0_dot
    return context.system("model-based (MB)", context.mass * command + context.friction)


def decay_rate(context: LawContext) -> ca.SX:
    """Rate (2,) [1/s] that multiplies V1/A: rho, or (1 - exp(-rho T))/T."""
    rho = context.gain("rho")
    if context.own(ModelBasedGains).decay == "rate":
        return rho
    return -ca.expm1(-rho * context.period) / context.period


def rule(basis: Basis) -> Mapping[str, object]:
    """The rate derived from the period and the path."""
    return {"rho": basis.rho}


TRAITS = Traits(auxiliary=True, barrier=True, model=True, theorem=1)
LAW = Law("mb", ModelBasedGains, build, TRAITS, __doc__, tuned=("rho",), inside=inside, rule=rule)
