"""Adaptive sliding mode, a stand-in for the paper's reference [32].

Source: the usual form of an adaptive sliding-mode dynamic controller.  Differences from the paper:
the law of [32] is not in the paper's text, so form and gains are READ INTO the paper; what is found
with it says nothing about [32] itself.  s = v_c0 - v; mass and friction are estimated per axis from
zero.  Choose it to compare with: it tracks best of the four because it ignores the velocity limit.
"""

from collections.abc import Mapping

import casadi as ca

from wmr_ctrl.core.fields.section import Section, quantity
from wmr_ctrl.core.signals import Signal
from wmr_ctrl.world.model.system import Output, System, port

from .context import LawContext
from .law import Basis, Law, Traits

MASS = Signal("m_hat", "kg, kg.m2", "estimated mass and inertia, after the sample's update", 2)
FRICTION = Signal("F_hat", "N, N.m", "estimated Coulomb friction, after the sample's update", 2)


class SmcGains(Section, key="gains.smc"):
    """Gains of the stand-in, per axis (linear, angular) where there are two."""

    K: tuple[float, float] = quantity((200.0, 20.0), "N.s/m, N.m.s/rad", "gain on s", minimum=0.0)
    eta: tuple[float, float] = quantity((5.0, 0.5), "N, N.m", "switching gain", minimum=0.0)
    boundary: float = quantity(0.1, "m/s", "half-width of the boundary layer of sat", above=0.0)
    v_s: float = quantity(0.01, "m/s", "smoothing speed of the friction estimate", above=0.0)
    g_m: float = quantity(0.5, "kg.s2/m2", "adaptation gain of the mass", minimum=0.0)
    g_F: float = quantity(50.0, "N/m", "adaptation gain of the friction", minimum=0.0)
    axis_scale: tuple[float, float] = quantity(
        (1.0, 0.1), "1", "share of the adaptation per axis", minimum=0.0
    )


def build(context: LawContext) -> System:
    """F = m^ vc0' + F^ tanh(v/v_s) + K s + eta sat(s/boundary); estimates by explicit Euler."""
    mass, force_hat = port(MASS), port(FRICTION)
    s = context.v_c0 - context.v
    shape = ca.tanh(context.v / context.gain("v_s"))
    saturated = ca.fmax(-1, ca.fmin(1, s / context.gain("boundary")))
    learnt = mass.sym * context.v_c0_dot + force_hat.sym * shape
    force = learnt + context.gain("K") * s + context.gain("eta") * saturated
    step = context.period * context.gain("axis_scale") * s
    mass_next = mass.sym + step * context.gain("g_m") * context.v_c0_dot
    force_next = force_hat.sym + step * context.gain("g_F") * shape
    own = (Output(MASS, mass_next), Output(FRICTION, force_next))
    return context.system(
        "adaptive SMC (stand-in)", force, (mass, force_hat), ca.vertcat(mass_next, force_next), own
    )


def rule(basis: Basis) -> Mapping[str, object]:
    """Gains derived from the robot and its path."""
    m, inertia = basis.mass
    return {
        "K": basis.damping,
        "eta": tuple(0.02 * gain for gain in basis.damping),
        "boundary": 0.1 * basis.limits[0],
        "g_m": 0.01 * m,
        "g_F": 0.1 * m,
        "axis_scale": (1.0, inertia / m),
    }


TRAITS = Traits(auxiliary=True, estimates=True, integrates=True)
LAW = Law("smc", SmcGains, build, TRAITS, __doc__, tuned=("K", "eta"), rule=rule)
